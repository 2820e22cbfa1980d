"""Reads EXR and PFM, writes PNG, by OpenImageIO; lays out what crosscheck shows."""
import numpy as np
import OpenImageIO as oiio

from . import BadInput


def read(path):
    """Linear red, green, blue: (height, width, 3) float32."""
    buffer = oiio.ImageBuf(str(path))
    if buffer.has_error or not buffer.spec().width:
        raise BadInput(f"{path}: {buffer.geterror().splitlines()[0] if buffer.has_error else 'no picture'}, "
                       "an EXR or PFM was expected")
    names = list(buffer.spec().channelnames)
    if not all(c in names for c in "RGB"):
        raise BadInput(f"{path}: channels {', '.join(names)} were found, R, G and B were expected")
    pixels = buffer.get_pixels(oiio.FLOAT)
    if buffer.has_error or pixels is None:
        raise BadInput(f"{path}: {buffer.geterror()}")
    pixels = pixels[..., [names.index(c) for c in "RGB"]]
    if not np.isfinite(pixels).all():
        y, x = np.argwhere(~np.isfinite(pixels).all(axis=-1))[0]
        raise BadInput(f"{path}: pixel ({x}, {y}) is {pixels[y, x]}, finite numbers were expected")
    return pixels


def write_png(path, rgb):
    """Display values in [0, 1], written as they are."""
    bytes_ = np.ascontiguousarray(np.clip(rgb * 255.0 + 0.5, 0, 255).astype(np.uint8))
    out = oiio.ImageOutput.create(str(path))
    spec = oiio.ImageSpec(bytes_.shape[1], bytes_.shape[0], 3, oiio.UINT8)
    if out is None or not out.open(str(path), spec) or not out.write_image(bytes_) or not out.close():
        raise BadInput(f"{path}: cannot be written: {oiio.geterror() if out is None else out.geterror()}")


def srgb(linear):
    x = np.clip(linear, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)


def red_blue(sigmas, limit):
    """White at 0, red where ours is brighter, blue where it is darker, full at `limit` sigmas."""
    t = np.clip(sigmas / limit, -1.0, 1.0)
    return np.stack([1 + np.minimum(t, 0), 1 - np.abs(t), 1 - np.maximum(t, 0)], axis=-1)


def sheet(ours, reference, sigmas, tile_z, tile):
    """{name: picture}: ours and reference at one exposure, both maps, and all four side by side."""
    exposure = 0.18 / max(float(reference.mean()), 1e-12)
    strongest = np.take_along_axis(tile_z, np.abs(tile_z).argmax(axis=-1)[..., None], axis=-1)[..., 0]
    tiles = np.repeat(np.repeat(strongest, tile, 0), tile, 1)[:ours.shape[0], :ours.shape[1]]
    pictures = {"ours": srgb(ours * exposure), "reference": srgb(reference * exposure),
                "difference": red_blue(sigmas, 4.0), "tiles": red_blue(tiles, 5.0)}
    scale = max(1, 400 // ours.shape[1])
    gap = np.full((ours.shape[0] * scale, 8, 3), 0.5)
    row = []
    for name, picture in pictures.items():
        row += [np.repeat(np.repeat(picture, scale, 0), scale, 1), gap]
    pictures["sheet"] = np.concatenate(row[:-1], axis=1)
    return pictures
