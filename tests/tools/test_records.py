"""tools/records: files of `render` read by another program. Arguments: render, and unittest's."""
import contextlib
import io
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from records_lib import command, record_file  # noqa: E402

RENDER = None


def run(*arguments):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = command.main([str(a) for a in arguments])
    return status, out.getvalue(), err.getvalue()


class Checksum(unittest.TestCase):
    def test_known(self):  # src/core/checksum.h worked out by hand for no bytes: only the end's mixing
        h, mask = 0x165667b19e3779f9, (1 << 64) - 1
        h = ((h ^ (h >> 33)) * 0xc2b2ae3d27d4eb4f) & mask
        h = ((h ^ (h >> 29)) * 0x165667b19e3779f9) & mask
        self.assertEqual(record_file.checksum(b""), h ^ (h >> 32))
        self.assertNotEqual(record_file.checksum(b"a"), record_file.checksum(b"a\0"))


class Files(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.at = pathlib.Path(cls.folder.name)
        common = ["--spp", "1", "--width", "24", "--height", "24", "--hemisphere", "4x16", "--grid-paths", "1024", "-q"]
        for name, scene, more in (("irradiance", "cornell-box", []), ("radiance", "glossy-box", ["--method", "radiance"]),
                                  ("harmonics", "glossy-box", ["--method", "radiance", "--glossy", "harmonics"])):
            call = [RENDER, ROOT / "scenes" / f"{scene}.xml", "-o", cls.at / "a.pfm", "--save-records", cls.at / name, *more]
            subprocess.run([*map(str, call), *common], check=True)
        # A second camera appends.
        text = (ROOT / "scenes/cornell-box.xml").read_text().replace('origin="0, 1, 4"', 'origin="1, 1, 3"')
        (cls.at / "moved.xml").write_text(text)
        (cls.at / "two").write_bytes((cls.at / "irradiance").read_bytes())
        call = [RENDER, cls.at / "moved.xml", "-o", cls.at / "a.pfm", "--load-records", cls.at / "two", "--save-records",
                cls.at / "two"]
        subprocess.run([*map(str, call), *common], check=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_hold_what_they_should(self):
        for name, stride, order in (("irradiance", 0, 0), ("radiance", 64, 0), ("harmonics", 0, 5)):
            file = record_file.RecordFile(str(self.at / name))
            self.assertEqual(file.warning, "")
            self.assertEqual(file.settings["hemisphere"], "4x16")
            self.assertEqual((file.radiance.stride, file.radiance.order), (stride, order))
            for records in (file.irradiance, file.radiance):
                if len(records) == 0:
                    continue
                np.testing.assert_allclose(np.linalg.norm(records.keys["n"], axis=1), 1, atol=1e-4)
                self.assertTrue((records.values["e"] >= 0).all() and (records.keys["support1"] > 0).all())
                self.assertTrue((records.keys["p"] >= file.lower - 0.1).all())
            if stride:  # E is the mean of the samples' radiance times pi
                mean = file.radiance.samples[:, 7:10, :].mean(axis=2) * np.pi
                np.testing.assert_allclose(mean, file.radiance.values["e"], rtol=1e-4, atol=1e-6)

    def test_grow(self):
        one, two = (record_file.RecordFile(str(self.at / name)) for name in ("irradiance", "two"))
        self.assertGreater(len(two.irradiance), len(one.irradiance))
        n = len(one.irradiance)
        np.testing.assert_array_equal(two.irradiance.values[:n], one.irradiance.values)
        self.assertTrue((two.irradiance.keys["support1"][:n] <= one.irradiance.keys["support1"]).all())
        self.assertEqual(len(two.views), 2)

    def test_statistics_and_exports(self):
        status, out, err = run(self.at / "radiance", "--npz", self.at / "r.npz", "--ply", self.at / "r.ply", "--radiance")
        self.assertEqual((status, err), (0, ""))
        file = record_file.RecordFile(str(self.at / "radiance"))
        self.assertIn(f"radiance records: {len(file.radiance)}\n", out)
        self.assertIn("view: 24 x 24 from (0, 1.1, 2.95), irradiance and radiance", out)
        with np.load(self.at / "r.npz") as arrays:
            np.testing.assert_array_equal(arrays["radiance_samples"], file.radiance.samples)
            np.testing.assert_array_equal(arrays["irradiance_translation"], file.irradiance.values["translation"])
        header, body = (self.at / "r.ply").read_bytes().split(b"end_header\n", 1)
        names = [line.split() for line in header.decode().splitlines() if line.startswith("property")]
        kinds = {"double": "<f8", "float": "<f4", "uchar": "u1"}
        rows = np.frombuffer(body, [(name, kinds[kind]) for _, kind, name in names])
        self.assertEqual(len(rows), len(file.radiance))
        np.testing.assert_array_equal(rows["y"], file.radiance.keys["p"][:, 1].astype(float) + file.centre[1])
        np.testing.assert_array_equal(rows["E_g"], file.radiance.values["e"][:, 1])
        np.testing.assert_array_equal(rows["R"], file.radiance.values["harmonic"])
        np.testing.assert_allclose(rows["gz"], file.radiance.values["translation"][:, :, 2] @ command.LUMINANCE, rtol=1e-4,
                                   atol=1e-5)

    def test_damage(self):
        data = (self.at / "two").read_bytes()
        file = self.at / "damaged"
        for name, changed, status, what in (
                ("cut", data[:-3], 0, "cut off from byte"), ("flip", data[:-200] + bytes([data[-200] ^ 4]) + data[-199:], 0,
                                                             "damaged from byte"),
                ("magic", b"x" + data[1:], 1, "not a record file"), ("empty", b"", 1, "not a record file"),
                ("version", data[:12] + b"\7" + data[13:], 1, "version 7, expected 1"),
                ("header", data[:50] + b"\7" + data[51:], 1, "checksum of the header")):
            file.write_bytes(changed)
            found, _, err = run(file)
            self.assertEqual(found, status, name)
            self.assertIn(what, err)
            self.assertEqual(err.count("\n"), 1)
        self.assertEqual(run(self.at / "none")[0], 1)
        self.assertEqual(run(self.at / "two", "--ply", self.at / "none" / "a.ply")[0], 1)


if __name__ == "__main__":
    RENDER = sys.argv.pop(1)
    unittest.main()
