"""Writes all that a study shows: CSV, plots, page."""
import os
import pathlib
import tempfile

import numpy as np
import OpenImageIO as oiio

from crosscheck_lib import pictures

from . import flip, page, plots, report
from .statistics import round_up, time_to

PICTURES = 24
WIDEST = 320  # pixels of a picture on the page
SECONDS = {"total": "seconds, whole program", "render": "seconds of rendering", "cpu": "CPU seconds",
           "device": "seconds of the device's kernels"}


def by_series(rows):
    out = {}
    for row in rows:
        out.setdefault(row.point.series, []).append(row)
    return out


def times_to(series, peers):
    """[(name, kind, [time to each bar]), ...]: methods' envelopes, series, figures of others."""
    entries, methods = [], {}
    for name, rows in series.items():
        if not rows[0].peer:
            methods.setdefault(rows[0].point.method, []).append(name)
    for method, names in methods.items():
        if len(names) > 1:
            entries.append((f"{method}, best of {len(names)} series", "envelope", method,
                            [(r.seconds, r.rel_rmse) for n in names for r in series[n]]))
    for name, rows in series.items():
        entries.append((name, "measured" if rows[0].peer else "ours", rows[0].point.method,
                        [(r.seconds, r.rel_rmse) for r in rows]))
    for name, points in peers.items():
        entries.append((name, "peer", "", [(t, e) for t, e, _ in points]))
    # Only a path tracer's error is noise alone, so that more samples are sure to bring it down by 1/sqrt(time).
    return [(name, kind, [time_to(points, bar, method in ("path", "mitsuba")) for bar in plots.BARS])
            for name, kind, method, points in entries]


def _png(rgb):
    """Bytes of display values, not wider than WIDEST."""
    image = oiio.ImageBuf(np.ascontiguousarray(rgb, np.float32))
    if rgb.shape[1] > WIDEST:
        height = max(1, round(rgb.shape[0] * WIDEST / rgb.shape[1]))
        image = oiio.ImageBufAlgo.resize(image, roi=oiio.ROI(0, WIDEST, 0, height, 0, 1, 0, rgb.shape[2]))
    with tempfile.TemporaryDirectory(prefix="study.") as work:
        path = os.path.join(work, "x.png")
        pictures.write_png(path, image.get_pixels(oiio.FLOAT)[..., :3])
        return pathlib.Path(path).read_bytes()


def shown(study, series, reference):
    """[(row, picture, map), ...] of the best point of each series, and the maps' scale; PNG bytes."""
    best = [min(rows, key=lambda r: r.rel_rmse) for rows in series.values()][:PICTURES]
    exposure = 0.18 / max(float(reference.mean()), 1e-12)
    errors = sorted(r.rel_rmse for r in best)
    scale = round_up(max(4 * errors[len(errors) // 2], 1e-4))
    out = []
    with tempfile.TemporaryDirectory(prefix="study.") as work:
        path = os.path.join(work, "map.png")
        for row in best:
            study.judge.map(row.picture, path, scale)
            heat = oiio.ImageBuf(path).get_pixels(oiio.FLOAT)[..., :3]
            out.append((row, _png(pictures.srgb(pictures.read(row.picture) * exposure)), _png(heat)))
    return out, _png(pictures.srgb(reference * exposure)), scale


def write_all(study, found):
    o, out = study.o, pathlib.Path(study.o.out)
    reference = pictures.read(o.reference)
    if o.ref_b:
        reference = 0.5 * (reference + pictures.read(o.ref_b))
    mask = report.read_mask(o.mask, reference.shape[:2])
    peers = report.read_peers(o.peers) if o.peers else {}
    flip_note = flip.measure(study, found, reference)
    rows = [report.row_of(p, runs, o.time, mask) for p, runs in found.items()]
    series = by_series(rows)
    report.write(out / "points.csv", report.points_csv(rows))
    report.write(out / "runs.csv", report.runs_csv(rows))
    kinds = [("Error against time", plots.against_time(series, peers, SECONDS[o.time], out / "error-time")),
             ("Error against records", plots.against(series, lambda r: r.values["records"], "records",
                                                     out / "error-records")),
             ("Error against accuracy", plots.against(series, lambda r: r.accuracy, "accuracy a (--accuracy)",
                                                      out / "error-accuracy"))]
    gallery, reference_png, scale = shown(study, series, reference)
    html = page.html(study, rows, series, peers, times_to(series, peers),
                     [(name, pathlib.Path(path).read_bytes()) for name, path in kinds if path],
                     gallery, reference_png, scale, flip_note)
    report.write(out / "study.html", html)
