"""Record files (docs/record-format.md) as numpy arrays. Reads what `render --save-records` writes, with every check of the
bytes that the renderer makes; bounds of the numbers themselves are the renderer's affair."""
import struct

import numpy as np

MAGIC = b"\x89IRREC\r\n"
VERSION = 1
HEADER = struct.Struct("=8sIIIIQQQ3d3f3f2QQ")
BLOCK = struct.Struct("=IIIIQQQ")
IRRADIANCE, RADIANCE, IRRADIANCE_SUPPORT, RADIANCE_SUPPORT, VIEW = 1, 2, 3, 4, 5
SAMPLE_FLOATS, HARMONIC_SETS = 10, 9

KEY = np.dtype([("p", "f4", 3), ("support1", "f4"), ("n", "f4", 3), ("support2", "f4"), ("t2", "f4", 3), ("coat", "u4")])
VALUE = np.dtype([("e", "f4", 3), ("rotation", "f4", (3, 3)), ("translation", "f4", (3, 3)), ("minimum", "f4"),
                  ("pixel", "u4"), ("harmonic", "f4")])
SUPPORT = np.dtype([("record", "u4"), ("support1", "f4"), ("support2", "f4")])
VIEW_TYPE = np.dtype([("camera", "f4", 20), ("width", "u4"), ("height", "u4"), ("kinds", "u4"), ("pad", "u4")])
assert (KEY.itemsize, VALUE.itemsize, SUPPORT.itemsize, VIEW_TYPE.itemsize) == (48, 96, 12, 96)
assert (HEADER.size, BLOCK.size) == (120, 40)

_P1, _P2, _P3, _MASK = 0x9e3779b185ebca87, 0xc2b2ae3d27d4eb4f, 0x165667b19e3779f9, (1 << 64) - 1


class Error(Exception):
    """One line: the file, what was found, what was expected."""


def _rotl(x, n):
    return ((x << n) | (x >> (64 - n))) & _MASK


def checksum(data, seed=0):
    """That of src/core/checksum.h: words of eight bytes, the last one padded with zeros."""
    h = (seed + len(data) * _P1 + _P3) & _MASK
    words = np.frombuffer(bytes(data) + bytes(-len(data) % 8), dtype="=u8")
    with np.errstate(over="ignore"):  # all that does not depend on the word before, at once
        mixed = words * np.uint64(_P2)
        mixed = ((mixed << np.uint64(31)) | (mixed >> np.uint64(33))) * np.uint64(_P1)
    for word in mixed.tolist():
        h = (_rotl(h ^ word, 27) * _P1 + _P3) & _MASK
    h = ((h ^ (h >> 33)) * _P2) & _MASK
    h = ((h ^ (h >> 29)) * _P3) & _MASK
    return h ^ (h >> 32)


class Records:
    """keys and values (structured arrays, one element a record); of radiance records also samples, of shape (records, 10,
    stride), and harmonics, (records, 9, order²)."""

    def __init__(self):
        self.keys, self.values = np.zeros(0, KEY), np.zeros(0, VALUE)
        self.stride = self.order = 0
        self.samples, self.harmonics = np.zeros((0, SAMPLE_FLOATS, 0), "f4"), np.zeros((0, HARMONIC_SETS, 0), "f4")

    def __len__(self):
        return len(self.keys)


class RecordFile:
    """Everything in a file. `warning`: what was lost of a damaged one, or ''."""

    def __init__(self, path):
        self.path, self.warning = path, ""
        try:
            with open(path, "rb") as f:
                self._data = f.read()
        except OSError as error:
            raise Error(f"{path}: cannot be read: {error.strerror}") from None
        self.irradiance, self.radiance, self.views = Records(), Records(), np.zeros(0, VIEW_TYPE)
        at = self._read_header()
        parts = {IRRADIANCE: [], RADIANCE: []}
        self._views = []
        self._at_end = []
        while at < len(self._data) and not self.warning:
            at = self._read_block(at, parts)
        self._join(parts)
        del self._data

    def _read_header(self):
        data, path = self._data, self.path
        if data[:8] != MAGIC:
            raise Error(f"{path}: not a record file, expected one that render --save-records wrote")
        if len(data) < HEADER.size:
            raise Error(f"{path}: cut off: {len(data)} bytes, the header alone has {HEADER.size}")
        fields = HEADER.unpack_from(data)
        order, version, header_bytes, text_bytes = fields[1:5]
        if order == 0x04030201:
            raise Error(f"{path}: written on a machine of the other byte order, expected this one's")
        if order != 0x01020304:
            raise Error(f"{path}: damaged record file: no byte order mark")
        if version != VERSION:
            raise Error(f"{path}: record file of version {version}, expected {VERSION}")
        if header_bytes != (HEADER.size + text_bytes + 7) // 8 * 8 or header_bytes > len(data):
            raise Error(f"{path}: damaged record file: the header's size does not fit")
        self.hashes = dict(zip(("geometry", "materials", "emitters"), fields[5:8]))
        self.centre = np.array(fields[8:11])
        self.lower, self.upper = np.array(fields[11:14]), np.array(fields[14:17])
        self._seed = fields[19]
        blank = data[:HEADER.size - 8] + bytes(8)
        if checksum(data[HEADER.size:header_bytes], checksum(blank)) != self._seed:
            raise Error(f"{path}: damaged record file: checksum of the header does not match")
        text = data[HEADER.size:HEADER.size + text_bytes].decode("ascii", "replace")
        self.settings = dict(line.split(" ", 1) for line in text.splitlines())
        return header_bytes

    def _lost(self, how, at):
        self.warning = (f"{self.path}: {how} from byte {at} on: of {len(self._data)} bytes the last "
                        f"{len(self._data) - at} are lost")
        return at

    def _read_block(self, at, parts):
        data, head = self._data, at
        seed = self._seed ^ (at * _P1 & _MASK)
        if len(data) - at < BLOCK.size:
            return self._lost("cut off", at)
        kind, count, stride, order, size, total, own = BLOCK.unpack_from(data, at)
        if checksum(data[at:at + BLOCK.size - 8], seed) != own:
            return self._lost("damaged", at)
        at += BLOCK.size
        floats = SAMPLE_FLOATS * stride + HARMONIC_SETS * order * order
        each = {IRRADIANCE: KEY.itemsize + VALUE.itemsize, RADIANCE: KEY.itemsize + VALUE.itemsize + 4 * floats,
                IRRADIANCE_SUPPORT: SUPPORT.itemsize, RADIANCE_SUPPORT: SUPPORT.itemsize, VIEW: VIEW_TYPE.itemsize}
        if kind not in each or size != (count * each[kind] + 7) // 8 * 8 or count == 0:
            raise Error(f"{self.path}: damaged record file: a block of kind {kind} with {count} elements has {size} bytes")
        if size > len(data) - at:
            return self._lost("cut off", head)
        payload = memoryview(data)[at:at + size]
        if checksum(payload, seed) != total:
            return self._lost("damaged", head)
        self._take(kind, count, stride, order, payload, parts)
        return at + size

    def _take(self, kind, count, stride, order, payload, parts):
        if kind == VIEW:
            self._views.append(np.frombuffer(payload, VIEW_TYPE, count))
        elif kind in (IRRADIANCE_SUPPORT, RADIANCE_SUPPORT):
            self._at_end.append((kind - 2, np.frombuffer(payload, SUPPORT, count)))  # later ones are the smaller ones
        else:
            keys = np.frombuffer(payload, KEY, count)
            values = np.frombuffer(payload, VALUE, count, KEY.itemsize * count)
            at = (KEY.itemsize + VALUE.itemsize) * count
            samples = np.frombuffer(payload, "f4", count * SAMPLE_FLOATS * stride, at)
            harmonics = np.frombuffer(payload, "f4", count * HARMONIC_SETS * order * order, at + samples.nbytes)
            parts[kind].append((keys, values, samples.reshape(count, SAMPLE_FLOATS, stride),
                                harmonics.reshape(count, HARMONIC_SETS, order * order)))
            if kind == RADIANCE:
                if len(parts[kind]) > 1 and (stride, order) != (self.radiance.stride, self.radiance.order):
                    raise Error(f"{self.path}: damaged record file: radiance records of two layouts")
                self.radiance.stride, self.radiance.order = stride, order

    def _join(self, parts):
        for kind, records in ((IRRADIANCE, self.irradiance), (RADIANCE, self.radiance)):
            if parts[kind]:
                records.keys, records.values, records.samples, records.harmonics = (
                    np.concatenate(arrays) for arrays in zip(*parts[kind]))
            for of, supports in self._at_end:
                if of != kind:
                    continue
                if supports["record"].max() >= len(records):
                    raise Error(f"{self.path}: damaged record file: a support of a record that is not there")
                for name in ("support1", "support2"):
                    records.keys[name][supports["record"]] = supports[name]
        if self._views:
            self.views = np.concatenate(self._views)
