"""Runs inside the virtual environment that has Mitsuba 3:
python mitsuba_reference.py VARIANT SCENE.xml WIDTH HEIGHT MAX_DEPTH SPP PARTS OUT_PREFIX [name=value ...]

Renders PARTS independent pictures of SPP samples into OUT_PREFIX<i>.exr: the scene as it is, but for size, box filter
and a path integrator that hides nothing.
"""
import os
import sys
import tempfile
import xml.etree.ElementTree as ET

import mitsuba as mi
import numpy as np

WAVEFRONT = 1 << 23  # samples at once


def rewritten(scene, width, height, max_depth):
    """Also what tools/study renders."""
    tree = ET.parse(scene)
    root = tree.getroot()
    sensors = list(root.iter("sensor"))
    if not sensors:
        sys.exit(f"{scene}: no <sensor> was found, one in this very file was expected")
    for old in root.findall("integrator"):
        root.remove(old)
    integrator = ET.Element("integrator", type="path")
    ET.SubElement(integrator, "integer", name="max_depth", value=str(max_depth))
    root.insert(0, integrator)
    for sensor in sensors:
        film = sensor.find("film")
        if film is None:
            film = ET.SubElement(sensor, "film", type="hdrfilm")
        for child in list(film):
            if child.tag == "rfilter" or child.get("name") in ("width", "height", "pixel_format", "component_format"):
                film.remove(child)
        ET.SubElement(film, "integer", name="width", value=str(width))
        ET.SubElement(film, "integer", name="height", value=str(height))
        ET.SubElement(film, "string", name="pixel_format", value="rgb")
        ET.SubElement(film, "string", name="component_format", value="float32")
        ET.SubElement(film, "rfilter", type="box")
        for old in sensor.findall("sampler"):
            sensor.remove(old)
        ET.SubElement(sensor, "sampler", type="independent")
    return tree


def main():
    mi.set_variant(sys.argv[1])
    scene_file, (width, height, max_depth, spp, parts), prefix = sys.argv[2], map(int, sys.argv[3:8]), sys.argv[8]
    defines = dict(d.split("=", 1) for d in sys.argv[9:])
    folder = os.path.dirname(os.path.abspath(scene_file))
    # Beside no file of the user's: the scene's own folder is searched for meshes and textures instead.
    with tempfile.TemporaryDirectory() as work:
        path = os.path.join(work, "scene.xml")
        rewritten(scene_file, width, height, max_depth).write(path)
        resolver = mi.file_resolver() if hasattr(mi, "file_resolver") else mi.Thread.thread().file_resolver()
        resolver.prepend(folder)
        scene = mi.load_file(path, **defines)
    at_once = max(1, min(spp, WAVEFRONT // (width * height)))
    seed = 1
    for part in range(parts):
        total, done = np.zeros((height, width, 3)), 0
        while done < spp:
            n = min(at_once, spp - done)
            total += n * np.array(mi.render(scene, spp=n, seed=seed))[..., :3]
            done, seed = done + n, seed + 1
        mi.Bitmap((total / done).astype(np.float32)).write(f"{prefix}{part}.exr")


if __name__ == "__main__":
    main()
