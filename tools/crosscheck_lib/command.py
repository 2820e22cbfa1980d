"""Command line of tools/crosscheck."""
import argparse
import json
import os
import pathlib
import sys
import tempfile

from . import BadInput

REFERENCE_PARTS = 8
DESCRIPTION = "Does render's path method agree with an independent renderer, within the noise of both?"
EPILOG = """\
The reference is two independent halves (--ref-a, --ref-b), linear, box-filtered; their size is that of the picture.
Without them Mitsuba 3 renders the reference; the first time it is installed into --venv, from PyPI. Size, box filter
and the depth of the scene's integrator are alike on both sides.

What is tested: the difference of the means of each tile and channel over its standard error, and the mean of the whole
picture. Variances come from the spread of the independent parts, of both sides; tools/crosscheck_lib/ztest.py says how
heavy-tailed noise is met. p-values are corrected for the number of tests (Holm, Sidak): two renderers that agree are
told to differ with probability --level. The trimmed bias leaves out tiles that contain outliers of either side.

Pictures in --out: ours.png, reference.png (one exposure), difference.png (a pixel's difference; white 0, red ours
brighter, blue darker, full colour 4 sigmas), tiles.png (z of the worst channel, full colour 5), sheet.png (all four).

Examples
  tools/crosscheck scene.xml --seconds 120 --out check
  tools/crosscheck scene.xml --ref-a a.exr --ref-b b.exr --spp 512 --json check.json

Exit status: 0 they agree, 1 they differ significantly, 2 wrong command line or bad input."""


def size(text):
    try:
        w, h = (int(x) for x in text.lower().split("x"))
        if w > 0 and h > 0:
            return w, h
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"'{text}' is not WxH, for example 320x180")


def at_least(kind, least):
    def read(text):
        try:
            if kind(text) >= least:
                return kind(text)
        except ValueError:
            pass
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of at least {least}")
    return read


class Parser(argparse.ArgumentParser):
    """Complains in one line."""

    def error(self, message):
        self.exit(2, f"crosscheck: {message} (crosscheck --help lists the options)\n")


def parse(arguments):
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "irradia"
    root = pathlib.Path(__file__).resolve().parents[2]
    build = pathlib.Path(os.environ.get("IRRADIA_BUILD_DIR") or root / "build")
    p = Parser("crosscheck", description=DESCRIPTION, epilog=EPILOG,
               formatter_class=argparse.RawDescriptionHelpFormatter)
    add = p.add_argument
    add("scene", metavar="SCENE.xml")
    add("--ref-a", metavar="A.exr", help="one half of the reference")
    add("--ref-b", metavar="B.exr", help="the other half")
    add("--spp", type=at_least(int, 1), metavar="N", help="our samples a pixel, all parts together [256]")
    add("--seconds", type=at_least(float, 1), metavar="S", help="instead of --spp: seconds that our side may take")
    add("--ref-spp", type=at_least(int, 1), metavar="N", help="Mitsuba's samples a pixel [as many as ours]")
    add("--parts", type=at_least(int, 4), default=8, metavar="N", help="independent pictures of our side [8]")
    add("--seed", type=at_least(int, 0), default=1, metavar="N", help="seed of the first part [1]")
    add("--size", type=size, metavar="WxH", help="size of the picture [the reference's, else the scene's]")
    add("--tile", type=at_least(int, 4), default=16, metavar="N", help="edge of a tile in pixels [16]")
    add("--level", type=float, default=0.01, metavar="P", help="probability of a false alarm [0.01]")
    add("--define", "-D", action="append", default=[], metavar="name=value", help="value of $name in the scene")
    add("--render", default=str(build / "bin" / "render"), metavar="PATH", help="executable [the build folder's]")
    add("--render-option", action="append", default=[], metavar="OPT",
        help="handed to render, for example --render-option=--threads=1")
    add("--venv", default=str(cache / "mitsuba"), metavar="DIR", help="where Mitsuba is installed [%(default)s]")
    add("--out", metavar="DIR", help="folder for pictures")
    add("--json", metavar="FILE", help="all figures")
    o = p.parse_args(arguments)
    if bool(o.ref_a) != bool(o.ref_b):
        p.error("--ref-a and --ref-b belong together: one half alone has no variance")
    if o.spp and o.seconds:
        p.error("give either --spp or --seconds")
    if not 0 < o.level < 0.5:
        p.error(f"--level {o.level}: a number between 0 and 0.5 was expected")
    for d in o.define:
        if d.find("=") < 1:
            p.error(f"--define {d}: name=value was expected")
    if not o.spp and not o.seconds:
        o.spp = 256
    return o


def percent(bias, i):
    return f"{100 * bias.value[i]:+.3f} %  [{100 * bias.low[i]:+.3f}, {100 * bias.high[i]:+.3f}]"


def table(o, c, ours_spp, ours, reference):
    import numpy as np
    from .ztest import CHANNELS
    rows, columns = c.z.shape[:2]
    lines = [f"{o.scene}: {ours.shape[2]} x {ours.shape[1]}; ours {len(ours)} parts of {ours_spp} samples a pixel; "
             f"reference {len(reference)} parts"]
    lines.append(f"  {'':8}{'mean ours':>11}{'mean ref.':>11}   {'bias, 95 % interval':31}"
                 "trimmed bias, 95 % interval")
    for i, name in enumerate(CHANNELS):
        lines.append(f"  {name:8}{ours[..., i].mean():11.5g}{reference[..., i].mean():11.5g}   {percent(c.bias, i):31}"
                     f"{percent(c.trimmed, i)}")
    lines.append(f"  trimmed: over {c.trimmed.tiles} of {rows * columns} tiles, those without outliers")
    lines.append(f"  whole picture: corrected p = {min(c.bias_corrected):.3g}"
                 f" ({'differs' if min(c.bias_corrected) < 0.5 * c.level else 'agrees'} at {50 * c.level:g} %)")
    lines.append(f"  tiles: {rows * columns} of {c.tile} x {c.tile} pixels, z: mean {c.z.mean():+.2f}, root mean "
                 f"square {np.sqrt((c.z ** 2).mean()):.2f} (1 expected), largest {np.abs(c.z).max():.2f}; "
                 f"{c.significant_tiles} differ at {50 * c.level:g} %, corrected for {c.z.size} tests")
    if max(c.scatter) > 1:
        lines.append(f"  noise is shared between pixels: variances times {c.scatter[0]:.2f} (ours), {c.scatter[1]:.2f}")
    lines.append(f"  {'worst tiles: pixels':24}{'channel':>8}{'z':>9}{'corrected p':>13}{'ours':>11}{'reference':>11}")
    for y, x, i in c.worst(10 if c.significant_tiles else 3):
        right, bottom = min((x + 1) * c.tile, ours.shape[2]) - 1, min((y + 1) * c.tile, ours.shape[1]) - 1
        at = f"x {x * c.tile}..{right}, y {y * c.tile}..{bottom}"
        lines.append(f"  {at:24}{CHANNELS[i]:>8}{c.z[y, x, i]:+9.2f}{c.corrected[y, x, i]:13.2g}"
                     f"{c.ours[y, x, i]:11.5g}{c.reference[y, x, i]:11.5g}")
    lines.append("AGREE" if c.agrees else "DIFFER")
    return "\n".join(lines)


def figures(o, c, ours_spp, ours, reference):
    bias = lambda b: {"value": b.value, "low": b.low, "high": b.high, "tiles": b.tiles}
    return {"scene": o.scene, "width": ours.shape[2], "height": ours.shape[1], "parts": len(ours),
            "spp_of_a_part": ours_spp, "seed": o.seed, "reference_parts": len(reference), "level": c.level,
            "agrees": c.agrees, "bias": bias(c.bias), "bias_corrected_p": c.bias_corrected,
            "trimmed_bias": bias(c.trimmed), "significant_tiles": c.significant_tiles, "tile": c.tile,
            "scatter": list(c.scatter),
            "tiles": {"z": c.z.tolist(), "corrected_p": c.corrected.tolist(), "ours": c.ours.tolist(),
                      "reference": c.reference.tolist()}}


def run(o):
    from . import pictures, renderers, ztest
    import numpy as np
    if not os.access(o.render, os.X_OK):
        raise BadInput(f"{o.render}: no executable was found, `render` was expected (tools/bootstrap render builds it)")
    defines = dict(d.split("=", 1) for d in o.define)
    max_depth = renderers.scene_max_depth(o.scene, defines)
    reference = None
    if o.ref_a:
        halves = [pictures.read(o.ref_a), pictures.read(o.ref_b)]
        if halves[0].shape != halves[1].shape:
            raise BadInput(f"{o.ref_b}: {halves[1].shape[1]} x {halves[1].shape[0]} pixels were found, "
                           f"{halves[0].shape[1]} x {halves[0].shape[0]} were expected, as in {o.ref_a}")
        if np.array_equal(*halves):
            raise BadInput(f"{o.ref_b}: is the same picture as {o.ref_a}, an independent half was expected")
        reference = np.stack(halves)
        found = (reference.shape[2], reference.shape[1])
        if o.size and o.size != found:
            raise BadInput(f"{o.ref_a}: {found[0]} x {found[1]} pixels were found, "
                           f"{o.size[0]} x {o.size[1]} were expected (--size)")
        o.size = found
    if o.out:
        pathlib.Path(o.out).mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="crosscheck.") as work:
        ours, spp = renderers.Ours(o, work, max_depth).parts()
        if reference is None:
            ref_spp = max(1, -(-(o.ref_spp or spp * len(ours)) // REFERENCE_PARTS))
            reference = renderers.mitsuba_parts(o, work, max_depth, (ours.shape[2], ours.shape[1]), ref_spp,
                                                REFERENCE_PARTS)
    c = ztest.compare(ours, reference, o.tile, o.level)
    print(table(o, c, spp, ours, reference))
    if o.json:
        pathlib.Path(o.json).write_text(json.dumps(figures(o, c, spp, ours, reference), indent=1) + "\n")
    if o.out:
        for name, picture in pictures.sheet(ours.mean(axis=0), reference.mean(axis=0),
                                            ztest.pixel_sigmas(ours, reference), c.z, c.tile).items():
            pictures.write_png(pathlib.Path(o.out) / f"{name}.png", picture)
    return 0 if c.agrees else 1


def main(arguments):
    o = parse(arguments)
    try:
        return run(o)
    except (BadInput, OSError) as error:
        print(f"crosscheck: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
