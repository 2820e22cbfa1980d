"""Other renderers, measured in turn with ours: Mitsuba 3 with and without OIDN, RADIANCE. All from PyPI."""
import glob
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from crosscheck_lib import MITSUBA

from . import BadInput, processes
from .ledger import file_hash
from .sweeps import Point

PACKAGES = {"mitsuba": (f"mitsuba=={MITSUBA}", "numpy"), "pyoidn": ("pyoidn==2.5.1.0",),
            "pyradiance": ("pyradiance==1.3.1",), "flip_evaluator": ("flip-evaluator==1.7",)}
CHILD = pathlib.Path(__file__).with_name("mitsuba_peer.py")
OLDEST_LLVM = 17  # older ones abort on AVX-512 machines
# Samples along each edge of a pixel, and options of rpict: its irradiance cache from coarse to fine.
RADIANCE = ((2, "-ab 6 -aa 0.3 -ad 256 -as 64 -ar 32 -ds 0.25 -dj 1 -lw 1e-3"),
            (4, "-ab 14 -aa 0.3 -ad 256 -as 64 -ar 32 -ds 0.15 -dj 1 -u+ -lw 1e-5"),
            (6, "-ab 14 -aa 0.2 -ad 1024 -as 256 -ar 64 -ds 0.1 -dj 1 -u+ -lw 1e-5"))
# RAW floats of pvalue, WIDTH, HEIGHT, N: means of N x N into OUT.exr. OpenImageIO itself reads RADIANCE's pictures half
# a step of their mantissa too dark, which is a per cent where a channel is faint.
SHRINK = """
import sys, numpy, OpenImageIO as o
w, h, n = map(int, sys.argv[2:5])
p = numpy.fromfile(sys.argv[1], "f4").astype("f8").reshape(h, n, w, n, 3).mean(axis=(1, 3)).astype("f4").copy()
sys.exit(0 if o.ImageBuf(p).write(sys.argv[5]) else 1)
"""


def llvm_libraries():
    """LLVM's libraries that are new enough, the newest first."""
    found = {}
    for pattern in ("/usr/lib/*/libLLVM*.so*", "/usr/lib/llvm-*/lib/libLLVM*.so*", "/usr/lib*/libLLVM*.so*"):
        for path in glob.glob(pattern):
            version = re.search(r"libLLVM(?:-|\.so\.)(\d+)", path)
            if version and int(version[1]) >= OLDEST_LLVM:
                found.setdefault(os.path.realpath(path), int(version[1]))
    return sorted(found, key=found.get, reverse=True)


class Peers:
    def __init__(self, o, size):
        self.o, self.size, self.notes = o, size, []
        wanted = o.peer or ["mitsuba", "mitsuba+oidn", "radiance"]
        self.python = pathlib.Path(o.venv) / "bin" / "python"
        self._install(wanted)
        self.environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "OIDN_SET_AFFINITY": "0"}
        if o.threads:
            self.environment["OIDN_NUM_THREADS"] = str(o.threads)
        self.variant, self.llvm = self._variant()
        self.script = file_hash(CHILD)
        self.wanted, self.radiance = wanted, None
        if "radiance" in wanted:
            self._prepare_radiance()

    # ---- installing ----

    def _has(self, module):
        return self.python.exists() and subprocess.run([self.python, "-c", f"import {module}"],
                                                       capture_output=True).returncode == 0

    def _pip(self, *packages):
        done = subprocess.run([self.python, "-m", "pip", "install", "--quiet", *packages], capture_output=True,
                              text=True)
        return "" if done.returncode == 0 else (done.stderr.strip().splitlines() or ["no message"])[-1]

    def _install(self, wanted):
        if not self.python.exists():
            done = subprocess.run([sys.executable, "-m", "venv", str(self.o.venv)], capture_output=True, text=True)
            if done.returncode != 0:
                raise BadInput(f"{self.o.venv}: python3 -m venv failed, Debian's python3-venv was expected")
        needed = {"mitsuba": ["mitsuba"], "mitsuba+oidn": ["mitsuba", "pyoidn"], "radiance": ["mitsuba", "pyradiance"]}
        modules = list(dict.fromkeys(m for w in wanted for m in needed[w])) + ["flip_evaluator"]
        for module in modules:
            if self._has(module):
                continue
            print(f"study: installing {' '.join(PACKAGES[module])} from PyPI into {self.o.venv}", file=sys.stderr)
            why = self._pip(*PACKAGES[module])
            if why and module == "mitsuba":
                raise BadInput(f"{self.o.venv}: pip install {PACKAGES[module][0]} failed: {why}")
            if why:
                self.notes.append(f"{PACKAGES[module][0]} could not be installed: {why}")
                for w in [w for w in wanted if module in needed[w]]:
                    wanted.remove(w)

    # ---- Mitsuba ----

    def _child(self, job, threads, timeout=None, environment=None):
        with tempfile.TemporaryDirectory(prefix="study.") as work:
            job_file, result = os.path.join(work, "job.json"), os.path.join(work, "result.json")
            whole = {"scene": str(self.o.scene), "size": self.size, "denoise": False, "define": self.o.define,
                     "result": result, **job}
            pathlib.Path(job_file).write_text(json.dumps(whole))
            cost = processes.measured([self.python, "-B", CHILD, job_file], threads, timeout,
                                      environment or self.environment)
            return cost, json.loads(pathlib.Path(result).read_text())

    def _works(self, variant, environment):
        with tempfile.TemporaryDirectory(prefix="study.") as work:
            try:
                self._child({"variant": variant, "size": [16, 16], "spp": 4, "seed": 1,
                             "out": os.path.join(work, "x.exr")}, self.o.threads, 120, environment)
                return ""
            except processes.Failed as error:
                return str(error)

    def _variant(self):
        """LLVM's variant with the first library that renders the scene, small; else the scalar one."""
        given = os.environ.get("DRJIT_LIBLLVM_PATH")
        for library in [given] if given else llvm_libraries():
            environment = {**self.environment, "DRJIT_LIBLLVM_PATH": library}
            if not self._works("llvm_ad_rgb", environment):
                self.environment = environment
                return "llvm_ad_rgb", os.path.basename(library)
        why = self._works("scalar_rgb", self.environment)
        if why:
            raise BadInput(f"{self.o.scene}: Mitsuba does not render it: {why}")
        self.notes.append("Mitsuba's LLVM variant did not run here (it needs LLVM 17 or newer: Debian's libllvm19, or "
                          "DRJIT_LIBLLVM_PATH); its scalar variant, several times slower, was measured instead.")
        return "scalar_rgb", ""

    # ---- RADIANCE ----

    def _prepare_radiance(self):
        import hashlib
        code = "import pyradiance, pathlib; print(pathlib.Path(pyradiance.__file__).parent)"
        self.radiance = pathlib.Path(processes.output([str(self.python), "-c", code]))
        self.work = tempfile.TemporaryDirectory(prefix="study.")
        polygons, self.octree = os.path.join(self.work.name, "scene.rad"), os.path.join(self.work.name, "scene.oct")
        try:
            _, result = self._child({"variant": "scalar_rgb", "radiance": True, "out": polygons}, self.o.threads)
            self.view = result["view"]
            self.radiance_environment = {**os.environ, "RAYPATH": f".:{self.radiance / 'lib'}"}
            processes.measured([self.radiance / "bin" / "oconv", polygons], 0, env=self.radiance_environment,
                               stdout=self.octree)
        except processes.Failed as error:
            self.notes.append(f"RADIANCE was not measured: {str(error).removeprefix('not for RADIANCE: ')}.")
            self.wanted = [w for w in self.wanted if w != "radiance"]
            return
        self.polygons = hashlib.sha256(pathlib.Path(polygons).read_bytes()).hexdigest()[:16]

    def _rpict(self, point, out):
        n, options = int(point.options[0]), point.options[1:]
        rpict = self.radiance / "bin" / "rpict"
        picture = os.path.join(self.work.name, "x.hdr")
        command = [str(rpict), *self.view, "-x", str(n * self.size[0]), "-y", str(n * self.size[1]), "-pa", "0",
                   "-ps", "1", *options]
        cost = processes.measured([*command, self.octree], self.o.threads, self.o.timeout, self.radiance_environment,
                                  picture)
        raw = os.path.join(self.work.name, "x.raw")
        processes.measured([self.radiance / "bin" / "pvalue", "-h", "-H", "-df", picture], 0,
                           env=self.radiance_environment, stdout=raw)
        shrink = [sys.executable, "-c", SHRINK, raw, *map(str, self.size), str(n), str(out)]
        if subprocess.run(shrink, capture_output=True).returncode != 0:
            raise processes.Failed(1, "rpict wrote no picture that can be read")
        return {**cost, "render_seconds": cost["wall_seconds"],
                "render_cpu_seconds": cost["cpu_seconds"], "ran_on": "rpict, 1 thread",
                "version": processes.output([str(rpict), "-version"]), "command": [*command, "scene.oct"]}

    # ---- what command.py asks for ----

    def series(self):
        label = f"Mitsuba path ({self.variant.split('_')[0]})"
        out = []
        for name, peer in ((label, "mitsuba"), (f"{label} + OIDN", "mitsuba+oidn")):
            if peer in self.wanted:
                out.append([Point(name, peer, peer, f"spp {n}", (str(n),)) for n in self.o.peer_spp])
        if "radiance" in self.wanted:
            out.append([Point("RADIANCE rpict", "radiance", "radiance", f"{n}x{n} {options}",
                              (str(n), *options.split())) for n, options in RADIANCE])
        return out

    def definition(self, point):
        if point.peer == "radiance":
            return {"peer": point.peer, "options": list(point.options), "packages": PACKAGES["pyradiance"],
                    "polygons": self.polygons, "view": self.view, "means": file_hash(__file__)}
        return {"peer": point.peer, "options": list(point.options), "variant": self.variant, "llvm": self.llvm,
                "script": self.script, "packages": [PACKAGES["mitsuba"], PACKAGES["pyoidn"]], "define": self.o.define}

    def run(self, point, seed, out):
        if point.peer == "radiance":
            return self._rpict(point, out)
        job = {"variant": self.variant, "spp": int(point.options[0]), "seed": seed, "out": str(out),
               "denoise": point.peer == "mitsuba+oidn"}
        cost, result = self._child(job, self.o.threads, self.o.timeout)
        threads = f"{self.o.threads or 'all'} thread{'' if self.o.threads == 1 else 's'}"
        return {**cost, **result, "ran_on": f"{self.variant}{', ' + self.llvm if self.llvm else ''}, {threads}",
                "command": ["python", "mitsuba_peer.py", json.dumps({k: v for k, v in job.items() if k != "out"})]}
