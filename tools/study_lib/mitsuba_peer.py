"""Runs inside the virtual environment that has Mitsuba 3: python mitsuba_peer.py JOB.json

Renders one picture, or writes the scene for RADIANCE, as the job says; figures go to job["result"], JSON. Times are of
rendering and denoising alone: both are done once before, so that nothing is compiled or initialised in them.
"""
import json
import os
import pathlib
import sys
import tempfile
import time
import xml.etree.ElementTree as ET

job = json.loads(pathlib.Path(sys.argv[1]).read_text())

import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402
import numpy as np  # noqa: E402

mi.set_variant(job["variant"])
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "crosscheck_lib"))
from mitsuba_reference import rewritten  # noqa: E402

CORES = len(os.sched_getaffinity(0))  # tools/study keeps the process on as many as it may have threads
# Mitsuba 3.9.1 waits for ever where it reads or writes pictures, and its scalar variant where it renders, if its pool
# has one thread alone. Two on one core get no more done than one.
AT_LEAST = 2
WAVEFRONT = 1 << 24  # samples at once
AOVS = "albedo:albedo,normal:sh_normal"


def load():
    tree = rewritten(job["scene"], *job["size"], -1)
    root = tree.getroot()
    for sensor in root.iter("sensor"):
        sensor.find("sampler").set("type", "multijitter")
    if job["denoise"]:
        path = root.find("integrator")
        root.remove(path)
        aov = ET.Element("integrator", type="aov")
        ET.SubElement(aov, "string", name="aovs", value=AOVS)
        aov.append(path)
        root.insert(0, aov)
    # Beside no file of the user's: the scene's own folder is searched for meshes and textures instead.
    with tempfile.TemporaryDirectory() as work:
        written = os.path.join(work, "scene.xml")
        tree.write(written)
        resolver = mi.file_resolver() if hasattr(mi, "file_resolver") else mi.Thread.thread().file_resolver()
        resolver.prepend(os.path.dirname(os.path.abspath(job["scene"])))
        return mi.load_file(written, **dict(d.split("=", 1) for d in job["define"]))


def render(scene, spp, seed):
    at_once = max(1, min(spp, WAVEFRONT // (job["size"][0] * job["size"][1])))
    total, done = 0.0, 0
    while done < spp:
        n = min(at_once, spp - done)
        total = total + n * np.array(mi.render(scene, spp=n, seed=seed * 1000 + done), np.float32)
        done += n
    return total / spp


class Denoiser:
    """OIDN as its manual has it for best quality: albedo and normals are denoised first, by themselves."""

    def __init__(self, shape):
        import pyoidn
        self.oidn, self.device = pyoidn, pyoidn.Device()
        self.device.commit()
        names = ("color", "albedo", "normal", "clean albedo", "clean normal", "output")
        self.images = {n: np.zeros(shape, np.float32) for n in names}
        self.passes = [self._filter({"albedo": "albedo", "output": "clean albedo"}),
                       self._filter({"normal": "normal", "output": "clean normal"}),
                       self._filter({"color": "color", "albedo": "clean albedo", "normal": "clean normal",
                                     "output": "output"}, hdr=True, cleanAux=True)]

    def _filter(self, slots, **flags):
        f = self.oidn.Filter(self.device, self.oidn.OIDN_FILTER_TYPE_RT)
        for slot, name in slots.items():
            f.set_image(slot, self.images[name], self.oidn.OIDN_FORMAT_FLOAT3)
        for flag, value in flags.items():
            f.set_bool(flag, value)
        f.set_quality(self.oidn.OIDN_QUALITY_HIGH)
        f.commit()
        return f

    def __call__(self, picture):
        for name, first in (("color", 0), ("albedo", 3), ("normal", 6)):
            self.images[name][...] = picture[..., first:first + 3]
        for f in self.passes:
            f.execute()
        error = self.device.get_error()
        if error:
            sys.exit(f"OIDN: {error}")
        return self.images["output"]


def picture():
    scene, spp = load(), job["spp"]
    if "llvm" in job["variant"]:
        dr.set_thread_count(CORES)
    per_pass = max(1, WAVEFRONT // (job["size"][0] * job["size"][1]))
    # Kernels hold the number of samples of a pass: compiled for that number; the scalar variant compiles nothing.
    shape = render(scene, min(spp, per_pass) if "llvm" in job["variant"] else 1, 999).shape
    denoiser = Denoiser((*shape[:2], 3)) if job["denoise"] else None
    if denoiser:
        denoiser(np.zeros(shape, np.float32))
    began, cpu_began = time.perf_counter(), time.process_time()
    result = render(scene, spp, job["seed"])
    rendered = time.perf_counter()
    if denoiser:
        result = denoiser(result)
    ended, cpu_seconds = time.perf_counter(), time.process_time() - cpu_began
    dr.set_thread_count(max(AT_LEAST, CORES))
    mi.Bitmap(np.ascontiguousarray(result[..., :3], np.float32)).write(job["out"])
    return {"render_seconds": ended - began, "render_cpu_seconds": cpu_seconds,
            "denoise_seconds": ended - rendered if denoiser else None}


# ---- for RADIANCE ----------------------------------------------------------------------------------------------------

def colour(params, key, what):
    value = next((params[k] for k in (key + ".value", key + ".radiance.value", key) if k in params), None)
    if value is None or np.size(value) not in (1, 3):
        sys.exit(f"not for RADIANCE: {what} is not one colour")
    return np.broadcast_to(np.ravel(np.array(value, float)), 3)


def radiance_scene():
    """Polygons of diffuse surfaces and area lights as RADIANCE's polygons, and the view."""
    scene, lines = load(), []
    if len(scene.emitters()) != sum(s.is_emitter() for s in scene.shapes()):
        sys.exit("not for RADIANCE: it has lights besides area lights")
    for number, shape in enumerate(scene.shapes()):
        bsdf = shape.bsdf()
        params = dict(iter(mi.traverse(bsdf)))
        keys = [k for k in params if k.endswith("reflectance.value")]
        other = [k for k in params if not k.endswith("reflectance.value")]
        if other or len(keys) not in (1, 2) or "specular" in "".join(keys):
            sys.exit(f"not for RADIANCE: a surface of shape {shape.id()} is not diffuse, of one colour "
                     f"({bsdf.class_name()})")
        name = f"m{number}"
        if shape.is_emitter():
            light = colour(dict(iter(mi.traverse(shape.emitter()))), "radiance", "a light")
            lines.append(f"void light {name}\n0\n0\n3 {' '.join(f'{x:.9g}' for x in light)}\n")
        else:
            grey = colour(params, keys[0][:-len(".value")], "a reflectance")
            lines.append(f"void plastic {name}\n0\n0\n5 {' '.join(f'{x:.9g}' for x in grey)} 0 0\n")
        for i, polygon in enumerate(polygons(shape)):
            corners = " ".join(f"{x:.9g}" for x in polygon.ravel())
            lines.append(f"{name} polygon {name}.{i}\n0\n0\n{polygon.size} {corners}\n")
    pathlib.Path(job["out"]).write_text("\n".join(lines))
    return {"view": view(scene.sensors()[0])}


def polygons(shape):
    """(n, corners, 3), in the order that makes the normal outward. A rectangle stays one: RADIANCE samples a light's
    bounding rectangle, and of a triangle's half the samples miss."""
    params = dict(iter(mi.traverse(shape)))
    if "vertex_positions" in params:
        corners = np.array(params["vertex_positions"], float).reshape(-1, 3)
        return corners[np.array(params["faces"], int).reshape(-1, 3)]
    if shape.class_name() != "Rectangle":
        sys.exit(f"not for RADIANCE: shape {shape.id()} is neither mesh nor rectangle")
    to_world = np.array(params["to_world"].matrix, float).reshape(4, 4)
    corners = np.array([[-1, -1, 0, 1], [1, -1, 0, 1], [1, 1, 0, 1], [-1, 1, 0, 1]], float) @ to_world.T
    return corners[None, :, :3]


def view(sensor):
    if "perspective" not in sensor.class_name().lower():
        sys.exit("not for RADIANCE: its camera is no pinhole")
    m = np.array(sensor.world_transform().matrix, float).reshape(4, 4)
    if np.linalg.det(m[:3, :3]) < 0:
        sys.exit("not for RADIANCE: its camera mirrors")
    horizontal = float(np.ravel(np.array(mi.traverse(sensor)["x_fov"]))[0])
    vertical = np.degrees(2 * np.arctan(np.tan(np.radians(horizontal) / 2) * job["size"][1] / job["size"][0]))
    word = lambda v: [f"{x:.9g}" for x in v]
    return ["-vtv", "-vp", *word(m[:3, 3]), "-vd", *word(m[:3, 2]), "-vu", *word(m[:3, 1]), "-vh", f"{horizontal:.9g}",
            "-vv", f"{vertical:.9g}"]


dr.set_thread_count(max(AT_LEAST, CORES))
figures = radiance_scene() if job.get("radiance") else picture()
pathlib.Path(job["result"]).write_text(json.dumps({**figures, "version": f"Mitsuba {mi.__version__}"}))
