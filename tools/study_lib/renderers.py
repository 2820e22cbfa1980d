"""Runs `render` and `compare`."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

from . import BadInput, processes
from .ledger import file_hash

# What changes no kernel: a run that only warms the compilers' caches makes little of it.
LITTLE = {"--spp": "1", "--accuracy": "1", "--grid-paths": "4096"}
SLOW_BUILD = 1.0  # seconds of device stage `build`: kernels that come from a cache take less


def size_of(picture):
    """Width and height, by a process of its own (processes.py says why)."""
    code = ("import sys, OpenImageIO as o; i = o.ImageInput.open(sys.argv[1]); "
            "print(i.spec().width, i.spec().height) if i else sys.exit(1)")
    line = processes.output([sys.executable, "-c", code, str(picture)])
    if not line:
        raise BadInput(f"{picture}: an EXR or PFM that can be read was expected")
    return tuple(map(int, line.split()))


def compiled_kernels():
    """Kernels in PoCL's cache: a run after which there are more has compiled some."""
    folder = os.environ.get("POCL_CACHE_DIR") or \
        pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "pocl" / "kcache"
    return sum(1 for _, _, names in os.walk(folder) for n in names if n.endswith(".so"))


class Ours:
    def __init__(self, o, size):
        for path in (o.render, o.compare):
            if not os.access(path, os.X_OK):
                raise BadInput(f"{path}: no executable was found (tools/bootstrap render compare builds it)")
        self.o, self.hash, self._warm = o, file_hash(o.render), set()
        self.common = ["-q", "--threads", str(o.threads), "--width", str(size[0]), "--height", str(size[1])]
        for define in o.define:
            self.common += ["-D", define]
        if o.device:
            self.common += ["--device", o.device]
        self.common += o.render_option

    def definition(self, point):
        return {"program": self.hash, "options": list(point.options), "common": self.common}

    def command(self, point, seed, out):
        return [self.o.render, self.o.scene, "-o", str(out), *self.common, *point.options, "--seed", str(seed)]

    def _run(self, arguments):
        return processes.measured(arguments, self.o.threads, self.o.timeout)

    def warm(self, point):
        """Compiles the kernels of a point's options, by a picture that is quickly done."""
        options, i = [], 0
        while i < len(point.options):
            if point.options[i] in LITTLE:
                i += 2
                continue
            options.append(point.options[i])
            i += 1
        if tuple(options) in self._warm:
            return
        little = [x for pair in LITTLE.items() for x in pair]
        with tempfile.TemporaryDirectory(prefix="study.") as work:
            self._run([self.o.render, self.o.scene, "-o", os.path.join(work, "x.pfm"), *self.common, *options, *little])
        self._warm.add(tuple(options))

    def run(self, point, seed, out):
        self.warm(point)
        with tempfile.TemporaryDirectory(prefix="study.") as work:
            stats = os.path.join(work, "stats.json")
            for _ in range(2):  # again if kernels were compiled during the first
                before = compiled_kernels()
                cost = self._run(self.command(point, seed, out) + ["--stats", stats])
                with open(stats) as f:
                    s = json.load(f)
                build = s["stages"].get("build", {"seconds": 0})["seconds"]
                if build < SLOW_BUILD and compiled_kernels() == before:
                    break
        device = s["device"]
        return {**cost, "render_seconds": s["wall_seconds"]["render"],
                "device_seconds": sum(t["seconds"] for n, t in s["stages"].items() if n != "build"),
                "build_seconds": build, "rays": s["rays"]["total"],
                "records": s["records"] + s["radiance_records"]["count"], "peak_bytes": cost["peak_bytes"],
                "device_bytes": s["memory"]["device_peak_bytes"], "settings": s["settings"],
                "ran_on": f"{device['name']}, {device['platform']} {device['driver']}, "
                          f"{device['threads'] or 'all'} thread{'s' if device['threads'] != 1 else ''}",
                "version": f"Irradia {s['irradia']}", "command": self.command(point, seed, "OUT.exr")}


class Judge:
    """Errors of pictures, by `compare`."""

    def __init__(self, o):
        self.o = o
        files = [f for f in (o.reference, o.ref_b, o.mask) if f]
        self.against = [file_hash(f) for f in files] + [o.ref_error, bool(o.ref_b), bool(o.mask), file_hash(o.compare)]
        self.options = ["--ref-a", o.reference, "--ref-b", o.ref_b] if o.ref_b else \
            [o.reference] + (["--ref-error", repr(o.ref_error)] if o.ref_error else [])
        self.options += ["--mask", o.mask] if o.mask else []

    def _compare(self, picture, *more):
        done = subprocess.run([self.o.compare, str(picture), *self.options, "--json", *map(str, more)],
                              capture_output=True, text=True)
        if done.returncode != 0:
            raise BadInput((done.stderr.strip().splitlines() or [f"{self.o.compare} failed"])[-1])
        return json.loads(done.stdout)

    def errors(self, picture):
        m = self._compare(picture)
        return {k: m[k] for k in ("rel_rmse", "rel_rmse_raw", "relmse", "mean_bias", "mean_bias_interval_95", "mse",
                                  "mean_reference", "ssim", "max_error", "pixels")}

    def map(self, picture, out, scale):
        self._compare(picture, "--heatmap", out, "--heatmap-scale", repr(scale))
