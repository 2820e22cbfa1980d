"""tools/study from end to end, on a tiny Cornell box: test_study_run.py RENDER COMPARE."""
import csv
import html.parser
import json
import os
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
RENDER, COMPARE = sys.argv[1:3]
SWEEP = {"series": [{"name": "cache", "options": "--hemisphere 8x24 --grid-paths 4096", "points": ["--spp 16"]},
                    {"name": "path", "options": "--method path", "vary": "--spp", "values": [16, 64]}]}


class Page(html.parser.HTMLParser):
    """All that a page could load."""

    def __init__(self, text):
        super().__init__()
        self.links, self.images, self.rows, self.opened = [], 0, 0, []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.images += tag == "img"
        self.rows += tag == "tr"
        self.links += [(tag, k, v) for k, v in attributes if k in ("src", "href", "srcset", "data", "action", "poster")]
        if tag in ("script", "table", "figure", "div", "svg", "details"):
            self.opened.append(tag)

    def handle_endtag(self, tag):
        if tag in ("script", "table", "figure", "div", "svg", "details"):
            assert self.opened and self.opened.pop() == tag, tag


class Study(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.work.name)
        cls.scene = ROOT / "scenes" / "cornell-box.xml"
        (cls.folder / "sweep.json").write_text(json.dumps(SWEEP))
        (cls.folder / "peers.csv").write_text("method,settings,seconds,rel_rmse\n"
                                              "other <one>,a,0.5,0.4\nother <one>,b,2,0.2\n")
        subprocess.run([RENDER, cls.scene, "-o", cls.folder / "ref.exr", "-q", "--method", "path", "--spp", "1024",
                        "--seed", "99", "--width", "32", "--height", "32", "--rfilter", "box"], check=True)
        # Without the lamp: a few pixels on its edges would be most of the error, too few to know it by.
        rows = [1.0 if row < 22 else 0.0 for row in range(32) for _ in range(32 * 3)]  # from the bottom
        (cls.folder / "mask.pfm").write_bytes(b"PF\n32 32\n-1\n" + struct.pack(f"<{len(rows)}f", *rows))

    @classmethod
    def tearDownClass(cls):
        cls.work.cleanup()

    def command(self, *more, seeds="2", out="out"):
        return [sys.executable, "-B", "-c", "import sys, study_lib.command as c; sys.exit(c.main(sys.argv[1:]))",
                str(self.scene), "--reference", str(self.folder / "ref.exr"), "--mask", str(self.folder / "mask.pfm"),
                "--sweep", str(self.folder / "sweep.json"), "--seeds", seeds, "--render", RENDER, "--compare", COMPARE,
                "--render-option=--rfilter=box", "-o", str(self.folder / out), *more]

    def study(self, *more, **options):
        return subprocess.run(self.command(*more, **options), capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(ROOT / "tools")})

    def test_whole(self):
        # Killed once some of its six runs are done, with a line torn besides.
        book = self.folder / "out" / "runs.jsonl"
        child = subprocess.Popen(self.command(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                 env={**os.environ, "PYTHONPATH": str(ROOT / "tools")}, start_new_session=True)
        runs = lambda: [e for e in map(json.loads, book.read_bytes().split(b"\n")[:-1]) if e["kind"] == "run"]
        while child.poll() is None and not (book.exists() and len(runs()) >= 2):
            time.sleep(0.01)
        os.killpg(child.pid, signal.SIGKILL)
        child.wait()
        before = runs()
        self.assertTrue(2 <= len(before) < 6, len(before))
        with open(book, "ab") as f:
            f.write(b'{"kind": "run", "key": "to')

        done = self.study("--peers", str(self.folder / "peers.csv"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"{len(before)} of 6 runs are done already", done.stderr)
        after = runs()
        self.assertEqual(after[:len(before)], before)  # none was made again
        self.assertEqual(len({e["key"] for e in after}), 6)
        self.assertEqual(len(after), 6)

        with open(self.folder / "out" / "points.csv", newline="") as f:
            points = list(csv.DictReader(f))
        self.assertEqual([(p["series"], p["point"], p["seeds"]) for p in points],
                         [("cache", "spp 16", "2"), ("path", "spp 16", "2"), ("path", "spp 64", "2")])
        for p in points:
            for column in ("seconds", "cpu_seconds", "device_seconds", "rays", "peak_bytes", "rel_rmse", "relmse",
                           "variance"):
                self.assertGreater(float(p[column]), 0, column)
        self.assertEqual([float(p["records"]) > 0 for p in points], [True, False, False])
        # The error of paths is noise alone, all of it (the reference's own, of 1024, is a quarter of the last's: 3 % of
        # what is seen), and falls as 1/sqrt(spp) or, as far as first vertices are stratified, faster.
        path = points[1:]
        for p in path:
            self.assertAlmostEqual(float(p["noise"]) / float(p["rel_rmse"]), 1, delta=0.15)
        ratio = float(path[0]["rel_rmse"]) / float(path[1]["rel_rmse"])
        self.assertTrue(1.8 < ratio < 2.83, ratio)  # 4^(1/2) to 4^(3/4)

        text = (self.folder / "out" / "study.html").read_text()
        page = Page(text)
        self.assertEqual(page.opened, [])
        for tag, attribute, value in page.links:
            self.assertTrue(value.startswith("data:"), f"{tag} {attribute}={value[:60]}")
        for outside in ("url(", "@import", "fetch(", "XMLHttpRequest", "<link"):
            self.assertNotIn(outside, text)
        self.assertEqual(page.images, 3 + 1)  # reference and two series; error against time: no other axis varies
        self.assertGreater(page.rows, 3 + 3)
        self.assertIn("other &lt;one&gt;", text)
        for name in ("error-time.svg", "error-time.png", "runs.csv"):
            self.assertGreater((self.folder / "out" / name).stat().st_size, 500)

        # Nothing is left to do; a report alone renders nothing.
        count = len(book.read_bytes().splitlines())
        again = self.study("--report-only")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(len(book.read_bytes().splitlines()), count)

    def test_bad_input_is_one_line(self):
        for more, status, what in ((["--sweep", "nonsense"], 1, "no such sweep"),
                                   (["--reference", "/dev/null"], 1, "an EXR or PFM that can be read was expected"),
                                   (["--mask", "/no/mask.exr"], 1, "/no/mask.exr"), (["--seeds", "0"], 2, "at least 1"),
                                   (["--ref-b", "x.exr", "--ref-error", "0.1"], 2, "--ref-error"),
                                   (["--series", "no*"], 1, "no series is left")):
            done = self.study(*more, out="bad")
            self.assertEqual(done.returncode, status, done.stderr)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
            self.assertIn(what, done.stderr)

    def test_an_option_that_render_does_not_have(self):
        wrong = self.folder / "wrong.json"
        wrong.write_text(json.dumps({"series": [{"name": "s", "vary": "--no-such-option", "values": [1]}]}))
        done = self.study("--sweep", str(wrong), out="wrong")
        self.assertEqual(done.returncode, 1)
        self.assertIn("series s: render:", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
