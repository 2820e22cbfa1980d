"""From the ledger to rows: a row for each run, and one for each point, over its seeds."""
import csv
import dataclasses
import io
import math
import os
import statistics as middle

import OpenImageIO as oiio

from crosscheck_lib import pictures

from . import BadInput
from .statistics import signed_root, split_error

TIMES = {"total": "wall_seconds", "render": "render_seconds", "cpu": "cpu_seconds", "device": "device_seconds"}
COSTS = ("wall_seconds", "render_seconds", "cpu_seconds", "device_seconds", "build_seconds",
         "denoise_seconds", "rays", "records", "peak_bytes", "device_bytes")
ERRORS = ("rel_rmse", "relmse", "mean_bias", "mean_bias_interval_95", "ssim", "flip")


@dataclasses.dataclass
class Row:
    """One point: medians of costs, means of squared errors."""
    point: object
    runs: list          # of the ledger, by seed
    seconds: float      # that plots and tables use
    rel_rmse: float
    values: dict        # everything else, by column

    @property
    def peer(self):
        return bool(self.point.peer)

    @property
    def accuracy(self):
        return float(self.point.option("--accuracy") or 0) or None

    @property
    def picture(self):
        return self.runs[0]["picture"]


def median(runs, key):
    found = [r[key] for r in runs if r.get(key) is not None]
    return middle.median(found) if found else None


def mean(runs, key):
    found = [r[key] for r in runs if r.get(key) is not None]
    return sum(found) / len(found) if found else None


def row_of(point, runs, time, mask):
    mse, reference = mean(runs, "mse"), runs[0]["mean_reference"]
    variance = bias_squared = None
    if len(runs) > 1:
        variance, bias_squared = split_error([pictures.read(r["picture"]) for r in runs], mse, reference, mask)
    values = {k: median(runs, k) for k in COSTS} | {k: mean(runs, k) for k in ERRORS}
    if len(runs) > 1:
        spread = middle.stdev(r["mean_bias"] for r in runs) / math.sqrt(len(runs))
        values["mean_bias_interval_95"] = student_95(len(runs) - 1) * spread
    values |= {"seeds": len(runs), "variance": variance, "noise": signed_root(variance),
               "bias_squared": bias_squared, "bias": signed_root(bias_squared)}
    if point.peer:  # what it renders and denoises in, and nothing else
        seconds = median(runs, "render_cpu_seconds" if time == "cpu" else "render_seconds")
    else:
        seconds = values[TIMES[time]]
    return Row(point, runs, seconds, math.sqrt(max(mse, 0.0)) / reference, values)


def student_95(dof):
    from crosscheck_lib.ztest import t_quantile
    return t_quantile(0.05, dof)


def read_mask(path, shape):
    """Where the first channel is above 0.5, as `compare` reads it."""
    if not path:
        return None
    buffer = oiio.ImageBuf(str(path))
    pixels = None if buffer.has_error else buffer.get_pixels(oiio.FLOAT)
    if pixels is None:
        raise BadInput(f"{path}: a picture that can be read was expected")
    mask = pixels[..., 0] > 0.5
    if mask.shape != shape:
        raise BadInput(f"{path}: {mask.shape[1]} x {mask.shape[0]} pixels were found, {shape[1]} x {shape[0]} expected")
    return mask


def read_peers(path):
    """{method: [(seconds, relative RMSE, settings), ...]} of a CSV of other renderers' figures."""
    try:
        with open(path, newline="") as f:
            rows = list(csv.DictReader(f))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise BadInput(f"{path}: {getattr(error, 'strerror', None) or error}, a CSV was expected") from None
    columns = set(rows[0]) if rows else set()
    time = next((c for c in ("seconds", "render_cpu_s", "render_seconds") if c in columns), None)
    if not {"method", "rel_rmse"} <= columns or not time:
        raise BadInput(f"{path}: columns {', '.join(map(str, columns)) or 'none'} were found, "
                       "method, seconds (or render_cpu_s) and rel_rmse were expected")
    peers = {}
    for number, row in enumerate(rows, 2):
        try:
            t, e = float(row[time]), float(row["rel_rmse"])
            if not (0 < t < math.inf and 0 < e < math.inf):
                raise ValueError
        except (TypeError, ValueError):
            raise BadInput(f"{path}:{number}: {time} '{row[time]}' and rel_rmse '{row['rel_rmse']}' were found, "
                           "numbers above 0 were expected") from None
        peers.setdefault(row["method"], []).append((t, e, row.get("settings") or ""))
    return peers


# ---- CSV -------------------------------------------------------------------------------------------------------------

def table(header, rows):
    out = io.StringIO(newline="")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([["" if x is None else f"{x:.6g}" if isinstance(x, float) else x for x in row] for row in rows])
    return out.getvalue()


def write(path, data):
    """Whole or not at all."""
    aside = f"{path}.tmp{os.getpid()}"
    with open(aside, "wb") as f:
        f.write(data if isinstance(data, bytes) else data.encode())
    os.replace(aside, path)


def points_csv(rows):
    names = ["seeds", *COSTS, *ERRORS, "variance", "noise", "bias_squared", "bias"]
    names.remove("rel_rmse")
    return table(["series", "method", "point", "options", "seconds", "rel_rmse", *names],
                 [[r.point.series, r.point.method, r.point.label, " ".join(r.point.options), r.seconds, r.rel_rmse,
                   *(r.values[n] for n in names)] for r in rows])


def runs_csv(rows):
    names = [*COSTS, *ERRORS]
    return table(["series", "method", "point", "seed", "options", *names, "ran_on", "cpu", "load_before", "date"],
                 [[r.point.series, r.point.method, r.point.label, run["seed"], " ".join(r.point.options),
                   *(run.get(n) for n in names), run.get("ran_on"), run["machine"]["cpu"], run["load_before"],
                   run["date"]] for r in rows for run in r.runs])
