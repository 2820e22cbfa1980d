"""DIR/runs.jsonl: one line of JSON for each thing that is done, written through to the disk before the next begins.

A line has a "kind" (run, errors, flip) and a "key", the hash of everything that it depends on; a study that was killed
skips what is there. A last line without its end (power cut, full disk) is dropped, and overwritten by the next.
"""
import fcntl
import hashlib
import json
import os
import pathlib
import sys

from . import BadInput


def key_of(definition):
    return hashlib.sha256(json.dumps(definition, sort_keys=True).encode()).hexdigest()[:16]


def file_hash(path):
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as f:
            while block := f.read(1 << 20):
                digest.update(block)
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror}, a file that can be read was expected") from None
    return digest.hexdigest()[:16]


class Ledger:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.path = self.folder / "runs.jsonl"
        self.pictures = self.folder / "pictures"
        try:
            self.pictures.mkdir(parents=True, exist_ok=True)
            self._file = open(self.path, "a+b")
        except OSError as error:
            raise BadInput(f"{self.folder}: {error.strerror}, a folder that can be written was expected") from None
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise BadInput(f"{self.folder}: another tools/study is at work there, a folder of its own was "
                           "expected") from None
        self._entries = {}
        self._read()

    def _read(self):
        self._file.seek(0)
        whole = 0
        for number, line in enumerate(self._file, 1):
            if not line.endswith(b"\n"):
                print(f"study: {self.path}:{number}: the line was cut off; its run is made again", file=sys.stderr)
                break
            whole += len(line)
            try:
                entry = json.loads(line)
                self._entries[entry["kind"], entry["key"]] = entry
            except (ValueError, KeyError, TypeError):
                print(f"study: {self.path}:{number}: no run of a study was found there; passed over", file=sys.stderr)
        self._file.truncate(whole)

    def get(self, kind, key):
        return self._entries.get((kind, key))

    def picture(self, key):
        return self.pictures / f"{key}.exr"

    def add(self, kind, key, **values):
        entry = {"kind": kind, "key": key, **values}
        self._file.write(json.dumps(entry).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())
        self._entries[kind, key] = entry
        return entry

    def close(self):
        self._file.close()
