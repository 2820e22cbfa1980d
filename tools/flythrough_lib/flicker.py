"""What changes, from a frame to the next, at surface points that stand still.

A pixel of frame t sees, by its depth and its camera, a point P with normal n; frame t+1's camera has P at a place
(x', y') between four of its pixels, whose own depths give points Q_k with normals n_k. P counts if it is seen by both:

    |n . (Q_k - P)| <= 0.005 |P - o'|,   n . n_k >= 0.98,   |n_t| >= 0.98      for all k

(on one plane; |n| of a pixel's mean normal is below 1 across an edge). Compared is E = indirect / albedo, channel by
channel, so that textures and direct light, which are sampled at every pixel anyway, stay out; on diffuse surfaces it
is irradiance / pi and does not depend on the view. With E' the bilinear value at (x', y') and d = E' - E over the
counted pixels and channels:

    flicker = sqrt(mean(d^2)) / mean((E + E') / 2)
    patches = sqrt(mean(D^2)) / mean((E + E') / 2),   D: mean of d over a tile of 8 x 8 pixels, at least half counted

Patches are what the eye sees as blotches that pop up; what resampling does to edges and textures averages out there.
"""
import dataclasses

import numpy as np
import OpenImageIO as oiio

from . import BadInput

PLANE, PARALLEL, LEAST_ALBEDO, TILE = 0.005, 0.98, 0.01, 8
LAYERS = {"rgb": "RGB", "indirect": ("indirect.R", "indirect.G", "indirect.B"),
          "albedo": ("albedo.R", "albedo.G", "albedo.B"), "normal": ("normal.X", "normal.Y", "normal.Z"),
          "depth": ("depth.Z",)}


class Camera:
    """As --stats describes it: origin + t * direction is at film (x, y) if direction is along corner + x dx + y dy."""

    def __init__(self, stats):
        for name in ("origin", "corner", "dx", "dy", "forward"):
            setattr(self, name, np.array(stats[name], float))
        if stats.get("aperture_radius", 0) > 0:
            raise BadInput("the scene's camera has a lens: out of focus a pixel sees no one point, a perspective "
                           "camera was expected")

    def points(self, distance):
        """World points at these distances from the camera, seen at the centres of pixels: (h, w, 3)."""
        h, w = distance.shape
        x, y = (np.arange(w) + 0.5) / w, (np.arange(h) + 0.5) / h
        d = self.corner + x[None, :, None] * self.dx + y[:, None, None] * self.dy
        return self.origin + d * (distance / np.linalg.norm(d, axis=-1))[..., None]

    def project(self, points, width, height):
        """Where they are seen, in pixels, whose centres have whole numbers; NaN behind the camera."""
        v = points - self.origin
        z = v @ self.forward
        with np.errstate(divide="ignore", invalid="ignore"):
            q = v / np.where(z > 0, z, np.nan)[..., None] - self.corner
        return (q @ self.dx / (self.dx @ self.dx) * width - 0.5, q @ self.dy / (self.dy @ self.dy) * height - 0.5)


@dataclasses.dataclass
class Frame:
    camera: Camera
    depth: np.ndarray   # (h, w), along the ray; 0: nothing there
    normal: np.ndarray  # (h, w, 3), mean over the pixel
    value: np.ndarray   # (h, w, 3): indirect / albedo, NaN where it does not count

    @staticmethod
    def of(camera, layers):
        normal, depth = layers["normal"], layers["depth"][..., 0].astype(float)
        albedo = layers["albedo"].astype(float)
        good = (depth > 0) & (np.linalg.norm(normal, axis=-1) >= PARALLEL)
        good = good[..., None] & (albedo >= LEAST_ALBEDO)
        value = np.where(good, layers["indirect"] / np.where(good, albedo, 1), np.nan)
        return Frame(camera, depth, normal.astype(float), value)


@dataclasses.dataclass
class Pair:
    flicker: float
    patches: float
    shown: float      # part of the pixels that count
    off: float        # median of |n . (Q - P)| / |P - o'|: how well the cameras fit the depths
    map: np.ndarray   # (h, w) in the first frame: mean of d over the channels, over mean E; NaN: not counted


def read_layers(path):
    """{layer: (h, w, channels)}."""
    buffer = oiio.ImageBuf(str(path))
    if buffer.has_error or not buffer.spec().width:
        raise BadInput(f"{path}: no picture was found, an EXR was expected")
    names = list(buffer.spec().channelnames)
    missing = [c for layer in LAYERS.values() for c in layer if c not in names]
    if missing:
        raise BadInput(f"{path}: channels {', '.join(names)} were found, {', '.join(missing)} too were expected")
    pixels = buffer.get_pixels(oiio.FLOAT)
    if not np.isfinite(pixels).all():
        raise BadInput(f"{path}: not all numbers are finite")
    return {layer: pixels[..., [names.index(c) for c in channels]] for layer, channels in LAYERS.items()}


def compare(a, b):
    """Pair of frame a and the one after it."""
    h, w = b.depth.shape
    p, q = a.camera.points(a.depth), b.camera.points(b.depth)
    u, v = b.camera.project(p, w, h)
    inside = np.isfinite(u) & (u >= 0) & (u < w - 1) & (v >= 0) & (v < h - 1) & np.isfinite(a.value).any(-1)
    if not inside.any():
        raise BadInput("two frames in a row share no surface: smaller steps of the camera were expected")
    yi, xi = np.nonzero(inside)
    p, n, u, v = p[inside], a.normal[inside], u[inside], v[inside]
    n = n / np.linalg.norm(n, axis=-1, keepdims=True)
    x0, y0 = np.floor(u).astype(int), np.floor(v).astype(int)
    fx, fy = u - x0, v - y0
    limit = PLANE * np.linalg.norm(p - b.camera.origin, axis=-1)
    value, at, seen = np.zeros((len(p), 3)), np.zeros((len(p), 3)), np.ones(len(p), bool)
    for dx in (0, 1):
        for dy in (0, 1):
            k = (y0 + dy, x0 + dx)
            weight = ((fx if dx else 1 - fx) * (fy if dy else 1 - fy))[:, None]
            seen &= (np.abs(((q[k] - p) * n).sum(-1)) <= limit) & ((b.normal[k] * n).sum(-1) >= PARALLEL)
            value += weight * b.value[k]
            at += weight * q[k]
    before = a.value[inside]
    counted = seen[:, None] & np.isfinite(value) & np.isfinite(before)
    if not counted.any():
        raise BadInput("two frames in a row share no surface: smaller steps of the camera were expected")
    d = np.where(counted, value - before, 0)
    mean = float((0.5 * (value + before))[counted].mean())
    if not mean > 0:
        raise BadInput("no indirect light was found on the surfaces of two frames, a scene with some was expected")
    per_pixel = np.where(counted.any(-1), d.sum(-1) / np.maximum(counted.sum(-1), 1), np.nan)
    full = np.full(a.depth.shape, np.nan)
    full[yi, xi] = per_pixel
    tiles = [full[y:y + TILE, x:x + TILE] for y in range(0, full.shape[0], TILE) for x in range(0, full.shape[1], TILE)]
    tiles = [np.nanmean(t) for t in tiles if np.isfinite(t).sum() >= TILE * TILE // 2]
    any_channel = counted.any(-1)
    off = np.abs(((at - p) * n).sum(-1))[any_channel] / (limit[any_channel] / PLANE)
    return Pair(float(np.sqrt((d[counted] ** 2).mean())) / mean,
                float(np.sqrt(np.mean(np.square(tiles)))) / mean if tiles else float("nan"),
                float(any_channel.sum() / a.depth.size), float(np.median(off)), full / mean)


def error(x, a, b):
    """Relative RMSE of x by two independent halves of a reference, whose noise cancels in (x - a)(x - b); NaN if that
    is not positive: too small for them to tell."""
    square = float(((x - a).astype(float) * (x - b)).mean())
    return np.sqrt(square) / float((0.5 * (a.astype(float) + b)).mean()) if square > 0 else float("nan")
