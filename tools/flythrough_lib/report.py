"""CSV, plots, contact sheet and summary of a flight."""
import csv
import math
import statistics

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
import OpenImageIO as oiio  # noqa: E402

from crosscheck_lib import pictures  # noqa: E402
from study_lib.plots import STYLE  # noqa: E402

from . import flicker  # noqa: E402
from .runs import WAYS  # noqa: E402

LOOK = {"shared": ("#0b6fb8", "-"), "alone": ("#d9520e", "-"), "seeds": ("#22863a", "-"), "handed": ("#8a3ffc", "-"),
        "settled": ("#57606a", "--")}


def write_csv(path, rows):
    names = list(dict.fromkeys(name for row in rows for name in row))
    with open(path, "w", newline="") as f:
        writer = csv.DictWriter(f, names, restval="")
        writer.writeheader()
        writer.writerows(rows)


def rms(xs):
    return math.sqrt(sum(x * x for x in xs) / len(xs)) if xs else math.nan


def plot(path, found, floor):
    """{way: [row a frame]}; floor: flicker of the high-quality pair, or None."""
    panels = [("render_s", "seconds of rendering"), ("records_new", "records made"), ("flicker", "flicker"),
              ("patches", "flicker of 8x8-pixel patches")]
    with plt.rc_context(STYLE):
        figure, grid = plt.subplots(2, 2, figsize=(10, 6), sharex=True)
        for axes, (key, label) in zip(grid.flat, panels):
            for way, rows in found.items():
                points = [(r["frame"], r[key]) for r in rows if r.get(key, "") != ""]
                colour, line = LOOK[way]
                axes.plot(*zip(*points), line, color=colour, linewidth=1.6, marker=".", markersize=4,
                          label=f"{way}: {WAYS[way]}")
            if floor is not None and key in ("flicker", "patches"):
                axes.axhline(getattr(floor, key), color="#8a8f96", linewidth=0.9, linestyle=(0, (1, 2)),
                             label="a pair of --quality finest")
            axes.set_ylabel(label)
            axes.set_ylim(bottom=0)
            axes.grid(True, color="#e6e8eb", linewidth=0.8)
            axes.set_axisbelow(True)
            if key in ("flicker", "patches"):
                axes.yaxis.set_major_formatter(matplotlib.ticker.PercentFormatter(1, decimals=None))
                axes.set_xlabel("frame")
        handles, names = grid[1][0].get_legend_handles_labels()
        figure.legend(handles, names, loc="upper center", bbox_to_anchor=(0.5, 0.01), ncol=2, fontsize=8.5)
        figure.tight_layout()
        for kind in ("svg", "png"):
            metadata = {"Date": None} if kind == "svg" else {"Software": None}
            figure.savefig(f"{path}.{kind}", bbox_inches="tight", dpi=130, metadata=metadata)
        plt.close(figure)


def exposure_of(rgb):
    """What is neither lamp nor its brightest reflection comes out dark enough for white things not to burn out."""
    grey = rgb.mean(axis=-1)
    return 0.08 / max(float(grey[grey <= np.quantile(grey, 0.8)].mean()), 1e-12)


def small(rgb, width):
    image = oiio.ImageBuf(np.ascontiguousarray(rgb, np.float32))
    height = max(1, round(rgb.shape[0] * width / rgb.shape[1]))
    return oiio.ImageBufAlgo.resize(image, roi=oiio.ROI(0, width, 0, height, 0, 1, 0, 3)).get_pixels(oiio.FLOAT)


def sheet(path, frames, columns, width):
    """frames: files. Row by row, at the exposure of the first."""
    exposure, tiles = None, []
    for file in frames:
        rgb = flicker.read_layers(file)["rgb"]
        exposure = exposure or exposure_of(rgb)
        tiles.append(np.pad(small(pictures.srgb(rgb * exposure), width), ((0, 3), (0, 3), (0, 0))))
    tiles += [np.zeros_like(tiles[0])] * (-len(tiles) % columns)
    rows = [np.concatenate(tiles[i:i + columns], axis=1) for i in range(0, len(tiles), columns)]
    pictures.write_png(path, np.concatenate(rows)[:-3, :-3])


def change_map(path, pair, full):
    """Red: brighter in the next frame, blue: darker, full at `full` of the mean; grey: not seen by both."""
    picture = pictures.red_blue(np.nan_to_num(pair.map), full)
    pictures.write_png(path, np.where(np.isfinite(pair.map)[..., None], picture, 0.75))


def percent(x):
    return "-" if x is None or not math.isfinite(x) else f"{100 * x:.2f} %"


def summary(o, options, found, cpu, floor, errors):
    """Markdown."""
    frames = len(o.frames)
    rendered = {way: sum(r["render_s"] for r in rows) for way, rows in found.items()}
    lines = [f"`render` options: `{' '.join(options)}`; {frames} frames; seconds are the clock's, the shared cache's "
             "the median of its runs", "",
             "| | rendering, s a frame | first, s | others, median s | CPU s a frame | records made a frame | "
             "flicker, RMS (worst) | of patches, RMS (worst) |", "|---|--:|--:|--:|--:|--:|--:|--:|"]
    for way, rows in found.items():
        of_one = statistics.median(cpu[way]) if way in ("shared", "settled") else sum(cpu[way])
        f, p = ([r[key] for r in rows if key in r] for key in ("flicker", "patches"))
        lines.append(
            f"| {way}: {WAYS[way]} | {rendered[way] / frames:.2f} | {rows[0]['render_s']:.2f} | "
            f"{statistics.median(r['render_s'] for r in rows[1:]):.2f} | {of_one / frames:.2f} | "
            f"{sum(r['records_new'] for r in rows) / frames:.0f} | {percent(rms(f))} ({percent(max(f))}) | "
            f"{percent(rms(p))} ({percent(max(p))}) |")
    if floor is not None:
        lines.append(f"| a pair of `--quality finest`, seeds of their own | | | | | | {percent(floor.flicker)} | "
                     f"{percent(floor.patches)} |")
    shown = [r["shown"] for r in next(iter(found.values())) if "shown" in r]
    lines += ["", f"Pixels seen by both frames of a pair: {100 * min(shown):.0f} to {100 * max(shown):.0f} %."]
    if errors:
        ways = list(errors[0][1])
        lines += ["", f"Relative RMSE against two halves of {o.reference_spp} paths a pixel:", "",
                  "| frame, what | " + " | ".join(ways) + " |", "|---|" + "--:|" * len(ways)]
        lines += [f"| {what} | " + " | ".join(percent(values[way]) for way in ways) + " |" for what, values in errors]
    return "\n".join(lines) + "\n"
