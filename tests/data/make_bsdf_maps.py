#!/usr/bin/env python3
"""Makes vectors/bsdf_maps.json: what Mitsuba 3 says of BSDFs under bump and normal maps.

    python3 make_bsdf_maps.py          (needs the Python package mitsuba, 3.9.1 when the file here was made)

The test loads the same XML, and asks for the same directions. Values are BSDF times cosine, as eval() gives them."""
import json
import math
import os
import tempfile

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "vectors")
SOURCE = "Mitsuba %s, scalar_rgb, by tests/data/make_bsdf_maps.py: " % mi.__version__


def digits(x, n):
    """n significant digits; whole numbers without a point."""
    x = float("%.*g" % (n, x))
    return int(x) if x == int(x) and abs(x) < 1e6 else x


def direction(theta, phi):
    t, p = math.radians(theta), math.radians(phi)
    return np.array([math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)])


def unit(v):
    return v / np.linalg.norm(v)


def rounded(v):
    """Seven digits: both sides read the same numbers, and they are unit vectors as float32 knows them."""
    return [digits(x, 7) for x in unit(v)]


def scene(bsdf, shape='type="rectangle">'):
    return mi.load_string('<scene version="3.0.0"><shape %s%s</shape></scene>' % (shape, bsdf))


def bsdf_xml(kind, **parameters):
    tags = {bool: "boolean", float: "float", int: "float", str: "string", tuple: "rgb"}
    text = '<bsdf type="%s">' % kind
    for name, x in parameters.items():
        shown = str(x).lower() if isinstance(x, bool) else ", ".join(map(str, x)) if isinstance(x, tuple) else str(x)
        text += '<%s name="%s" value="%s"/>' % (tags[type(x)], name, shown)
    return text + "</bsdf>"


# One triangle whose shading normals lean over, each its own way; v is not across u.
OBJ = """v -1 -1 0
v 1.5 -1 0.2
v -0.6 1.3 0.1
vt 0.1 0.2
vt 0.9 0.1
vt 0.4 0.8
vn 0.2 0.1 1
vn 0.3 0 1
vn 0.1 -0.2 1
f 1/1/1 2/2/2 3/3/3
"""


def maps():
    rng = np.random.default_rng(3)
    heights = rng.uniform(0, 0.25, (4, 5))
    normals = rng.uniform(0.2, 0.8, (4, 5, 3))
    normals[..., 2] = rng.uniform(0.55, 1, (4, 5))
    pictures = {"heights.exr": np.repeat(heights[..., None], 3, 2), "normals.exr": normals}
    pictures = {n: np.array([float("%.4g" % x) for x in p.ravel()]).reshape(p.shape) for n, p in pictures.items()}
    context = mi.BSDFContext()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name, picture in pictures.items():
            mi.Bitmap(picture.astype(np.float32)).write(name)
        with open("leaning.obj", "w") as f:
            f.write(OBJ)
        inner = [bsdf_xml("diffuse", reflectance=0.6),
                 bsdf_xml("roughplastic", distribution="ggx", alpha=0.3, int_ior=1.5, ext_ior=1.0),
                 bsdf_xml("roughdielectric", distribution="ggx", alpha=0.3, int_ior=1.5, ext_ior=1.0)]
        texture = ('<texture type="bitmap" name="%s"><string name="filename" value="%s"/>'
                   '<boolean name="raw" value="true"/></texture>')
        cases = []
        for plain in inner:
            for name, more in (("bumpmap", '<float name="scale" value="1.5"/>'), ("normalmap", "")):
                picture = texture % (("map", "heights.exr") if name == "bumpmap" else ("normalmap", "normals.exr"))
                nested = '<bsdf type="twosided">%s</bsdf>' % plain if "dielectric" not in plain else plain
                xml = '<bsdf type="%s">%s%s%s</bsdf>' % (name, more, picture, nested)
                if "dielectric" not in plain:  # both ways round
                    outside = '<bsdf type="twosided"><bsdf type="%s">%s%s%s</bsdf></bsdf>' % (name, more, picture, plain)
                    cases += [xml, outside]
                else:
                    cases.append(xml)
        results = []
        views = [rounded(direction(t, p)) for t, p in ((10, 0), (50, 100), (70, 230), (85, 320), (140, 60), (97, 10))]
        turns = math.pi * (3 - math.sqrt(5))
        ways = [rounded(np.array([math.sqrt(1 - z * z) * math.cos(turns * i), math.sqrt(1 - z * z) * math.sin(turns * i), z]))
                for i, z in enumerate(np.linspace(0.98, -0.98, 36))]
        places = [[0.3, 0.4], [0.2, 0.1], [0.55, 0.35]]
        corners = np.array([[-1, -1, 0], [1.5, -1, 0.2], [-0.6, 1.3, 0.1]])
        for xml in cases:
            world = scene(xml, 'type="obj"><string name="filename" value="leaning.obj"/>')
            rows, densities = [], []
            for place in places:
                p = corners[0] * (1 - sum(place)) + corners[1] * place[0] + corners[2] * place[1]
                for view in views:
                    v = np.array(view)
                    si = world.ray_intersect(mi.Ray3f(mi.Point3f(p + v), mi.Vector3f(-v)))
                    assert si.is_valid() and abs(si.t - 1) < 1e-5
                    for w in ways:
                        local = si.to_local(mi.Vector3f(w))
                        value = si.bsdf().eval(context, si, local)[1]
                        rows.append(digits(value, 6))
                        densities.append(digits(si.bsdf().pdf(context, si, local), 6))
            results.append({"xml": xml, "values": rows, "densities": densities})
    return {"source": SOURCE + "values: bsdf.eval() (green) and densities: bsdf.pdf() where rays that come along each "
                               "of `views` hit the triangle of `obj` at each of `places` (barycentrics), for each of "
                               "`directions` (of the scene); pictures: rows from the top.",
            "obj": OBJ, "pictures": {n: {"width": p.shape[1], "height": p.shape[0], "rgb": [digits(x, 4) for x in p.ravel()]}
                                     for n, p in pictures.items()},
            "views": views, "directions": ways, "places": places, "bsdfs": results}


data = maps()
with open(os.path.join(HERE, "bsdf_maps.json"), "w") as f:
    json.dump(data, f, separators=(",", ":"))
    f.write("\n")
