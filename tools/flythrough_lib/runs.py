"""Renders the flight in each way, as processes of `render`."""
import json
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import time

from . import BadInput

AOVS = "indirect,depth,normal,albedo"
WAYS = {"shared": "one process, one cache",
        "alone": "a process a frame, same seed",
        "seeds": "a process a frame, a seed each",
        "handed": "a process a frame, which hands its records on",
        "settled": "one process, all records of the flight known beforehand"}


def say(text):
    print(text, file=sys.stderr, flush=True)

QUALITY = ("--quality", "--method", "--spp", "--pixel-error", "--accuracy", "--hemisphere", "--min-spacing",
           "--max-spacing", "--gap-spacing", "--grid-paths")


def without(options, names):
    """Options of `render` less these, which have a value each."""
    kept, skip = [], False
    for option in options:
        if skip:
            skip = False
        elif option in names:
            skip = True
        elif option.split("=")[0] not in names:
            kept.append(option)
    return kept


class Runs:
    def __init__(self, o, options):
        self.o, self.options = o, options
        self.out = pathlib.Path(o.out)
        self.cpu = {}  # {way: [CPU seconds of each process]}

    def run(self, *line, options=None):
        """CPU seconds."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        options = self.options if options is None else options
        command = [self.o.render, self.o.scene, "-q", "--camera-path", self.o.path, *options, *map(str, line)]
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode:
            said = done.stderr.strip().splitlines()
            raise BadInput(said[-1] if said else f"{self.o.render} ended with status {done.returncode}")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def outputs(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        return ["-o", folder / "f.####.exr", "--stats", folder / "f.####.json", "--overwrite", "--aov", AOVS]

    def stats(self, way, frame):
        return self.json(self.out / way / f"f.{frame:04d}.json")

    @staticmethod
    def json(path):
        """Statistics beside a picture."""
        return json.loads(pathlib.Path(path).with_suffix(".json").read_text())

    def together(self, way, *more):
        """All frames in one process."""
        frames = ",".join(map(str, self.o.frames))
        self.cpu.setdefault(way, []).append(
            self.run(*self.outputs(self.out / way), "--frames", frames, "--seed", self.o.seed, *more))

    def each(self, way):
        """A process a frame."""
        records = self.out / f"{way}.records"
        records.unlink(missing_ok=True)
        for i, frame in enumerate(self.o.frames):
            seed = self.o.seed + (i if way == "seeds" else 0)
            more = []
            if way == "handed":
                more = ["--save-records", records] + (["--load-records", records] if i else [])
            self.cpu.setdefault(way, []).append(
                self.run(*self.outputs(self.out / way), "--frames", frame, "--seed", seed, *more))
            say(f"flythrough: {way}, frame {frame}: {self.cpu[way][-1]:.2f} CPU seconds")

    def all(self):
        """{way: [row a frame]}. The shared cache goes between all others: what slows the machine for a while slows one
        of its runs, whose median counts."""
        frames, shared = self.o.frames, []
        self.run(*self.outputs(self.out / "warm"), "--frames", frames[0])  # compiles the kernels
        shutil.rmtree(self.out / "warm")

        def once_more(*more):
            self.together("shared", *more)
            shared.append(self.rows("shared"))
            say(f"flythrough: shared: {self.cpu['shared'][-1]:.2f} CPU seconds")
        once_more()
        found = {}
        for way in self.o.ways:
            if way in ("shared", "settled"):
                continue
            self.each(way)
            found[way] = self.rows(way)
            once_more()
        if "settled" in self.o.ways:
            records = self.out / "shared.records"
            records.unlink(missing_ok=True)
            once_more("--save-records", records)
            self.together("settled", "--load-records", records)
            found["settled"] = self.rows("settled", shared[0][-1]["records"])
        for i, row in enumerate(shared[0]):
            for key in ("render_s", "total_s"):
                row[key] = statistics.median(rows[i][key] for rows in shared)
            if any(rows[i]["records_new"] != row["records_new"] for rows in shared):
                raise BadInput(f"frame {row['frame']}: records differ from run to run of the same command: an error in "
                               "the program, please report it")
        return {"shared": shared[0], **found}

    def rows(self, way, known=0):
        rows = []
        one = way in ("shared", "settled", "handed")
        for frame in self.o.frames:
            s = self.stats(way, frame)
            records = s["records"] + s["radiance_records"]["count"]
            rows.append({"frame": frame, "way": way, "render_s": s["wall_seconds"]["render"],
                         "total_s": s["wall_seconds"]["total"], "records": records,
                         "records_new": records - known, "hemisphere_rays": s["rays"]["hemisphere"]})
            if one:
                known = records
        return rows

    def extra(self, name, frame, *more):
        """A picture of another quality or method, rendered anew only if its command was another."""
        options = without(self.options, QUALITY)
        folder = self.out / "extra"
        stem = folder / f"{name}.{frame:04d}"
        command = json.dumps([os.path.abspath(self.o.scene), pathlib.Path(self.o.path).read_text(), frame, *options,
                              *map(str, more)])
        note = pathlib.Path(f"{stem}.txt")
        if not (note.exists() and note.read_text() == command):
            folder.mkdir(parents=True, exist_ok=True)
            began = time.monotonic()
            self.run("-o", folder / f"{name}.####.exr", "--stats", folder / f"{name}.####.json", "--overwrite", "--aov",
                     AOVS, "--frames", frame, *more, options=options)
            note.write_text(command)
            say(f"flythrough: {name}, frame {frame}: {time.monotonic() - began:.1f} s")
        return pathlib.Path(f"{stem}.exr")
