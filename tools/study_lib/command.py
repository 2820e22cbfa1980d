"""Command line of tools/study."""
import argparse
import datetime
import fnmatch
import json
import os
import pathlib
import sys

from . import BadInput, processes, sweeps
from .ledger import Ledger, key_of
from .renderers import Judge, Ours, size_of

DESCRIPTION = "What does an error cost? Sweeps methods and parameters over seeds, and reports speed against error."
EPILOG = """\
Each run is a fresh process of `render`, its kernels compiled before, kept on as many cores as it has threads; peers
too. Order: seeds outermost, then series by turns, so that a machine that slows down slows all alike. DIR holds

  study.html    one page with all that follows, to be opened anywhere
  *.svg, *.png  error against time, against records, against accuracy a; logarithmic both ways
  points.csv    a row a point: medians of the costs over the seeds, relative RMSE, relMSE, bias, variance, FLIP
  runs.csv      a row a run
  runs.jsonl    what is done: a study that was killed goes on where it was. pictures/ holds what was rendered

Variance is the mean over pixels of the variance over seeds, of one picture; bias^2 is what is left of the mean squared
error, the reference's noise taken out (--ref-b, or --ref-error). Both over mean(ref)^2; none with one seed. FLIP is
measured if the PyPI package flip_evaluator is importable or installed in --venv.

Sweeps: {sweeps}
or a JSON file:

  {{"series": [
    {{"name": "coarse", "options": "--method irradiance --accuracy 0.4", "vary": "--spp", "values": [16, 64]}},
    {{"name": "two ways", "options": "--spp 64", "points": ["--radius harmonic", "--radius minimum --overlap 2"]}}]}}

A series has fixed options and points; "vary" and "values" are short for points of one option. "needs": "glossy" leaves
it out where the scene has neither rough conductor nor rough plastic. Options are those of `render --help`, but for
file, size, seed, threads and device, which the study sets.

--run-peers renders with Mitsuba 3 (path tracer, multijitter sampler, unlimited depth, with and without OIDN) and
RADIANCE (rpict, its irradiance cache; diffuse scenes only) in turn with ours. They are installed from PyPI into --venv.
They filter by a box: if the scene does not, give --render-option=--rfilter=box. A peer's seconds are those of its
rendering and denoising alone, what it compiles beforehand not counted (with --time cpu, CPU seconds, else the clock's);
ours are of the whole program unless --time says otherwise. Mitsuba's LLVM variants need LLVM 17 or newer (Debian:
libllvm19, or DRJIT_LIBLLVM_PATH); without it the slower scalar variant runs, and the page says so.

Examples
  tools/study scenes/cornell-box.xml --reference ref.exr -o study
  tools/study scene.xml --reference a.exr --ref-b b.exr --sweep full --seeds 5 -o study
  tools/study cornell-a.xml --reference ref.exr --ref-error 0.0021 --mask m.exr --peers peers.csv --run-peers -o study

Exit status: 0 done, 1 bad input or a run failed (the page names it), 2 wrong command line."""


def number(kind, least, most=float("inf")):
    def read(text):
        try:
            if least <= kind(text) <= most:
                return kind(text)
        except ValueError:
            pass
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of at least {least}")
    return read


class Parser(argparse.ArgumentParser):
    def error(self, message):
        self.exit(2, f"study: {message} (study --help lists the options)\n")


def parse(arguments):
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "irradia"
    root = pathlib.Path(__file__).resolve().parents[2]
    build = pathlib.Path(os.environ.get("IRRADIA_BUILD_DIR") or root / "build")
    known = json.loads(sweeps.DEFAULTS.read_text())
    listed = "; ".join(f"{name} ({s['about']})" for name, s in known.items())
    p = Parser("tools/study", description=DESCRIPTION, epilog=EPILOG.format(sweeps=listed),
               formatter_class=argparse.RawDescriptionHelpFormatter)
    add = p.add_argument
    add("scene", metavar="SCENE.xml")
    add("-o", "--out", required=True, metavar="DIR", help="folder for all that is found")
    add("--reference", required=True, metavar="R", help="converged picture; its size is that of all pictures")
    add("--ref-b", metavar="R2", help="second half of a noisy reference: --reference is the first, of another seed")
    add("--ref-error", type=number(float, 0, 1e6), default=0.0, metavar="X",
        help="known relative RMSE of the reference itself (0.01 is 1 %%)")
    add("--mask", metavar="M", help="count only pixels where this picture's first channel is > 0.5")
    add("--sweep", default="quick", metavar="NAME|JSON", help="what is rendered: see below [quick]")
    add("--series", action="append", default=[], metavar="GLOB", help="only series of such names; may be repeated")
    add("--seeds", type=number(int, 1), default=3, metavar="N", help="runs of each point [3]")
    add("--first-seed", type=number(int, 0), default=1, metavar="N", help="[1]")
    add("--threads", type=number(int, 0), default=1, metavar="N", help="of every renderer; 0 all cores [1]")
    add("--device", metavar="NAME|INDEX", help="OpenCL device, as for render")
    add("-D", "--define", action="append", default=[], metavar="name=value", help="value of $name in the scene")
    add("--render-option", action="append", default=[], metavar="OPT",
        help="handed to every run of render, for example --render-option=--rfilter=box")
    add("--time", choices=("total", "render", "cpu", "device"), default="total",
        help="seconds that are plotted: whole program [total], rendering alone, CPU (on a busy machine), device's "
        "kernels")
    add("--timeout", type=number(float, 0.1), metavar="S", help="no run may take longer; it counts as failed")
    add("--report-only", action="store_true", help="render nothing, report what is there")
    add("--peers", metavar="CSV", help="other renderers' figures to plot: columns method, rel_rmse, and seconds or "
        "render_cpu_s; settings, if there")
    add("--run-peers", action="store_true", help="measure Mitsuba 3 and RADIANCE beside ours")
    add("--peer", action="append", default=[], choices=("mitsuba", "mitsuba+oidn", "radiance"), metavar="NAME",
        help="only this: mitsuba, mitsuba+oidn, radiance; may be repeated [all]")
    add("--peer-spp", type=lambda t: [number(int, 1)(x) for x in t.split(",")], default=[4, 16, 64, 256],
        metavar="N,N", help="samples a pixel of Mitsuba [4,16,64,256]")
    add("--venv", default=str(cache / "peers"), metavar="DIR", help="where peers are installed [%(default)s]")
    add("--render", default=str(build / "bin" / "render"), metavar="PATH", help="executable [the build folder's]")
    add("--compare", default=str(build / "bin" / "compare"), metavar="PATH", help="executable [the build folder's]")
    o = p.parse_args(arguments)
    if o.ref_b and o.ref_error:
        p.error("--ref-error belongs to a single reference, --ref-b tells its noise already")
    for d in o.define:
        if d.find("=") < 1:
            p.error(f"--define {d}: name=value was expected")
    o.root, o.arguments = root, arguments
    return o


class Study:
    def __init__(self, o):
        self.o = o
        self.scene = sweeps.SceneFiles(o.scene)
        self.size = size_of(o.reference)
        self.sweep_name, sweep = sweeps.load(o.sweep)
        self.series = sweeps.points_of(sweep, o.sweep, self.scene.glossy)
        self.judge, self.ours = Judge(o), Ours(o, self.size)
        self.ledger = Ledger(o.out)
        self.failed, self.notes, self.peers = [], [], None
        if o.run_peers:
            from .peers import Peers
            self.peers = Peers(o, self.size)
            self.series += self.peers.series()
            self.notes += self.peers.notes
        if o.series:
            self.series = [s for s in self.series if any(fnmatch.fnmatch(s[0].series, g) for g in o.series)]
        if not self.series:
            raise BadInput(f"{o.sweep}: no series is left to render, one at least was expected")
        self.plan = list(sweeps.in_turn(self.series, range(o.first_seed, o.first_seed + o.seeds)))
        self.machine = processes.machine()

    def key(self, point, seed):
        renderer = self.peers if point.peer else self.ours
        return key_of({**renderer.definition(point), "seed": seed, "scene": self.scene.hash, "size": self.size,
                       "threads": self.o.threads})

    def errors_key(self, key):
        return key_of([key, self.judge.against])

    def done(self, key):
        return self.ledger.get("run", key) and self.ledger.picture(key).is_file()

    def render(self):
        left = [(p, s) for p, s in self.plan if not self.done(self.key(p, s))]
        if len(left) < len(self.plan):
            self.say(f"{len(self.plan) - len(left)} of {len(self.plan)} runs are done already")
        broken = set()
        for i, (point, seed) in enumerate(left, 1):
            name = f"[{i}/{len(left)}] {point.series}, {point.label}, seed {seed}"
            if point in broken:
                continue
            try:
                self.one(point, seed, name)
            except processes.Failed as error:
                if error.status == 2 and not point.peer:  # a wrong command line
                    raise BadInput(f"{self.o.sweep}: series {point.series}: {error}") from None
                broken.add(point)
                self.failed.append((point, str(error)))
                self.say(f"{name}: failed: {error}")

    def one(self, point, seed, name):
        key = self.key(point, seed)
        renderer = self.peers if point.peer else self.ours
        load = os.getloadavg()[0]
        figures = renderer.run(point, seed, self.ledger.picture(key))
        self.ledger.add("run", key, series=point.series, point=point.label, seed=seed, options=point.options,
                        machine=self.machine, load_before=load,
                        date=datetime.datetime.now().astimezone().isoformat(timespec="seconds"), **figures)
        errors = self.errors(key)
        self.say(f"{name}: {figures['render_seconds']:.3g} s, {100 * errors['rel_rmse']:.3g} %")

    def errors(self, key):
        """Measured anew where the reference has changed, without rendering again."""
        own = self.errors_key(key)
        return self.ledger.get("errors", own) or \
            self.ledger.add("errors", own, **self.judge.errors(self.ledger.picture(key)))

    def found(self):
        """{point: its runs, by seed, with their errors}"""
        found = {}
        for point, seed in self.plan:
            key = self.key(point, seed)
            if self.done(key):
                errors = {k: v for k, v in self.errors(key).items() if k not in ("kind", "key")}
                found.setdefault(point, []).append(
                    {**self.ledger.get("run", key), **errors, "picture": str(self.ledger.picture(key))})
        return {p: sorted(found[p], key=lambda r: r["seed"]) for s in self.series for p in s if p in found}

    def say(self, text):
        print(f"study: {text}", file=sys.stderr, flush=True)


def run(o):
    study = Study(o)
    try:
        if not o.report_only:
            study.render()
        found = study.found()
        if not found:
            raise BadInput(f"{o.out}: no run of this study was found there, one at least was expected")
        from . import output  # NumPy and matplotlib from here on
        output.write_all(study, found)
    finally:
        study.ledger.close()
    print(f"{o.out}/study.html")
    return 1 if study.failed else 0


def main(arguments):
    o = parse(arguments)
    try:
        return run(o)
    except (BadInput, OSError, processes.Failed) as error:
        print(f"study: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("study: stopped; the same command goes on where it was", file=sys.stderr)
        return 130
