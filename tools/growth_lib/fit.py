"""Exponents: y = c x^e, fitted by least squares to the logarithms."""
import math

import numpy as np


def exponent(xs, ys):
    """(e, its standard error, c). The error is NaN for two points, which a line always meets."""
    if len(xs) != len(ys):
        raise ValueError(f"{len(xs)} abscissae and {len(ys)} ordinates")
    points = [(math.log(x), math.log(y)) for x, y in zip(xs, ys) if x > 0 and y > 0]
    if len({x for x, _ in points}) < 2:
        raise ValueError("an exponent needs two different positive abscissae")
    lx, ly = np.array(points).T
    dx = lx - lx.mean()
    e = float(dx @ ly / (dx @ dx))
    rest = ly - ly.mean() - e * dx
    error = math.sqrt(float(rest @ rest) / (len(lx) - 2) / float(dx @ dx)) if len(lx) > 2 else math.nan
    return e, error, math.exp(float(ly.mean() - e * lx.mean()))


def last_exponent(xs, ys):
    """Of the two largest abscissae alone: what growth tends to once fixed costs no longer matter."""
    points = sorted(zip(xs, ys))[-2:]
    return exponent([x for x, _ in points], [y for _, y in points])[0]
