"""What the three parts of tools/unattended share: folders, runs of the executable, and a table of what was found."""
import contextlib
import os
import re
import shutil
import subprocess
import tempfile

LITTER = re.compile(r"\.part-|\.tmp$")  # src/core/aside_file.cpp


class Table:
    def __init__(self, title, columns):
        self.title, self.columns, self.rows, self.wrong, self.notes = title, columns, [], [], []

    def add(self, *cells):
        self.rows.append([str(c) for c in cells])

    def fail(self, what):
        """Something is not as it must be."""
        self.wrong.append(what)
        print(f"unattended: WRONG: {what}", flush=True)

    def note(self, what):
        self.notes.append(what)

    def good(self):
        return not self.wrong and bool(self.rows)

    def markdown(self):
        lines = [self.title, "", "| " + " | ".join(self.columns) + " |", "|" + "---|" * len(self.columns)]
        lines += ["| " + " | ".join(c.replace("|", "\\|") for c in row) + " |" for row in self.rows]
        lines.append("")
        lines += self.notes
        lines += [f"- **wrong**: {w}" for w in self.wrong] or ["Nothing was found wrong."]
        return "\n".join(lines) + "\n"


@contextlib.contextmanager
def work_folder(args):
    """A folder to work in, that goes away unless --keep."""
    if args.keep:
        os.makedirs(args.keep, exist_ok=True)
        yield os.path.abspath(args.keep)
        return
    folder = tempfile.mkdtemp(prefix="unattended-")
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def own_caches(folder):
    """An environment whose kernel caches are empty ones in `folder`."""
    environment = dict(os.environ, IRRADIA_SHIPPED_KERNELS="")
    for name in ("IRRADIA_KERNEL_CACHE", "POCL_CACHE_DIR"):
        path = os.path.join(folder, name.lower())
        os.makedirs(path, exist_ok=True)
        environment[name] = path
    return environment


def call(args, arguments, folder, environment=None, before=None, timeout=600):
    """The executable's end: status, stdout, stderr."""
    return subprocess.run([args.render, *arguments], cwd=folder, env=environment, capture_output=True, text=True,
                          errors="replace", timeout=timeout, preexec_fn=before, stdin=subprocess.DEVNULL, check=False)


def read(path):
    try:
        with open(path, "rb") as file:
            return file.read()
    except FileNotFoundError:
        return None


def files_in(folder):
    """Paths of all files, from the folder."""
    out = []
    for where, _, names in os.walk(folder):
        out += [os.path.relpath(os.path.join(where, name), folder) for name in names]
    return sorted(out)


def litter_in(folder):
    return [path for path in files_in(folder) if LITTER.search(path)]


CAMERA_PATH = """{"keyframes": [
  {"frame": 1, "origin": [0, 1, 4.5], "target": [0, 1, 0]},
  {"frame": 6, "origin": [0.3, 1.1, 4.2], "target": [0, 0.9, 0]}
]}
"""


def write(folder, name, text):
    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
        file.write(text)
