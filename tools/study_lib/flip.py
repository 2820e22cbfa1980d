"""FLIP of every picture, by the PyPI package flip_evaluator, in the Python that has it."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from crosscheck_lib import pictures

from .ledger import key_of

# Run in the Python that has it: REFERENCE.npy and a line of standard input for each picture; a line of output for each.
CHILD = """
import sys, numpy, flip_evaluator
reference = numpy.load(sys.argv[1])
for line in sys.stdin:
    print(float(flip_evaluator.evaluate(reference, numpy.load(line.strip()), "LDR", applyMagma=False)[1]), flush=True)
"""


def python_with_flip(venv):
    for python in (sys.executable, pathlib.Path(venv) / "bin" / "python"):
        try:
            if subprocess.run([python, "-c", "import flip_evaluator"], capture_output=True).returncode == 0:
                return python
        except OSError:
            pass
    return None


def display(picture, exposure):
    """As it is shown: FLIP asks what an eye sees, so both pictures go through one exposure and sRGB's curve."""
    return np.ascontiguousarray(pictures.srgb(picture * exposure), np.float32)


def measure(study, found, reference):
    """Adds "flip" to the runs; a sentence for the page."""
    exposure = 0.18 / max(float(reference.mean()), 1e-12)
    reference_hash = study.judge.against[:2 if study.o.ref_b else 1]
    missing = []
    for runs in found.values():
        for run in runs:
            own = key_of([run["key"], reference_hash, "flip"])
            known = study.ledger.get("flip", own)
            if known:
                run["flip"] = known["flip"]
            else:
                missing.append((run, own))
    note = "FLIP: mean over all pixels, the mask's too, at 67 pixels a degree, of pictures as they are shown here."
    if not missing:
        return note
    python = python_with_flip(study.o.venv)
    if not python:
        return "FLIP was not measured: the PyPI package flip_evaluator is not installed (--run-peers installs it)."
    with tempfile.TemporaryDirectory(prefix="study.") as work:
        names = [os.path.join(work, "reference.npy"), os.path.join(work, "x.npy")]
        np.save(names[0], display(reference, exposure))
        child = subprocess.Popen([python, "-c", CHILD, names[0]], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                 stderr=subprocess.DEVNULL, text=True)
        with child:
            for run, own in missing:
                np.save(names[1], display(pictures.read(run["picture"]), exposure))
                try:
                    child.stdin.write(names[1] + "\n")
                    child.stdin.flush()
                    run["flip"] = float(json.loads(child.stdout.readline()))
                except (OSError, ValueError):
                    child.kill()
                    return "FLIP was not measured: flip_evaluator failed."
                study.ledger.add("flip", own, flip=run["flip"])
            child.stdin.close()
    return note
