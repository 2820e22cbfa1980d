"""Figures alone: pictures and points in, numbers out."""
import math

import numpy as np


def split_error(pictures, mse, mean_reference, mask=None):
    """(variance, bias squared), both over mean(ref)^2, of pictures (seeds, height, width, 3) that differ in the seed.

    The variance is that of one picture: mean over counted pixels and channels of the sample variance over seeds. What
    is left of the mean squared error, `mse`, is bias squared, provided that the reference's own noise is not in it. An
    estimate: it may be below 0 where there is no bias. None of one picture alone.
    """
    pictures = np.asarray(pictures, np.float64)
    if len(pictures) < 2:
        return None, None
    spread = pictures.var(axis=0, ddof=1)
    variance = float((spread if mask is None else spread[mask]).mean()) / mean_reference ** 2
    return variance, mse / mean_reference ** 2 - variance


def signed_root(x):
    """sqrt with the sign kept: a squared bias below 0 is noise of its estimate."""
    return None if x is None else math.copysign(math.sqrt(abs(x)), x)


def lower_envelope(points):
    """Of (seconds, error): those that no other beats in both, in order of seconds."""
    best, out = math.inf, []
    for t, e in sorted(points):
        if e < best and t > 0:
            out.append((t, e))
            best = e
    return out


def time_to(points, target, noise_alone=False):
    """(seconds to the error `target`, mark) of a series of (seconds, error), read off its lower envelope between two
    points as if log time were linear in log error. Mark "<": the quickest point is better already; "~": beyond the last
    point by 1/sqrt(time), if the error is noise alone. None: not reached."""
    points = lower_envelope(points)
    if not points:
        return None
    if points[0][1] <= target:
        return points[0][0], "<"
    for (t0, e0), (t1, e1) in zip(points, points[1:]):
        if e1 <= target:
            return t0 * (t1 / t0) ** (math.log(e0 / target) / math.log(e0 / e1)), ""
    t, e = points[-1]
    return (t * (e / target) ** 2, "~") if noise_alone else None


def round_up(x):
    """To 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(x))
    return next(power * m for m in (1, 2, 5, 10) if power * m >= x * (1 - 1e-12))
