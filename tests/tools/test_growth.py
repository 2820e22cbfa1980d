"""tools/growth: exponents of known laws, and a tiny run. Arguments: render, and unittest's."""
import csv
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from growth_lib import command, fit  # noqa: E402

RENDER = None


class Exponents(unittest.TestCase):
    def test_of_power_laws(self):
        xs = [10.0, 100.0, 1000.0, 1e6]
        for e in (0.0, 0.5, 1.0, 2.0):
            found, error, c = fit.exponent(xs, [3 * x ** e for x in xs])
            self.assertAlmostEqual(found, e, places=9)
            self.assertAlmostEqual(error, 0, places=6)
            self.assertAlmostEqual(c, 3, places=9)

    def test_by_hand(self):
        # log y = 0, 1, 1 at log x = 0, 1, 2: slope 1/2; residuals -1/6, 1/3, -1/6: their squares 1/6, over 1 degree of
        # freedom and a spread of 2: error sqrt(1/12).
        e, error, c = fit.exponent([1, math.e, math.e ** 2], [1, math.e, math.e])
        self.assertAlmostEqual(e, 0.5)
        self.assertAlmostEqual(error, math.sqrt(1 / 12))
        self.assertAlmostEqual(math.log(c), 1 / 6)

    def test_of_the_last_two(self):  # a fixed cost hides growth in the fit, not at the end
        xs = [1, 10, 1e5, 1e6]
        ys = [1 + 1e-2 * x for x in xs]
        self.assertLess(fit.exponent(xs, ys)[0], 0.8)
        self.assertAlmostEqual(fit.last_exponent(xs[::-1], ys[::-1]), 1, delta=1e-3)

    def test_of_too_little(self):
        for xs, ys in (([1], [1]), ([2, 2], [1, 3]), ([1, 2], [1]), ([1, 2], [0, 1])):
            with self.assertRaises(ValueError):
                fit.exponent(xs, ys)


class Command(unittest.TestCase):
    def test_wrong_options(self):
        for line in (["--only", "pixels"], ["-o", "x", "--only", "nothing"], ["-o", "x", "--sizes", "1"],
                     ["-o", "x", "--only", "pixels", "--sizes", "one"],
                     ["-o", "x", "--only", "pixels", "--sizes", "-1"], ["-o", "x", "--repeat", "0"]):
            stderr, sys.stderr = sys.stderr, open(os.devnull, "w")
            try:
                with self.assertRaises(SystemExit) as left:
                    command.parse(line)
            finally:
                sys.stderr.close()
                sys.stderr = stderr
            self.assertEqual(left.exception.code, 2, line)

    def run_tool(self, *options):
        line = [str(ROOT / "tools" / "growth"), "--render", RENDER, *options]
        return subprocess.run(line, capture_output=True, text=True)

    def test_tiny_run(self):
        with tempfile.TemporaryDirectory() as out:
            done = self.run_tool("-o", out, "--only", "pixels", "--sizes", "16,32")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("| path | 2 |", done.stdout)
            with open(os.path.join(out, "pixels.csv")) as f:
                rows = list(csv.DictReader(f))
            self.assertEqual([(r["pixels"], r["method"]) for r in rows],
                             [("256", "irradiance"), ("256", "path"), ("1024", "irradiance"), ("1024", "path")])
            self.assertTrue(all(float(r["render_s"]) > 0 and int(r["rays"]) >= 4 * int(r["pixels"]) for r in rows))
            self.assertEqual(sorted(os.listdir(out)), ["pixels.csv", "pixels.png", "pixels.svg"])

    def test_render_that_fails(self):
        with tempfile.TemporaryDirectory() as out:
            done = self.run_tool("-o", out, "--only", "pixels", "--sizes", "16", "--device", "none of this name")
            self.assertEqual(done.returncode, 1)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
            self.assertIn("none of this name", done.stderr)


if __name__ == "__main__":
    RENDER = sys.argv.pop(1)
    unittest.main()
