"""Runs `render` and Mitsuba 3."""
import json
import pathlib
import subprocess
import sys
import time
import xml.etree.ElementTree as ET

import numpy as np

from . import MITSUBA, BadInput, pictures


def call(arguments, what):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if done.returncode != 0:
        lines = (done.stderr + done.stdout).strip().splitlines() or ["no message"]
        raise BadInput(f"{what} failed (status {done.returncode}): {lines[-1]}")


def scene_max_depth(scene, defines):
    """Of the scene's integrator; -1 if it names none. `render` itself knows no integrator but --max-depth."""
    try:
        root = ET.parse(scene).getroot()
    except ET.ParseError as error:
        raise BadInput(f"{scene}:{error.position[0]}: {error}, a Mitsuba 3 scene was expected") from None
    except OSError as error:
        raise BadInput(f"{scene}: {error.strerror}") from None
    value = root.find("integrator/integer[@name='max_depth']")
    text = "-1" if value is None else value.get("value", "-1")
    if text.startswith("$"):
        defaults = {d.get("name"): d.get("value") for d in root.iter("default")}
        text = defines.get(text[1:], defaults.get(text[1:], text))
    try:
        return int(text)
    except ValueError:
        raise BadInput(f"{scene}: max_depth is '{text}', a whole number was expected") from None


class Ours:
    """The path method of `render` on one scene, packed once so that each part starts at once."""

    def __init__(self, options, work, max_depth):
        self.options, self.work, self.max_depth = options, pathlib.Path(work), max_depth
        self.packed = self.work / "scene.irradia"
        size = ["--width", options.size[0], "--height", options.size[1]] if options.size else []
        defines = [x for d in options.define for x in ("-D", d)]
        call([options.render, options.scene, "--pack", self.packed, "--quiet", *size, *defines], "render")

    def part(self, seed, spp):
        """Picture, and the seconds that its rendering took."""
        out, stats = self.work / "part.pfm", self.work / "part.json"
        call([self.options.render, self.packed, "-o", out, "--stats", stats, "--quiet", "--method", "path", "--rfilter",
              "box", "--spp", spp, "--seed", seed, "--max-depth", self.max_depth, *self.options.render_option],
             "render")
        return pictures.read(out), json.loads(stats.read_text())["wall_seconds"]["render"]

    def parts(self):
        """(parts, height, width, 3) and the samples of a part."""
        o = self.options
        began, spp = time.monotonic(), o.spp and max(1, -(-o.spp // o.parts))
        if not spp:  # a trial tells how many samples the seconds allow; it is no part, as its spp differ
            self.part(0, 1)  # compiles the kernels, perhaps
            before = time.monotonic()
            _, rendering = self.part(0, 8)
            overhead = time.monotonic() - before - rendering
            left = o.seconds - (time.monotonic() - began)
            spp = max(1, int((left / o.parts - overhead) / max(rendering / 8, 1e-6)))
        return np.stack([self.part(o.seed + i, spp)[0] for i in range(o.parts)]), spp


def mitsuba_python(venv):
    """Python of a virtual environment that has Mitsuba, made on first use."""
    python = pathlib.Path(venv) / "bin" / "python"
    if python.exists() and subprocess.run([python, "-c", "import mitsuba"], capture_output=True).returncode == 0:
        return python
    print(f"crosscheck: installing Mitsuba {MITSUBA} from PyPI into {venv}", file=sys.stderr)
    call([sys.executable, "-m", "venv", "--clear", venv], "python3 -m venv (Debian: python3-venv)")
    call([python, "-m", "pip", "install", "--quiet", f"mitsuba=={MITSUBA}", "numpy"], "pip install mitsuba")
    return python


def mitsuba_parts(options, work, max_depth, size, spp, parts):
    script = pathlib.Path(__file__).with_name("mitsuba_reference.py")
    prefix = pathlib.Path(work) / "reference"
    python = mitsuba_python(options.venv)
    rest = [options.scene, *size, max_depth, spp, parts, prefix, *options.define]
    try:
        call([python, script, "llvm_ad_rgb", *rest], "Mitsuba")
    except BadInput:  # no LLVM library, or one that cannot compile some material: it aborts the process
        print("crosscheck: Mitsuba's LLVM variant failed; trying its scalar one, which is slower", file=sys.stderr)
        call([python, script, "scalar_rgb", *rest], "Mitsuba")
    return np.stack([pictures.read(f"{prefix}{i}.exr") for i in range(parts)])
