"""What a record file of `render --save-records` holds.

  tools/records FILE [--ply OUT.ply] [--npz OUT.npz] [--radiance]

Prints the scene and settings that the records were made for, the views, and of irradiance and radiance records how many there
are, where they lie, and the least, the median and the largest of supports, distances, irradiance and gradients.

--ply writes points for MeshLab, Blender, CloudCompare and the like: x, y, z (the scene file's world), nx, ny, nz, E_r, E_g, E_b
(W/m^2), R (harmonic mean distance), support1, support2 (world units), tx, ty, tz (direction of support2), the translational
gradient of luminance gx, gy, gz (W/m^2 a world unit) and red, green, blue (E as a colour, its 95th percentile white).
--npz writes every array as NumPy's: see docs/record-format.md for what they mean. --radiance takes the radiance records for
--ply instead of the irradiance records.

Exit status: 0 done (a damaged tail is a warning), 1 bad file, 2 wrong command line.
"""
import argparse
import os
import sys

import numpy as np

from .record_file import Error, RecordFile

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def parse(argv):
    parser = argparse.ArgumentParser(prog="tools/records", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE", help="what --save-records wrote")
    parser.add_argument("--ply", metavar="OUT.ply", help="write the records as points")
    parser.add_argument("--npz", metavar="OUT.npz", help="write everything as NumPy arrays")
    parser.add_argument("--radiance", action="store_true", help="--ply: radiance records")
    return parser.parse_args(argv)


def columns(records, centre):
    """Of every record: position in the world, E, luminance of E, and the luminance's translational gradient."""
    e = records.values["e"].astype(float)
    gradient = np.einsum("c,icx->ix", LUMINANCE, records.values["translation"].astype(float))
    return records.keys["p"].astype(float) + centre, e, e @ LUMINANCE, gradient


def spread(name, values, unit):
    low, middle, high = np.min(values), np.median(values), np.max(values)
    return f"  {name:<26}{low:<12.4g}{middle:<12.4g}{high:<12.4g}{unit}"


def statistics(name, records, centre):
    if len(records) == 0:
        return [f"{name}: none"]
    position, _, luminance, gradient = columns(records, centre)
    low, high = position.min(axis=0), position.max(axis=0)
    keys, values = records.keys, records.values
    coats = np.count_nonzero(keys["coat"])
    lines = [f"{name}: {len(records)}" + (f", {coats} of them under coats" if coats else ""),
             "  between                   " + " and ".join(
                 "(" + ", ".join(f"{x:.4g}" for x in corner) + ")" for corner in (low, high)),
             f"  {'':<26}{'least':<12}{'median':<12}{'largest':<12}",
             spread("support1", keys["support1"], "world units"),
             spread("support2 / support1", keys["support2"] / keys["support1"], ""),
             spread("harmonic mean distance R", values["harmonic"], "world units"),
             spread("least distance", values["minimum"], "world units (1e30: nothing seen)"),
             spread("luminance of E", luminance, "W/m^2"),
             spread("|gradient| of it", np.linalg.norm(gradient, axis=1), "W/m^2 a world unit")]
    if records.stride:
        radiance = records.samples[:, 7:10, :]
        lines.append(f"  samples                   {records.stride} each, radiance up to {radiance.max():.4g} W/m^2/sr")
    if records.order:
        lines.append(f"  harmonics                 order {records.order}: {records.order ** 2} coefficients a channel")
    return lines


def report(file):
    lines = [f"{file.path}: " + ", ".join(f"{name} {value:016x}" for name, value in file.hashes.items()),
             "settings: " + ", ".join(f"{name} {value}" for name, value in file.settings.items())]
    for view in file.views:
        where = ", ".join(f"{x:.4g}" for x in view["camera"][:3] + file.centre)
        kinds = "irradiance and radiance" if view["kinds"] & 2 else "irradiance"
        lines.append(f"view: {view['width']} x {view['height']} from ({where}), {kinds}")
    return lines + statistics("irradiance records", file.irradiance, file.centre) + statistics(
        "radiance records", file.radiance, file.centre)


def aside(path, write):
    """Writes under another name first, so that a file exists whole or not at all."""
    part = f"{path}.part-{os.getpid()}"
    try:
        with open(part, "wb") as out:
            write(out)
        os.replace(part, path)
    except OSError as error:
        raise Error(f"{path}: cannot be written: {error.strerror}") from None
    finally:
        if os.path.exists(part):
            os.remove(part)


def write_ply(path, records, centre):
    position, e, luminance, gradient = columns(records, centre)
    white = np.percentile(luminance, 95) if len(records) else 1.0
    linear = np.clip(e / max(white, 1e-30), 0, 1)
    colour = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)  # sRGB
    floats = [("x", position[:, 0]), ("y", position[:, 1]), ("z", position[:, 2])]
    floats += [(f"n{a}", records.keys["n"][:, i]) for i, a in enumerate("xyz")]
    floats += [(f"E_{c}", e[:, i]) for i, c in enumerate("rgb")]
    floats += [("R", records.values["harmonic"]), ("support1", records.keys["support1"]),
               ("support2", records.keys["support2"])]
    floats += [(f"t{a}", records.keys["t2"][:, i]) for i, a in enumerate("xyz")]
    floats += [(f"g{a}", gradient[:, i]) for i, a in enumerate("xyz")]
    # Positions in double: scenes may lie far from their world's origin.
    kinds = [(name, "<f8" if name in "xyz" else "<f4") for name, _ in floats] + [(c, "u1") for c in ("red", "green", "blue")]
    rows = np.zeros(len(records), dtype=kinds)
    for name, values in floats:
        rows[name] = values
    for i, name in enumerate(("red", "green", "blue")):
        rows[name] = np.round(255 * colour[:, i])
    words = {"<f8": "double", "<f4": "float", "u1": "uchar"}
    header = "ply\nformat binary_little_endian 1.0\ncomment Irradia records\n" + f"element vertex {len(records)}\n"
    header += "".join(f"property {words[kind]} {name}\n" for name, kind in kinds) + "end_header\n"
    aside(path, lambda out: out.write(header.encode() + rows.tobytes()))


def write_npz(path, file):
    arrays = {"centre": file.centre, "lower": file.lower, "upper": file.upper, "views": file.views,
              "settings": np.array([f"{name} {value}" for name, value in file.settings.items()]),
              "hashes": np.array([f"{name} {value:016x}" for name, value in file.hashes.items()])}
    for name, records in (("irradiance", file.irradiance), ("radiance", file.radiance)):
        for part in ("keys", "values"):
            array = getattr(records, part)
            for field in array.dtype.names:
                arrays[f"{name}_{field}"] = array[field]
    arrays["radiance_samples"], arrays["radiance_harmonics"] = file.radiance.samples, file.radiance.harmonics
    aside(path, lambda out: np.savez(out, **arrays))


def main(argv):
    options = parse(argv)
    try:
        file = RecordFile(options.file)
        if file.warning:
            print(f"records: warning: {file.warning}", file=sys.stderr)
        if options.ply:
            write_ply(options.ply, file.radiance if options.radiance else file.irradiance, file.centre)
        if options.npz:
            write_npz(options.npz, file)
    except Error as error:
        print(f"records: {error}", file=sys.stderr)
        return 1
    print("\n".join(report(file)))
    return 0
