"""Command line of tools/flythrough."""
import argparse
import os
import pathlib
import re
import sys


from . import BadInput, flicker, report, runs

DESCRIPTION = ("What does one cache for all frames of a camera's flight gain, and does it flicker? Renders the flight "
               "in several ways.")
EPILOG = f"""\
Ways (--ways), each with the same options of `render`:

{chr(10).join(f'  {name:<9} {what}' for name, what in runs.WAYS.items())}

`shared` is rendered once more after each of the others; its median counts. On a machine that others use, pin it:
taskset -c 0 tools/flythrough ... --threads 1. DIR holds

  frames.csv    a row a frame and way: seconds, records, flicker towards the next frame
  flight.svg    the same as curves, and flight.png
  sheet.png     the frames
  change-*.png  of each way, what changed at surface points that stand still in the pair of frames of the most flicker:
                red brighter, blue darker, full at 10 % of the mean
  summary.md    tables, printed too

{flicker.__doc__.split(chr(10), 2)[2].strip()}

Errors are relative RMSE of pictures and of their `indirect` layers against two independent path traced halves.

Examples
  tools/flythrough scenes/cornell-box.xml scenes/cornell-flight.json -o flight --quality medium
  taskset -c 0 tools/flythrough room.xml room.json -o flight --width 480 --threads 1 --floor --reference-frames 15

Exit status: 0 done, 1 bad input, 2 wrong command line."""


class Parser(argparse.ArgumentParser):
    def error(self, message):
        self.exit(2, f"flythrough: {message} (flythrough --help lists the options)\n")


def frames(text):
    """As `render --frames` reads them: 1-30, 1-30x2, 1-9,20."""
    found = set()
    for part in text.split(","):
        match = re.fullmatch(r"(\d+)(?:-(\d+)(?:x([1-9]\d*))?)?", part)
        if not match or int(match[2] or match[1]) < int(match[1]):
            raise argparse.ArgumentTypeError(f"'{text}' is not a list of frames, for example 1-30 or 1-30x2")
        found.update(range(int(match[1]), int(match[2] or match[1]) + 1, int(match[3] or 1)))
    return sorted(found)


def ways(text):
    chosen = text.split(",")
    for way in chosen:
        if way not in runs.WAYS:
            raise argparse.ArgumentTypeError(f"'{way}' is none of {', '.join(runs.WAYS)}")
    return [way for way in runs.WAYS if way in chosen or way == "shared"]


def parse(arguments):
    root = pathlib.Path(__file__).resolve().parents[2]
    build = pathlib.Path(os.environ.get("IRRADIA_BUILD_DIR") or root / "build")
    p = Parser("tools/flythrough", description=DESCRIPTION, epilog=EPILOG, allow_abbrev=False,
               formatter_class=argparse.RawDescriptionHelpFormatter,
               usage="%(prog)s SCENE PATH.json -o DIR [options] [options of render]")
    add = p.add_argument
    add("scene", metavar="SCENE", help="diffuse: what a mirror shows does not stand still")
    add("path", metavar="PATH.json", help="how the camera moves: render --camera-path")
    add("-o", "--out", required=True, metavar="DIR", help="where all goes")
    add("--frames", type=frames, default=frames("1-30"), metavar="LIST", help="as of `render` [1-30]")
    add("--ways", type=ways, default=ways("shared,alone,seeds,settled"), metavar="LIST",
        help="of " + ", ".join(runs.WAYS) + "; shared always [shared,alone,seeds,settled]")
    add("--seed", type=int, default=0, help="first seed [0]")
    add("--floor", action="store_true", help="also the flicker of the middle pair by --quality finest, two seeds: what "
        "resampling alone amounts to, or little more")
    add("--reference-frames", type=frames, default=[], metavar="LIST", help="frames whose error is measured")
    add("--reference-spp", type=int, default=256, metavar="N", help="samples a pixel of each half of a reference [256]")
    add("--sheet-every", type=int, default=1, metavar="N", help="every N-th frame goes into the sheet [1]")
    add("--render", default=str(build / "bin" / "render"), help="the program")
    o, options = p.parse_known_args(arguments)
    given = {option.split("=")[0] for option in options}
    for mine in ("--output", "--stats", "--aov", "--camera-path", "--overwrite", "--shard", "--batch", "--points",
                 "--load-records", "--save-records"):
        if mine in given:
            p.error(f"{mine}: flythrough sets it")
    if len(o.frames) < 2:
        p.error("--frames: at least two were expected")
    for frame in o.reference_frames:
        if frame not in o.frames:
            p.error(f"--reference-frames: {frame} is none of --frames")
    for name in ("reference_spp", "sheet_every"):
        if getattr(o, name) < 1:
            p.error(f"--{name.replace('_', '-')}: a positive number was expected")
    return o, options


def load(stats, picture):
    return flicker.Frame.of(flicker.Camera(stats["camera"]), flicker.read_layers(picture))


def measure_flicker(work, rows, way):
    """Adds flicker to each row but the last; returns the pair of the most patches."""
    o, worst, before = work.o, None, None
    for i, frame in enumerate(o.frames):
        now = load(work.stats(way, frame), work.out / way / f"f.{frame:04d}.exr")
        if before is not None:
            pair = flicker.compare(before, now)
            rows[i - 1].update(flicker=pair.flicker, patches=pair.patches, shown=pair.shown, off=pair.off)
            if worst is None or pair.patches > worst.patches:
                worst = pair
        before = now
    return worst


def floor_pair(work):
    pair = []
    middle = len(work.o.frames) // 2
    for k, frame in enumerate(work.o.frames[middle - 1:middle + 1]):
        picture = work.extra("finest", frame, "--quality", "finest", "--seed", work.o.seed + 1000 + k)
        pair.append(load(work.json(picture), picture))
    return flicker.compare(*pair)


def errors(work, found):
    out = []
    for frame in work.o.reference_frames:
        a, b = (flicker.read_layers(work.extra(f"reference-{half}", frame, "--method", "path", "--pixel-error", "0",
                                               "--spp", work.o.reference_spp, "--seed", seed))
                for half, seed in (("a", 9001), ("b", 9002)))
        shown = {way: flicker.read_layers(work.out / way / f"f.{frame:04d}.exr") for way in found}
        for layer, name in (("rgb", "picture"), ("indirect", "indirect light")):
            values = {way: flicker.error(x[layer], a[layer], b[layer]) for way, x in shown.items()}
            out.append((f"{frame}, {name}", values))
    return out


def main(arguments):
    o, options = parse(arguments)
    try:
        work = runs.Runs(o, options)
        work.out.mkdir(parents=True, exist_ok=True)
        found = work.all()
        for way, rows in found.items():
            report.change_map(work.out / f"change-{way}.png", measure_flicker(work, rows, way), 0.1)
        floor = floor_pair(work) if o.floor else None
        wrong = errors(work, found)
        report.write_csv(work.out / "frames.csv", [row for rows in found.values() for row in rows])
        report.plot(work.out / "flight", found, floor)
        files = [work.out / "shared" / f"f.{frame:04d}.exr" for frame in o.frames[::o.sheet_every]]
        report.sheet(work.out / "sheet.png", files, min(5, len(files)), 160)
        text = report.summary(o, options, found, work.cpu, floor, wrong)
        (work.out / "summary.md").write_text(text)
        print(text, end="")
    except (BadInput, OSError) as e:
        print(f"flythrough: {e}", file=sys.stderr)
        return 1
    return 0
