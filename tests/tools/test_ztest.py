"""Statistics of tools/crosscheck on synthetic pictures of known noise."""
import math
import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
from crosscheck_lib import ztest  # noqa: E402


def truth(size=64):
    """A smooth picture, not square."""
    y, x = np.mgrid[0:size, 0:size + 24] / size
    return np.stack([0.5 + 0.4 * np.sin(4 * x + c) * np.cos(3 * y) for c in range(3)], axis=-1)


def gaussian(rng, parts, sigma, picture):
    return picture * (1 + sigma * rng.standard_normal((parts,) + picture.shape))


def fireflies(rng, samples, parts, picture):
    """Means of `samples` log-normal samples, mean 1, standard deviation 4.5 (skewness near 100)."""
    s = math.sqrt(3.0)
    draws = np.exp(s * rng.standard_normal((parts, samples) + picture.shape[:2] + (1,), dtype=np.float32) - 0.5 * s * s)
    return picture * draws.mean(axis=1)


class Distributions(unittest.TestCase):
    def test_student_against_tables(self):  # two-sided 5 % and 1 %: any table of Student's distribution
        for dof, five, one in ((1, 12.706, 63.657), (2, 4.303, 9.925), (5, 2.571, 4.032), (30, 2.042, 2.750)):
            self.assertAlmostEqual(ztest.t_quantile(0.05, dof) / five, 1, delta=2e-4)
            self.assertAlmostEqual(ztest.t_quantile(0.01, dof) / one, 1, delta=2e-4)
        self.assertAlmostEqual(ztest.t_p_value(1.959964, 1e9), 0.05, delta=1e-6)
        self.assertAlmostEqual(ztest.t_p_value(1.0, 1), 0.5, delta=1e-12)  # Cauchy: atan(1) = pi / 4

    def test_holm_sidak_by_hand(self):
        corrected = ztest.holm_sidak([0.01, 0.5, 0.02])
        self.assertAlmostEqual(corrected[0], 1 - 0.99 ** 3)
        self.assertAlmostEqual(corrected[2], 1 - 0.98 ** 2)
        self.assertAlmostEqual(corrected[1], 0.5)
        tiny = ztest.holm_sidak([1e-30, 0.5])
        self.assertAlmostEqual(tiny[0] / 2e-30, 1)

    def test_tiles_at_the_border_are_smaller(self):
        sums = ztest.tile_sums(np.ones((20, 35)), 16)
        np.testing.assert_array_equal(sums, [[256, 256, 48], [64, 64, 12]])


class FalseAlarms(unittest.TestCase):
    """At 1 % level, of 300 comparisons of equal expectation 3 are expected to differ; 10 or more happen with
    probability 0.1 % (binomial)."""

    def alarms(self, make, runs=300):
        rng = np.random.default_rng(1)
        return sum(not ztest.compare(*make(rng)).agrees for _ in range(runs))

    def test_gaussian_noise(self):
        t = truth()
        self.assertLess(self.alarms(lambda r: (gaussian(r, 8, 0.5, t), gaussian(r, 2, 0.2, t))), 10)

    def test_noise_that_differs_from_tile_to_tile(self):
        t = truth()
        noise = np.where((np.arange(64) // 16 % 2)[:, None, None], 2.0, 0.05)
        self.assertLess(self.alarms(lambda r: (gaussian(r, 8, noise, t), gaussian(r, 2, noise / 3, t))), 10)

    def test_heavy_tails(self):
        t = truth(48)
        self.assertLess(self.alarms(lambda r: (fireflies(r, 4, 8, t), fireflies(r, 64, 2, t)), 100), 5)

    def test_noise_shared_by_pixels(self):
        t = truth()
        def blotches(rng, parts, sigma):
            coarse = rng.standard_normal((parts, 16, 22, 1)).repeat(4, 1).repeat(4, 2)
            return t * (1 + sigma * coarse)
        self.assertLess(self.alarms(lambda r: (blotches(r, 8, 0.2), gaussian(r, 2, 0.1, t)), 100), 5)

    def test_intervals_hold_what_they_promise(self):
        rng, t, held = np.random.default_rng(2), truth(), 0
        for _ in range(200):
            c = ztest.compare(gaussian(rng, 8, 0.5, t), gaussian(rng, 2, 0.2, t))
            held += c.bias.low[0] <= 0 <= c.bias.high[0]
        self.assertTrue(180 <= held <= 199, held)  # 95 %: 190 +- 3 standard deviations of 3.1

    def test_equal_pictures_without_noise(self):
        t = np.stack([truth()] * 2)
        self.assertTrue(ztest.compare(t, t).agrees)
        black = np.zeros((2, 40, 40, 3))
        self.assertTrue(ztest.compare(black, black).agrees)


class Power(unittest.TestCase):
    def found(self, make, runs=50):
        rng = np.random.default_rng(3)
        return sum(not ztest.compare(*make(rng)).agrees for _ in range(runs))

    # Standard error of the mean of 64 x 88 pixels: 0.5 / sqrt(8 * 5632) = 0.24 %, the reference's 0.19 %: 1 % is three
    # of them in each of three channels, and 0.5 / 3 % is the level: mostly found; 2 % always.
    def test_uniform_bias(self):
        t = truth()
        self.assertGreaterEqual(
            self.found(lambda r: (gaussian(r, 8, 0.25, 1.01 * t), gaussian(r, 2, 0.1, t))), 48)

    def test_one_wrong_tile(self):
        t = truth()
        wrong = t.copy()
        wrong[16:32, 48:64] *= 1.2
        rng = np.random.default_rng(4)
        c = ztest.compare(gaussian(rng, 8, 0.5, wrong), gaussian(rng, 2, 0.2, t))
        self.assertFalse(c.agrees)
        self.assertEqual(c.significant_tiles, 1)
        self.assertEqual(c.worst(1)[0][:2], (1, 3))
        self.assertGreater(c.z[1, 3].min(), 0)
        self.assertGreaterEqual(self.found(lambda r: (gaussian(r, 8, 0.5, wrong), gaussian(r, 2, 0.2, t))), 49)

    def test_bias_under_heavy_tails(self):
        t = truth(48)
        self.assertGreaterEqual(
            self.found(lambda r: (fireflies(r, 4, 8, 1.5 * t), fireflies(r, 64, 2, t)), 20), 18)

    def test_colours_that_cancel_in_luminance(self):
        t = truth()
        tint = t * np.array([1.05, 1.0, 1.0])
        self.assertGreaterEqual(self.found(lambda r: (gaussian(r, 8, 0.5, tint), gaussian(r, 2, 0.2, t)), 20), 19)


if __name__ == "__main__":
    unittest.main()
