#!/usr/bin/env python3
"""Writes bsdf.json: values, densities and samples of Mitsuba 3's BSDFs (made with 3.9.1, variant scalar_rgb, the package
`mitsuba` of PyPI), which tests/cl/bsdf_mitsuba_test.cpp compares the device's BSDFs with.

Every BSDF lies on the rectangle [-1, 1]^2 of the plane z = 0, u along x; it is hit by a ray from the view direction at
(0.25, 0.25). Values are BSDF times cosine as Mitsuba's eval() gives them, densities those of pdf(), both of float32.

    python3 make_bsdf.py > bsdf.json
"""
import json
import math

import mitsuba as mi

mi.set_variant("scalar_rgb")

COPPER = {"eta": {"type": "rgb", "value": [0.200438, 0.924033, 1.102212]},
          "k": {"type": "rgb", "value": [3.912949, 2.452848, 2.142188]}}
VIEWS = [(1.0, 0.0), (0.9, 0.8), (0.5, 2.5), (0.1, -1.0), (-0.8, 0.4), (-0.2, -2.2)]  # cosine, azimuth


def rgb(*value):
    return {"type": "rgb", "value": list(value)}


def direction(cosine, phi):
    sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
    return [sine * math.cos(phi), sine * math.sin(phi), cosine]


def rounded(values, digits=6):
    return [0.0 if abs(v) < 1e-12 else float(f"{v:.{digits}g}") for v in values]


def outgoing(view, eta):
    """Directions around the mirror direction and the refracted one, grazing ones, and a grid over the sphere."""
    result = []
    cosine, phi = view
    lobes = [(cosine, phi + math.pi)]
    relative = eta if cosine > 0 else 1.0 / eta
    square = 1.0 - (1.0 - cosine * cosine) / relative ** 2
    if eta != 1.0 and square > 0:
        lobes.append((-math.copysign(math.sqrt(square), cosine), phi + math.pi))
    for c, azimuth in lobes:
        theta = math.acos(c)
        for dt, dp in [(0, 0), (0.02, 0.01), (-0.05, 0), (0.03, -0.06), (0.12, 0.1), (-0.25, 0.2)]:
            result.append((math.cos(theta + dt), azimuth + dp))
    side = math.copysign(1.0, cosine)
    for k, c in enumerate([0.003, 0.03, 0.12, 0.35, 0.65, 0.93]):
        for sign in (side, -side) if eta != 1.0 else (side,):
            for turn in (0.4, 3.4):
                result.append((sign * c, turn + 0.7 * k))
    result.append((-side * 0.5, 1.0))  # where most have nothing
    return result


def hit(bsdf, view):
    scene = mi.load_dict({"type": "scene", "r": {"type": "rectangle", "bsdf": bsdf}})
    d = mi.Vector3f(*direction(*view))
    p = mi.Point3f(0.25, 0.25, 0.0)
    si = scene.ray_intersect(mi.Ray3f(p + 2.0 * d, -d))
    assert si.is_valid()
    return si, si.bsdf()


def evaluate(name, bsdf, eta=1.0, views=None):
    """Views as flat lists: direction, then value and density of each outgoing direction."""
    cases = []
    for view in views or VIEWS:
        si, material = hit(bsdf, view)
        context = mi.BSDFContext()
        rows = []
        for w in outgoing(view, eta):
            wo = si.to_local(mi.Vector3f(*direction(*w)))
            value = list(material.eval(context, si, wo))
            density = material.pdf(context, si, wo)
            rows.append(rounded(direction(*w), 7) + rounded(value + [density]))
        cases.append({"view": rounded(direction(*view), 8), "rows": rows})
    return {"name": name, "bsdf": bsdf, "views": cases}


def sample(name, bsdf):
    """Samples at random numbers u: direction, weight, density (of a discrete part its probability), eta."""
    cases = []
    for view in VIEWS:
        si, material = hit(bsdf, view)
        context = mi.BSDFContext()
        rows = []
        for u in (0.0, 0.02, 0.2, 0.6, 0.97):
            s, weight = material.sample(context, si, u, mi.Point2f(0.3, 0.6))
            if max(list(weight)) == 0:
                continue
            delta = mi.has_flag(mi.BSDFFlags(s.sampled_type), mi.BSDFFlags.Delta)
            rows.append([u, int(delta)] + rounded(list(si.to_world(s.wo)) + list(weight) + [s.pdf, s.eta], 8))
        cases.append({"view": rounded(direction(*view), 8), "rows": rows})
    return {"name": name, "bsdf": bsdf, "views": cases}


def twosided(bsdf):
    return {"type": "twosided", "bsdf": bsdf}


def normal_map(n, bsdf):
    length = math.sqrt(sum(x * x for x in n))
    colour = [0.5 + 0.5 * x / length for x in n]
    texture = {"type": "bitmap", "raw": True, "filter_type": "nearest",
               "bitmap": mi.Bitmap(mi.TensorXf(colour, (1, 1, 3)))}
    return {"type": "normalmap", "normalmap": texture, "bsdf": bsdf}, rounded(colour, 8)


def main():
    values, samples, maps = [], [], []
    grey = {"type": "diffuse", "reflectance": rgb(0.2, 0.5, 0.8)}
    values.append(evaluate("diffuse", grey))
    values.append(evaluate("twosided diffuse", twosided(grey)))
    for distribution in ("ggx", "beckmann"):
        for alpha in (0.05, 0.1, 0.3, 0.6):
            metal = {"type": "roughconductor", "distribution": distribution, "alpha": alpha, **COPPER}
            values.append(evaluate("conductor", metal, views=VIEWS[:5]))
        brushed = {"type": "roughconductor", "distribution": distribution, "alpha_u": 0.1, "alpha_v": 0.4, **COPPER}
        values.append(evaluate("brushed twosided conductor", twosided(brushed)))
        for alpha in (0.1, 0.4):
            glass = {"type": "roughdielectric", "distribution": distribution, "alpha": alpha, "int_ior": 1.5,
                     "ext_ior": 1.0}
            values.append(evaluate("dielectric", glass, 1.5))
        for nonlinear, albedo, alpha in ((False, 0.5, 0.1), (True, 0.1, 0.3), (True, 0.9, 0.1)):
            coated = {"type": "roughplastic", "distribution": distribution, "alpha": alpha, "int_ior": 1.5,
                      "ext_ior": 1.0, "nonlinear": nonlinear, "diffuse_reflectance": rgb(albedo, albedo, albedo)}
            values.append(evaluate("rough plastic", coated, views=VIEWS[:5]))
    for nonlinear, albedo in ((False, 0.5), (True, 0.1), (True, 0.9)):
        coated = {"type": "plastic", "int_ior": 1.5, "ext_ior": 1.0, "nonlinear": nonlinear,
                  "diffuse_reflectance": rgb(albedo, albedo, albedo)}
        values.append(evaluate("plastic", coated, views=VIEWS[:5]))
        samples.append(sample("plastic", coated))
    samples.append(sample("diffuse", grey))
    samples.append(sample("conductor", {"type": "conductor", **COPPER}))
    samples.append(sample("twosided conductor", twosided({"type": "conductor", **COPPER})))
    for kind in ("dielectric", "thindielectric"):
        samples.append(sample(kind, {"type": kind, "int_ior": 1.5, "ext_ior": 1.0,
                                     "specular_transmittance": rgb(0.9, 0.8, 0.7)}))
    for n in ((0.3, 0.0, 1.0), (-0.5, 0.6, 1.0)):
        for inner in (grey, twosided(grey),
                      {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3, **COPPER}):
            bsdf, colour = normal_map(n, inner)
            entry = evaluate("normal map", bsdf)
            entry["bsdf"], entry["map"] = inner, colour
            maps.append(entry)
    head = {"note": "Made by make_bsdf.py with Mitsuba " + mi.__version__ + ", scalar_rgb: see there. Rows of values and "
                    "maps: direction, value, density. Rows of samples: u0 (u1 .3, u2 .6), whether discrete, direction, "
                    "weight, density, eta."}
    print(json.dumps({**head, "values": values, "maps": maps, "samples": samples}, separators=(",", ":"))
          .replace('{"name"', '\n{"name"').replace('{"view"', '\n{"view"'))


main()
