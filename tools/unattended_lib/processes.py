"""tools/unattended processes."""
import json
import os
import shutil
import subprocess
import time

from . import common


class Part:
    """One of the processes: its arguments, less -o, and the files that it makes."""

    def __init__(self, name, arguments, outputs):
        self.name, self.outputs = name, outputs
        self.arguments = [*arguments, "--threads", "1"]

    def command(self, args):
        return [args.render, *self.arguments, "--log-json"]


def parts(args):
    def scene(name):
        return os.path.join(args.scenes, f"{name}.xml")

    def one(name, path, *options):
        return Part(name, [scene(name), *options, "-o", path], [path])
    path = ["--method", "path", "--spp", "64", "--width", "96"]
    out = [one("cornell-box", "same.exr", "--width", "96"), one("cornell-box", "same.exr", "--width", "96"),
           one("cornell-box", "path.png", *path), one("furnace", "furnace.pfm", *path)]
    frames = [scene("cornell-box"), "--width", "64", "--frames", "1-8", "--camera-path", "path.json", "-o", "f.#.pfm"]
    out += [Part(f"shard {i} of 4", [*frames, "--shard", f"{i}/4"], [f"f.{2 * i - 1}.pfm", f"f.{2 * i}.pfm"])
            for i in (1, 2, 3, 4)]
    more = [one("spheres", f"spheres.{i}.exr", *path) for i in range(max(args.count - len(out), 0))]
    return (out + more)[:args.count]


def run(args):
    table = common.Table(f"{args.count} processes at once, --threads 1 each, one cache of kernels, empty at first, and one log.",
                         ["process", "files", "alone", "among the others", "bytes as alone"])
    chosen = parts(args)
    with common.work_folder(args) as folder:
        alone = {}
        lone, together = os.path.join(folder, "lone"), os.path.join(folder, "together")
        for place in (lone, together):
            shutil.rmtree(place, ignore_errors=True)
            os.makedirs(place)
            common.write(place, "path.json", common.CAMERA_PATH)
        for name in ("caches-lone", "caches"):
            shutil.rmtree(os.path.join(folder, name), ignore_errors=True)
        environment = common.own_caches(os.path.join(folder, "caches-lone"))
        for part in chosen:
            begun = time.monotonic()
            done = common.call(args, [*part.arguments, "--overwrite"], lone, environment)
            alone[part] = time.monotonic() - begun
            if done.returncode != 0:
                raise SystemExit(f"unattended: {part.name} alone: {done.stderr.strip()}")
        environment = common.own_caches(os.path.join(folder, "caches"))
        begun, ended = time.monotonic(), {}
        with open(os.path.join(folder, "log.json"), "ab") as log:
            running = {part: subprocess.Popen(part.command(args), cwd=together, env=environment, stderr=log,
                                              stdin=subprocess.DEVNULL) for part in chosen}
            while len(ended) < len(running):
                for part, process in running.items():
                    if part not in ended and process.poll() is not None:
                        ended[part] = time.monotonic() - begun
                time.sleep(.01)
        for part in chosen:
            good = True
            if running[part].returncode != 0:
                table.fail(f"{part.name}: exit status {running[part].returncode}, expected 0")
            for path in part.outputs:
                found = common.read(os.path.join(together, path))
                if found is None or found != common.read(os.path.join(lone, path)):
                    table.fail(f"{part.name}: {path} is not as it is alone")
                    good = False
            table.add(part.name, ", ".join(part.outputs), f"{alone[part]:.1f} s", f"{ended[part]:.1f} s", "yes" if good else "**no**")
        known = {"path.json", *(path for part in chosen for path in part.outputs)}
        for path in common.files_in(together):
            if path not in known:
                table.fail(f"{path} was left")
        for path in common.litter_in(os.path.join(folder, "caches")):
            table.fail(f"caches/{path} was left")
        lines = log_lines(os.path.join(folder, "log.json"), table)
    table.note(f"{len(chosen)} processes, all done after {max(ended.values()):.1f} s on {len(os.sched_getaffinity(0))} cores; "
               f"each of the log's {lines} lines is a whole JSON object.\n" if not table.wrong else "")
    return table


def log_lines(path, table):
    with open(path, encoding="utf-8") as file:
        lines = file.readlines()
    for line in lines:
        try:
            if "message" not in json.loads(line):
                table.fail(f"the log has a line without a message: {line.strip()}")
        except ValueError:
            table.fail(f"the log has a line that is no JSON: {line.strip()}")
    return len(lines)
