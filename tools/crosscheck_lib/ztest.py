"""Do two renderers agree within noise? Statistics alone: arrays in, numbers out.

Each side is an array (parts, height, width, channels) of independent pictures of the same expectation: at least two.

Variance of a tile's mean. Pixels are independent (box filter), so it is the sum of the pixels' sample variances. Render
noise has heavy tails, which makes such an estimate too small wherever its rare bright samples happen to be missing:
  * Degrees of freedom are those of Welch and Satterthwaite with von Davier's correction, which falls towards 1 when a
    few pixels carry the noise; p-values are Student's.
  * Where they fall below CALM_DOF, the estimate is not allowed below that of the tile and its neighbours pooled.
  * Floor from the other side: both renderers sample the same light, so their variances are proportional up to one
    factor, the median of the tiles' ratios. No side's variance goes below the other's times that factor: a firefly that
    one side alone has met widens the interval of both.
  * Floor of float32 sums: ROUNDING times the mean.
  * If the parts' tile means scatter more than independent pixels would, all variances grow by that ratio.
p-values are corrected by Holm and Sidak's step-down, half the level for the tiles, half for the whole picture.
"""
import math
from dataclasses import dataclass, field

import numpy as np

CALM_DOF = 12.0
ROUNDING = 1e-4
CHANNELS = ("red", "green", "blue")


# ---- Student's distribution, without SciPy ---------------------------------------------------------------------------

def _beta_fraction(a, b, x):
    """Continued fraction of the incomplete beta function, by Lentz's method."""
    tiny, d = 1e-300, 1.0 - (a + b) * x / (a + 1.0)
    d = 1.0 / (d if abs(d) > tiny else tiny)
    c, value = 1.0, d
    for m in range(1, 1000):
        for numerator in (m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                          -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))):
            d = 1.0 + numerator * d
            d = 1.0 / (d if abs(d) > tiny else tiny)
            c = 1.0 + numerator / c
            c = c if abs(c) > tiny else tiny
            value *= d * c
        if abs(d * c - 1.0) < 1e-14:
            break
    return value


def incomplete_beta(a, b, x):
    """Regularised."""
    if x <= 0.0 or x >= 1.0:
        return 0.0 if x <= 0.0 else 1.0
    log_front = math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x)
    if x < (a + 1.0) / (a + b + 2.0):
        return math.exp(log_front) * _beta_fraction(a, b, x) / a
    return 1.0 - math.exp(log_front) * _beta_fraction(b, a, 1.0 - x) / b


def t_p_value(t, dof):
    """Two-sided."""
    if dof > 1e5:
        return math.erfc(abs(t) / math.sqrt(2.0))
    return incomplete_beta(0.5 * dof, 0.5, dof / (dof + t * t))


def t_density(t, dof):
    if dof > 1e5:
        return math.exp(-0.5 * t * t) / math.sqrt(2.0 * math.pi)
    log_front = math.lgamma(0.5 * (dof + 1.0)) - math.lgamma(0.5 * dof) - 0.5 * math.log(dof * math.pi)
    return math.exp(log_front - 0.5 * (dof + 1.0) * math.log1p(t * t / dof))


def t_quantile(two_sided, dof):
    """The t that is exceeded, in magnitude, with probability `two_sided`: by Newton's method, and by halving what is
    known to hold it where that leads out of it."""
    low, high = 0.0, 1.0
    while t_p_value(high, dof) > two_sided and high < 1e12:
        low, high = high, 2.0 * high
    t = 0.5 * (low + high)
    for _ in range(100):
        excess = t_p_value(t, dof) - two_sided
        low, high = (t, high) if excess > 0.0 else (low, t)
        density = t_density(t, dof)
        step = t + 0.5 * excess / density if density > 0.0 else high
        following = step if low < step < high else 0.5 * (low + high)
        if abs(following - t) <= 1e-12 * t:
            break
        t = following
    return following


def holm_sidak(p):
    """p-values corrected for their number: one below `level` happens by chance with probability `level`."""
    p = np.asarray(p, float)
    order = np.argsort(p)
    left = p.size - np.arange(p.size)
    step = -np.expm1(left * np.log1p(-np.minimum(p[order], 1.0 - 1e-16)))
    corrected = np.empty_like(p)
    corrected[order] = np.minimum(np.maximum.accumulate(step), 1.0)
    return corrected


# ---- tiles -----------------------------------------------------------------------------------------------------------

def tile_sums(picture, tile):
    """(height, width, ...) -> sums over tiles; the last row and column hold what is left."""
    rows = np.arange(0, picture.shape[0], tile)
    columns = np.arange(0, picture.shape[1], tile)
    return np.add.reduceat(np.add.reduceat(picture, rows, axis=0), columns, axis=1)


def _neighbourhood_sums(tiles):
    padded = np.pad(tiles, ((1, 1), (1, 1)) + ((0, 0),) * (tiles.ndim - 2))
    h, w = tiles.shape[:2]
    return sum(padded[y:y + h, x:x + w] for y in range(3) for x in range(3))


def _effective_dof(first, second, parts):
    """von Davier's correction of Welch-Satterthwaite; `first` sums variances, `second` their squares."""
    with np.errstate(divide="ignore", invalid="ignore"):
        dof = np.where(second > 0, first * first * (parts + 1) / second - 2.0, 1e6)
    return np.maximum(dof, 1.0)


@dataclass
class Side:
    """Tiles of one renderer."""
    mean: np.ndarray
    variance: np.ndarray  # of `mean`
    dof: np.ndarray
    own: np.ndarray       # `variance` before pooling
    scatter: float        # of parts' tile means, over that of independent pixels; 1 expected


def measure_side(parts, tile):
    parts = np.asarray(parts, float)
    n = len(parts)
    count = tile_sums(np.ones(parts.shape[1:]), tile)
    pixel = parts.var(axis=0, ddof=1) / n
    first, second = tile_sums(pixel, tile), tile_sums(pixel * pixel, tile)
    own = first / count ** 2
    dof = _effective_dof(first, second, n)
    around = _neighbourhood_sums(first) / _neighbourhood_sums(count) / count
    around_dof = _effective_dof(_neighbourhood_sums(first), _neighbourhood_sums(second), n)
    pooled = (dof < CALM_DOF) & (around > own)
    variance = np.where(pooled, around, own)
    dof = np.where(pooled, around_dof, dof)

    means = np.stack([tile_sums(p, tile) for p in parts]) / count
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = means.var(axis=0, ddof=1) / n / own
    scatter = _significant_scatter(ratio[np.isfinite(ratio)], n)
    return Side(means.mean(axis=0), variance, dof, own, scatter)


def _significant_scatter(ratios, parts):
    """Mean of the ratios if it is clearly above 1, else 1: tiles' channels are counted as one."""
    if ratios.size < 30:
        return 1.0
    spread = math.sqrt(2.0 / (parts - 1) / (ratios.size / 3.0))
    mean = float(ratios.mean())
    return mean if mean > 1.0 + 3.0 * spread else 1.0


def _floor_by_other(ours, ref):
    """Raises both sides' variances to the other's, scaled: see the top."""
    for c in range(ours.mean.shape[-1]):
        a, b = ours.own[..., c], ref.own[..., c]
        both = (a > 0) & (b > 0)
        if both.sum() < 4:
            continue
        factor = float(np.median(a[both] / b[both]))
        old_a, old_b = ours.variance[..., c].copy(), ref.variance[..., c].copy()
        for side, other, f in ((ours, (old_b, ref.dof[..., c].copy()), factor),
                               (ref, (old_a, ours.dof[..., c].copy()), 1.0 / factor)):
            lift = other[0] * f > side.variance[..., c]
            # Where noise is calm on both sides each estimate stands for itself.
            lift &= np.minimum(ours.dof[..., c], ref.dof[..., c]) < 10 * CALM_DOF
            side.variance[..., c] = np.where(lift, other[0] * f, side.variance[..., c])
            side.dof[..., c] = np.where(lift, np.minimum(other[1], side.dof[..., c]), side.dof[..., c])


# ---- verdict ---------------------------------------------------------------------------------------------------------

@dataclass
class Bias:
    """(mean(ours) - mean(reference)) / mean(reference), one a channel."""
    value: list
    low: list
    high: list
    p: list
    tiles: int  # tiles that count


@dataclass
class Comparison:
    tile: int
    level: float
    z: np.ndarray
    corrected: np.ndarray
    ours: np.ndarray
    reference: np.ndarray
    bias: Bias
    trimmed: Bias
    scatter: tuple
    bias_corrected: list = field(default_factory=list)

    @property
    def significant_tiles(self):
        return int((self.corrected < 0.5 * self.level).any(axis=-1).sum())

    @property
    def agrees(self):
        return self.significant_tiles == 0 and min(self.bias_corrected) >= 0.5 * self.level

    def worst(self, count=10):
        """(row, column, channel) of the tiles that deviate most, the worst channel of each."""
        channel = self.corrected.argmin(axis=-1)
        p = self.corrected.min(axis=-1)
        size = np.abs(self.z).max(axis=-1)
        order = np.lexsort((-size.ravel(), p.ravel()))[:count]
        return [(int(i // p.shape[1]), int(i % p.shape[1]), int(channel.flat[i])) for i in order]


def _bias(ours, ref, tiles, tile, extra, floors):
    """Over the tiles of the mask `tiles`. `floors`: of each side, the variance that its tiles, floored by each other,
    give the sum over each tile."""
    mask = np.repeat(np.repeat(tiles, tile, 0), tile, 1)[:ours.shape[1], :ours.shape[2]]
    a, b = np.asarray(ours, float)[:, mask], np.asarray(ref, float)[:, mask]
    value, low, high, p = [], [], [], []
    for c in range(a.shape[-1]):
        estimate = []
        for x, floor in ((a[..., c], floors[0]), (b[..., c], floors[1])):
            v = x.var(axis=0, ddof=1) / len(x)
            first, second = v.sum(), (v * v).sum()
            variance = max(first, floor[tiles][:, c].sum()) / v.size ** 2
            estimate.append((x.mean(), variance, float(_effective_dof(first, second, len(x)))))
        (ma, va, da), (mb, vb, db) = estimate
        va, vb = va * extra[0] + (ROUNDING * ma) ** 2, vb * extra[1]
        scale = abs(mb) if mb else 1.0
        error = math.sqrt(va + vb) or 1e-30
        dof = max(1.0, (va + vb) ** 2 / (va * va / da + vb * vb / db)) if va + vb > 0 else 1e6
        half = t_quantile(0.05, dof) * error
        value.append(float((ma - mb) / scale))
        low.append(float((ma - mb - half) / scale))
        high.append(float((ma - mb + half) / scale))
        p.append(t_p_value((ma - mb) / error, dof))
    return Bias(value, low, high, p, int(tiles.sum()))


def _calm_tiles(ours, ref):
    """Tiles without outliers of either side: noise not above ten times the median tile's."""
    calm = np.ones(ours.own.shape[:2], bool)
    for side in (ours, ref):
        v = side.own.mean(axis=-1)
        calm &= v <= 10.0 * np.median(v)
    return calm


def _trimmed_bias(ours, ref, tile, extra, floors):
    """Cross-fitted: one half of the data chooses the tiles, the other half is averaged over them, and the other way
    round. Tiles chosen by the data that they average would be those whose fireflies happen to be missing."""
    biases = []
    fold = [(ours[0::2], ref[0::2]), (ours[1::2], ref[1::2])]
    for (a, b), (other_a, other_b) in (fold, fold[::-1]):
        # One picture alone (half of two) has no variance; its tiles are judged by both, being all that there is.
        sides = [measure_side(x if len(x) > 1 else whole, tile) for x, whole in ((other_a, ours), (other_b, ref))]
        calm = _calm_tiles(*sides)
        a, b = a if len(a) > 1 else ours, b if len(b) > 1 else ref
        scaled = (floors[0] * len(ours) / len(a), floors[1] * len(ref) / len(b))
        biases.append(_bias(a, b, calm, tile, extra, scaled))
    mean = lambda name: [0.5 * (x + y) for x, y in zip(getattr(biases[0], name), getattr(biases[1], name))]
    # The folds' errors are partly shared (a two-half reference), so their intervals are averaged, not narrowed.
    return Bias(mean("value"), mean("low"), mean("high"), mean("p"), min(b.tiles for b in biases))


def compare(ours, reference, tile=16, level=0.01):
    """Both: (parts, height, width, channels), two parts at least."""
    ours, reference = np.asarray(ours, np.float64), np.asarray(reference, np.float64)
    a, b = measure_side(ours, tile), measure_side(reference, tile)
    _floor_by_other(a, b)
    va, vb = a.variance * a.scatter, b.variance * b.scatter
    floor = (ROUNDING * np.maximum(np.abs(a.mean), np.abs(b.mean))) ** 2
    total = va + vb
    error = np.sqrt(total + floor)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(error > 0, (a.mean - b.mean) / error, 0.0)
        dof = np.where(total > 0, total ** 2 / (va * va / a.dof + vb * vb / b.dof), 1e6)
    # Below two standard errors nothing is significant: 1 stands for p-values that would be corrected to about 1.
    p = np.array([t_p_value(t, max(1.0, d)) if abs(t) > 2.0 else 1.0 for t, d in zip(z.ravel(), dof.ravel())])
    extra = (a.scatter, b.scatter)
    everything = np.ones(a.mean.shape[:2], bool)
    count = tile_sums(np.ones(ours.shape[1:]), tile)
    floors = (a.variance * count ** 2, b.variance * count ** 2)
    bias = _bias(ours, reference, everything, tile, extra, floors)
    return Comparison(tile, level, z, holm_sidak(p).reshape(z.shape), a.mean, b.mean, bias,
                      _trimmed_bias(ours, reference, tile, extra, floors), extra, [float(x) for x in holm_sidak(bias.p)])


def pixel_sigmas(ours, reference, radius=2):
    """Signed difference of luminances in units of its standard error, pooled over (2 radius + 1)^2 pixels."""
    weights = np.array([0.2126, 0.7152, 0.0722])
    means, variance = [], 0.0
    for parts in (ours, reference):
        y = np.asarray(parts, float)[..., :3] @ weights
        means.append(y.mean(axis=0))
        variance = variance + y.var(axis=0, ddof=1) / len(y)
    padded = np.pad(variance, radius, mode="edge")
    size = 2 * radius + 1
    h, w = variance.shape
    pooled = sum(padded[y:y + h, x:x + w] for y in range(size) for x in range(size)) / size ** 2
    return (means[0] - means[1]) / np.sqrt(pooled + (ROUNDING * np.abs(means[1])) ** 2 + 1e-30)
