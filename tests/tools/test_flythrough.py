"""tools/flythrough: flicker of planes whose changes are known, and a tiny flight: test_flythrough.py RENDER."""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from flythrough_lib import BadInput, command, flicker, report, runs  # noqa: E402

RENDER = None
WIDTH, HEIGHT = 64, 48


def camera(origin=(0, 0, 0), turn=0.0):
    """Looks along -z, turned left by an angle; film of 2 x 1.5 at unit depth."""
    c, s = np.cos(turn), np.sin(turn)
    right, forward = np.array([c, 0, -s]), np.array([-s, 0, -c])
    dx, dy = 2 * right, np.array([0, -1.5, 0])
    corner = forward - 0.5 * (dx + dy)
    return flicker.Camera({"origin": origin, "corner": corner, "dx": dx, "dy": dy, "forward": forward})


def plane(eye, value, z=-4.0, tilt=0.0):
    """What `eye` sees of the plane through (0, 0, z), tilted around y; value(points): (h, w, 3), in place of E."""
    n = np.array([np.sin(tilt), 0, np.cos(tilt)])
    unit = eye.points(np.ones((HEIGHT, WIDTH))) - eye.origin
    distance = (np.array([0, 0, z]) - eye.origin) @ n / (unit @ n)
    return flicker.Frame(eye, distance, np.broadcast_to(n, unit.shape), value(eye.points(distance)))


def constant(points):
    return np.full(points.shape, 0.3)


def linear(points):
    return np.stack([2 + 0.1 * points[..., 0], 3 - 0.2 * points[..., 1], 1 + 0.05 * points.sum(-1)], -1)


class Cameras(unittest.TestCase):
    def test_by_hand(self):
        # The centre of the film looks along -z; film (1, 0), the upper right corner, is at (1, .75, -1) at unit depth.
        eye = camera(origin=(1, 2, 3))
        x, y = eye.project(np.array([[1, 2, -1.0], [2, 2.75, 2], [1, 2, 4]]), WIDTH, HEIGHT)
        self.assertTrue(np.allclose(x[:2], [0.5 * WIDTH - 0.5, WIDTH - 0.5]))
        self.assertTrue(np.allclose(y[:2], [0.5 * HEIGHT - 0.5, -0.5]))
        self.assertTrue(np.isnan(x[2]))  # behind it

    def test_points_come_back_to_their_pixels(self):
        eye = camera((3, -1, 7), 0.4)
        x, y = eye.project(eye.points(np.full((HEIGHT, WIDTH), 5.5)), WIDTH, HEIGHT)
        self.assertTrue(np.allclose(x, np.arange(WIDTH)[None, :]) and np.allclose(y, np.arange(HEIGHT)[:, None]))

    def test_a_lens_is_refused(self):
        stats = {"origin": [0] * 3, "corner": [0] * 3, "dx": [1, 0, 0], "dy": [0, 1, 0], "forward": [0, 0, 1]}
        with self.assertRaises(BadInput):
            flicker.Camera({**stats, "aperture_radius": 0.1})


class Flicker(unittest.TestCase):
    a = camera()
    b = camera((0.3, 0.1, -0.5), 0.05)

    def test_what_stands_still_does_not_flicker(self):
        for tilt in (0.0, 0.9):
            pair = flicker.compare(plane(self.a, constant, tilt=tilt), plane(self.b, constant, tilt=tilt))
            self.assertLess(pair.flicker, 1e-12)
            self.assertLess(pair.off, 1e-12)
            self.assertGreater(pair.shown, 0.5)

    def test_what_varies_over_the_surface_does_not_either(self):
        # Seen head on by both, the bilinear interpolation of a linear function is exact.
        pair = flicker.compare(plane(self.a, linear), plane(camera((0.3, 0.1, -0.5)), linear))
        self.assertLess(pair.flicker, 1e-12)

    def test_a_uniform_change(self):
        # E' = 1.1 E everywhere: d = .1 E, over a mean of 1.05 E.
        pair = flicker.compare(plane(self.a, constant), plane(self.b, lambda p: 1.1 * constant(p)))
        self.assertAlmostEqual(pair.flicker, 0.1 / 1.05, places=12)
        self.assertAlmostEqual(pair.patches, 0.1 / 1.05, places=12)
        self.assertTrue(np.allclose(pair.map[np.isfinite(pair.map)], 0.1 / 1.05))

    def test_noise_is_flicker_but_not_of_patches(self):
        # Without motion bilinear weights are 1 and 0. White noise of deviation s in both frames: d has s sqrt(2);
        # means of 64 pixels and 3 channels have 1/sqrt(192) of that.
        rng = np.random.default_rng(5)
        noisy = [plane(self.a, lambda p: 1 + 0.02 * rng.standard_normal(p.shape)) for _ in range(2)]
        pair = flicker.compare(*noisy)
        self.assertAlmostEqual(pair.flicker, 0.02 * 2 ** 0.5, delta=0.001)
        self.assertAlmostEqual(pair.patches, 0.02 * (2 / 192) ** 0.5, delta=0.0006)

    def test_a_blotch_is_found(self):
        # A disk of radius .5 brightens by a fifth; the plane shows 8 x 6 at its distance, its right and lower
        # line of pixels have no neighbours.
        def spot(points):
            return np.where((np.hypot(points[..., 0], points[..., 1]) < 0.5)[..., None], 1.2, 1.0) * np.ones(3)
        pair = flicker.compare(plane(self.a, lambda p: np.ones(p.shape)), plane(self.a, spot))
        share = np.pi * 0.25 / (8 * 6) * (WIDTH * HEIGHT) / ((WIDTH - 1) * (HEIGHT - 1))
        self.assertAlmostEqual(pair.flicker, 0.2 * share ** 0.5 / (1 + 0.1 * share), delta=0.002)
        y, x = np.unravel_index(np.nanargmax(pair.map), pair.map.shape)
        self.assertLess(abs(x - 31.5) + abs(y - 23.5), 8)

    def test_another_surface_is_not_compared(self):
        # Half of frame b is hidden by something nearer, of other brightness; another part has another normal.
        before, after = plane(self.a, constant), plane(self.a, constant)
        near = plane(self.a, lambda p: 9 * constant(p), z=-2)
        after.depth[:, :32], after.value[:, :32] = near.depth[:, :32], near.value[:, :32]
        after.normal = after.normal.copy()
        after.normal[:, 48:] = (1, 0, 0)
        after.value[:, 48:] *= 5
        pair = flicker.compare(before, after)
        self.assertLess(pair.flicker, 1e-12)
        self.assertAlmostEqual(pair.shown, 15 * (HEIGHT - 1) / (WIDTH * HEIGHT))

    def test_nothing_in_common(self):
        with self.assertRaises(BadInput):
            flicker.compare(plane(self.a, constant), plane(camera(turn=np.pi), constant, z=4.0))
        with self.assertRaises(BadInput):
            flicker.compare(plane(self.a, lambda p: 0 * p), plane(self.b, lambda p: 0 * p))

    def test_black_and_mixed_pixels_do_not_count(self):
        layers = {"normal": np.tile([0.0, 0, 1], (2, 2, 1)), "depth": np.ones((2, 2, 1)),
                  "albedo": np.full((2, 2, 3), 0.5), "indirect": np.full((2, 2, 3), 0.25)}
        layers["normal"][0, 0] *= 0.7  # an edge
        layers["depth"][0, 1] = 0      # the sky
        layers["albedo"][1, 0, 1] = 0  # no green
        value = flicker.Frame.of(self.a, layers).value
        self.assertEqual(np.isnan(value).tolist(), [[[True] * 3, [True] * 3], [[False, True, False], [False] * 3]])
        self.assertTrue((value[np.isfinite(value)] == 0.5).all())

    def test_error_without_the_references_noise(self):
        rng = np.random.default_rng(6)
        truth = np.ones((200, 200, 3))
        a, b = (truth + 0.3 * rng.standard_normal(truth.shape) for _ in range(2))
        # Deviation of the mean of (x - a)(x - b) over 120000: .09 / 346 = 2.6e-4, against .05^2 = 25e-4.
        self.assertAlmostEqual(flicker.error(1.05 * truth, a, b), 0.05, delta=0.01)


class Command(unittest.TestCase):
    def test_frames(self):
        self.assertEqual(command.frames("1-4,9,2-8x3"), [1, 2, 3, 4, 5, 8, 9])
        for text in ("", "a", "4-1", "1-4x0", "1,"):
            with self.assertRaises(command.argparse.ArgumentTypeError):
                command.frames(text)

    def test_options_of_render_and_its_own(self):
        o, options = command.parse(["s.xml", "p.json", "-o", "d", "--quality", "draft", "--ways", "alone", "--spp=4"])
        self.assertEqual((options, o.ways), (["--quality", "draft", "--spp=4"], ["shared", "alone"]))
        self.assertEqual(runs.without(options + ["--no-grid"], runs.QUALITY), ["--no-grid"])

    def run_tool(self, *options):
        return subprocess.run([ROOT / "tools" / "flythrough", "--render", RENDER, ROOT / "scenes" / "cornell-box.xml",
                               ROOT / "scenes" / "cornell-flight.json", *options], capture_output=True, text=True)

    def test_wrong_options(self):
        for options in (["-o", "x", "--stats", "y"], ["-o", "x", "--frames", "3"], ["-o", "x", "--ways", "none"], [],
                        ["-o", "x", "--reference-frames", "31"]):
            done = self.run_tool(*options)
            self.assertEqual(done.returncode, 2, options)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)

    def test_tiny_flight(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            done = self.run_tool("-o", folder, "--frames", "4-6", "--width", "64", "--quality", "draft",
                                 "--reference-frames", "5", "--reference-spp", "64",
                                 "--ways", "shared,alone,handed,settled", "--no-neighbour-clamp")
            self.assertEqual(done.returncode, 0, done.stderr)
            with open(out / "frames.csv") as f:
                rows = list(csv.DictReader(f))
            self.assertEqual([(r["way"], r["frame"]) for r in rows],
                             [(w, f) for w in ("shared", "alone", "handed", "settled") for f in "456"])
            new = {(r["way"], r["frame"]): int(r["records_new"]) for r in rows}
            self.assertEqual(new["shared", "4"], new["alone", "4"])
            self.assertTrue(all(new["alone", f] > 2 * new["shared", f] for f in "56"), new)
            # Exactly: without the neighbour clamp no record of a later frame takes from the reach of an earlier one.
            self.assertTrue(all(new["settled", f] == 0 for f in "456"), new)
            flickers = {w: [float(r["flicker"]) for r in rows if r["way"] == w and r["flicker"]]
                        for w in ("shared", "alone", "settled")}
            self.assertEqual({w: len(f) for w, f in flickers.items()}, {w: 2 for w in flickers})
            self.assertLess(max(flickers["shared"]), min(flickers["alone"]))
            self.assertLess(max(float(r["off"]) for r in rows if r["off"]), 1e-4)  # cameras and depths of float32
            for name in ("flight.svg", "flight.png", "sheet.png", "summary.md", "change-shared.png"):
                self.assertGreater((out / name).stat().st_size, 100, name)
            self.assertIn("| 5, indirect light |", done.stdout)

    def test_a_render_that_fails(self):
        with tempfile.TemporaryDirectory() as folder:
            done = self.run_tool("-o", folder, "--device", "none of this name")
            self.assertEqual(done.returncode, 1)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
            self.assertIn("none of this name", done.stderr)


if __name__ == "__main__":
    RENDER = sys.argv.pop(1)
    unittest.main()
