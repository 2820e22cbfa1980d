"""tools/study: its statistics on synthetic figures of known truth, its ledger after accidents, its sweeps, what runs
cost."""
import contextlib
import io
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
from study_lib import BadInput, ledger, processes, sweeps  # noqa: E402
from study_lib import statistics as figures  # noqa: E402


class TimeTo(unittest.TestCase):
    def test_power_law_is_met_between_points(self):  # error = 0.1 / sqrt(t): 4 % after 6.25 s, whatever the points
        points = [(t, 0.1 / t ** 0.5) for t in (1, 5, 7, 30)]
        seconds, mark = figures.time_to(points, 0.04)
        self.assertAlmostEqual(seconds, 6.25)
        self.assertEqual(mark, "")

    def test_before_the_first_and_beyond_the_last(self):
        points = [(1, 0.1), (4, 0.05)]
        self.assertEqual(figures.time_to(points, 0.2), (1, "<"))
        self.assertIsNone(figures.time_to(points, 0.01))
        seconds, mark = figures.time_to(points, 0.01, noise_alone=True)
        self.assertAlmostEqual(seconds, 100)  # 4 (0.05 / 0.01)^2
        self.assertEqual(mark, "~")

    def test_points_that_others_beat_do_not_count(self):  # nor does their order
        points = [(9, 0.02), (2, 0.3), (1, 0.1), (3, 0.2), (4, 0.05)]
        self.assertEqual(figures.lower_envelope(points), [(1, 0.1), (4, 0.05), (9, 0.02)])
        self.assertAlmostEqual(figures.time_to(points, 0.05)[0], 4)
        self.assertIsNone(figures.time_to([], 0.05))

    def test_round_up(self):
        for x, expected in ((0.013, 0.02), (0.02, 0.02), (0.21, 0.5), (7, 10), (1, 1)):
            self.assertAlmostEqual(figures.round_up(x), expected)


class Split(unittest.TestCase):
    """Pictures of a known bias and noise on a known truth."""

    def setUp(self):
        self.rng = np.random.default_rng(1)
        self.truth = 0.5 + 0.3 * self.rng.random((96, 128, 3))
        self.error = 0.02 * np.sign(self.rng.standard_normal(self.truth.shape))  # of mean 0 and square 0.0004

    def measured(self, seeds, error, sigma, mask=None):
        x = self.truth + error + sigma * self.rng.standard_normal((seeds,) + self.truth.shape)
        squares = (x - self.truth) ** 2
        mse = squares.mean() if mask is None else squares[:, mask].mean()
        return figures.split_error(x, mse, 1.0, mask)

    def test_both_are_found(self):
        # 36864 values: the variance's relative standard error is sqrt(2 / (2 * 36864)) = 0.5 %; that of bias^2,
        # 2 * 0.02 * 0.05 / sqrt(3 * 36864) and the variance's, is 1.1e-5.
        variance, bias = self.measured(3, self.error, 0.05)
        self.assertAlmostEqual(variance, 0.0025, delta=4 * 0.005 * 0.0025)
        self.assertAlmostEqual(bias, 0.0004, delta=5e-5)

    def test_no_bias_is_told_where_there_is_none(self):
        variance, bias = self.measured(3, 0.0, 0.05)
        self.assertAlmostEqual(bias, 0.0, delta=5e-5)
        self.assertAlmostEqual(variance, 0.0025, delta=5e-5)

    def test_no_variance_is_told_where_there_is_none(self):
        variance, bias = self.measured(2, self.error, 0.0)
        self.assertAlmostEqual(variance, 0.0, delta=1e-12)
        self.assertAlmostEqual(bias, 0.0004, delta=1e-12)

    def test_masked_pixels_do_not_count(self):
        mask = np.ones(self.truth.shape[:2], bool)
        mask[:40] = False
        error = self.error.copy()
        error[:40] += 5.0
        self.assertAlmostEqual(self.measured(3, error, 0.05, mask)[1], 0.0004, delta=7e-5)

    def test_relative_to_the_mean(self):
        x = np.stack([self.truth, self.truth + 0.1])  # sample variance 0.005
        variance, bias = figures.split_error(x, 0.006, 2.0)
        self.assertAlmostEqual(variance, 0.00125)
        self.assertAlmostEqual(bias, 0.00025)

    def test_one_seed_has_none(self):
        self.assertEqual(figures.split_error(self.truth[None], 0.1, 1.0), (None, None))


class LedgerAfterAccidents(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def open(self):
        with contextlib.redirect_stderr(io.StringIO()):  # it says what it drops
            book = ledger.Ledger(self.folder.name)
        self.addCleanup(book.close)
        return book

    def test_a_torn_line_is_dropped_and_overwritten(self):
        book = self.open()
        book.add("run", "a", seconds=1.5)
        book.add("run", "b", seconds=2.5)
        book.close()
        path = pathlib.Path(self.folder.name) / "runs.jsonl"
        whole = path.read_bytes()
        for cut in range(1, len(whole.splitlines()[1]) + 1):  # wherever the power went off
            path.write_bytes(whole[:-cut])
            book = self.open()
            self.assertEqual(book.get("run", "a")["seconds"], 1.5)
            self.assertIsNone(book.get("run", "b"))
            book.add("run", "c", seconds=3.5)
            book.close()
            self.assertEqual([json.loads(line)["key"] for line in path.read_text().splitlines()], ["a", "c"])

    def test_what_is_no_line_of_ours_is_passed_over(self):
        path = pathlib.Path(self.folder.name) / "runs.jsonl"
        path.write_bytes(b'\xff\xfe\n[]\n{"kind": "run"}\n{"kind": "run", "key": "a", "x": 1}\n')
        self.assertEqual(self.open().get("run", "a")["x"], 1)

    def test_two_at_a_time_are_refused(self):
        book = self.open()
        with self.assertRaisesRegex(BadInput, "another tools/study"):
            ledger.Ledger(self.folder.name)
        book.close()
        self.open()

    def test_keys_depend_on_everything(self):
        one = {"options": ["--spp", "4"], "seed": 1}
        self.assertEqual(ledger.key_of(one), ledger.key_of(dict(reversed(one.items()))))
        self.assertNotEqual(ledger.key_of(one), ledger.key_of({**one, "seed": 2}))
        self.assertNotEqual(ledger.key_of(one), ledger.key_of({**one, "options": ["--spp", "8"]}))


class Sweeps(unittest.TestCase):
    def expand(self, *series, glossy=True):
        return sweeps.points_of({"series": list(series)}, "x.json", glossy)

    def test_points_of_a_series(self):
        [[a, b], [c]] = self.expand({"name": "s", "options": "--method path", "vary": "--spp", "values": [4, 16]},
                                    {"name": "t", "points": ["--radius minimum --accuracy 0.1"]})
        self.assertEqual(b.options, ("--method", "path", "--spp", "16"))
        self.assertEqual((a.method, a.label, c.method, c.option("--accuracy")), ("path", "spp 4", "irradiance", "0.1"))

    def test_bad_ones_are_told(self):
        good = {"name": "s", "vary": "--spp", "values": [4]}
        for bad, what in (({**good, "colour": 1}, "'colour' was found"), ({**good, "needs": "sun"}, "needs 'sun'"),
                          ({"name": "s"}, '"points", or "vary"'), ({"vary": "--spp", "values": [4]}, '"name"'),
                          ({**good, "options": "--seed 3"}, "--seed was found"), ({**good, "values": []}, "no points"),
                          ({**good, "options": [True]}, "a list of options"), ("s", '"name"')):
            with self.assertRaisesRegex(BadInput, re.escape(what)):
                self.expand(bad)
        with self.assertRaisesRegex(BadInput, "found twice"):
            self.expand(good, good)
        for name in ("no-such-sweep", "no-such-file.json", __file__):
            with self.assertRaises(BadInput):
                sweeps.load(name)

    def test_those_that_come_along_are_sound(self):
        for name in ("quick", "methods", "full"):
            found, sweep = sweeps.load(name)
            plain, glossy = (sum(map(len, sweeps.points_of(sweep, name, g))) for g in (False, True))
            self.assertEqual(found, name)
            self.assertGreater(glossy, plain)

    def test_series_take_turns(self):
        series = self.expand({"name": "s", "vary": "--spp", "values": [1, 2]},
                             {"name": "t", "vary": "--spp", "values": [3]})
        order = [(p.label, seed) for p, seed in sweeps.in_turn(series, (7, 8))]
        self.assertEqual(order, [(f"spp {n}", seed) for seed in (7, 8) for n in (1, 3, 2)])

    def test_a_scene_is_known_by_all_its_files(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "main.xml").write_text('<scene version="3.0.0"><default name="m" value="one"/><include filename='
                                             '"part.xml"/><shape type="ply"><string name="filename" value="$m.ply"/>'
                                             '</shape></scene>')
            (folder / "part.xml").write_text('<scene version="3.0.0"/>')
            (folder / "one.ply").write_text("a")
            first = sweeps.SceneFiles(folder / "main.xml")
            self.assertFalse(first.glossy)
            self.assertEqual(first.hash, sweeps.SceneFiles(folder / "main.xml").hash)
            (folder / "one.ply").write_text("b")
            second = sweeps.SceneFiles(folder / "main.xml")
            self.assertNotEqual(first.hash, second.hash)
            (folder / "part.xml").write_text('<scene version="3.0.0"><bsdf type="twosided"><bsdf type="roughplastic"/>'
                                             "</bsdf></scene>")
            third = sweeps.SceneFiles(folder / "main.xml")
            self.assertTrue(third.glossy)
            self.assertNotEqual(second.hash, third.hash)
            (folder / "part.xml").write_text("<scene>")
            with self.assertRaisesRegex(BadInput, "part.xml:1"):
                sweeps.SceneFiles(folder / "main.xml")


class Processes(unittest.TestCase):
    def test_costs_of_a_child(self):
        # 64 MiB held and half a second of CPU: of this process nothing is counted but what it held when it forked.
        code = ("import time; b = bytearray(64 << 20); end = time.process_time() + 0.5\n"
                "while time.process_time() < end: pass")
        cost = processes.measured([sys.executable, "-c", code], 1)
        self.assertGreater(cost["cpu_seconds"], 0.5)
        self.assertLess(cost["cpu_seconds"], 2)
        self.assertGreaterEqual(cost["wall_seconds"], cost["cpu_seconds"] * 0.95)  # on one core
        self.assertGreater(cost["peak_bytes"], 64 << 20)

    def test_failures_and_lateness(self):
        with self.assertRaisesRegex(processes.Failed, "out of luck"):
            processes.measured([sys.executable, "-c", "raise SystemExit('out of luck')"], 1)
        with self.assertRaisesRegex(processes.Failed, "stopped after"):
            processes.measured([sys.executable, "-c", "import time; time.sleep(60)"], 1, timeout=0.3)
        with self.assertRaises(BadInput):
            processes.measured(["/no/such/program"], 1)

    def test_what_runs_are_made_with_needs_no_numpy(self):  # its memory would be counted as the renderers'
        code = ("import sys; import study_lib.command, study_lib.peers, study_lib.renderers; "
                "sys.exit('numpy' in sys.modules)")
        tools = pathlib.Path(__file__).resolve().parents[2] / "tools"
        self.assertEqual(subprocess.run([sys.executable, "-B", "-c", code], cwd=tools).returncode, 0)


if __name__ == "__main__":
    unittest.main()
