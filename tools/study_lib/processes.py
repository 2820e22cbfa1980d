"""Programs run in processes of their own, with what they cost; and the machine that they run on.

Of a child, Linux counts as peak memory also what its parent held when it was forked. So this module, and all that is
imported while runs are made, gets by without NumPy: a bare Python is smaller than any renderer.
"""
import os
import pathlib
import platform
import subprocess
import tempfile
import threading
import time

from . import BadInput


class Failed(Exception):
    """A program that ran and failed: `status` (negative: a signal), and its last line."""

    def __init__(self, status, line):
        super().__init__(line)
        self.status = status


def cores(threads):
    """The cores that a renderer with so many threads is kept on; of those that this process may use. 0: all."""
    mine = sorted(os.sched_getaffinity(0))
    return mine if threads == 0 else mine[:threads]


def measured(arguments, threads, timeout=None, env=None, stdout=None, cwd=None):
    """Runs a program; seconds of the clock and of the CPU, and bytes of peak memory. `stdout`: a file."""
    keep = cores(threads)
    with tempfile.TemporaryFile() as messages, open(stdout or os.devnull, "wb") as out:
        began = time.monotonic()
        try:
            child = subprocess.Popen([str(a) for a in arguments], stdin=subprocess.DEVNULL, stderr=messages, cwd=cwd,
                                     stdout=out, env=env, preexec_fn=lambda: os.sched_setaffinity(0, keep))
        except OSError as error:
            raise BadInput(f"{arguments[0]}: {error.strerror}, a program was expected") from None
        late = threading.Event()
        timer = threading.Timer(timeout or 0, lambda: (late.set(), child.kill()))
        timer.daemon = True
        if timeout:
            timer.start()
        try:
            _, status, usage = os.wait4(child.pid, 0)
        except BaseException:
            child.kill()
            child.wait()
            raise
        finally:
            timer.cancel()
        wall = time.monotonic() - began
        child.returncode = os.waitstatus_to_exitcode(status)
        messages.seek(0)
        lines = messages.read().decode(errors="replace").strip().splitlines()
    if late.is_set():
        raise Failed(child.returncode, f"stopped after {timeout:g} s (--timeout)")
    if child.returncode != 0:
        raise Failed(child.returncode, lines[-1] if lines else f"ended with status {child.returncode}")
    return {"wall_seconds": wall, "cpu_seconds": usage.ru_utime + usage.ru_stime, "user_seconds": usage.ru_utime,
            "system_seconds": usage.ru_stime, "peak_bytes": usage.ru_maxrss * 1024}


def output(arguments, cwd=None):
    """First line that a program prints, "" if it fails."""
    try:
        done = subprocess.run(arguments, capture_output=True, text=True, cwd=cwd)
    except OSError:
        return ""
    return done.stdout.strip().splitlines()[0] if done.returncode == 0 and done.stdout.strip() else ""


def machine():
    """What a run's times depend on besides the program."""
    model, memory = platform.processor() or platform.machine(), None
    try:
        for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
        for line in pathlib.Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemTotal"):
                memory = int(line.split()[1]) * 1024
    except OSError:
        pass
    return {"cpu": model, "cores": os.cpu_count(), "usable": sorted(os.sched_getaffinity(0)), "memory_bytes": memory,
            "system": f"{platform.system()} {platform.release()}", "python": platform.python_version()}


def commit(root):
    """Of the checkout that the tool lies in, "" if it is none."""
    head = output(["git", "rev-parse", "--short=12", "HEAD"], cwd=root)
    return head + (", with changes" if head and output(["git", "status", "--porcelain", "-uno"], cwd=root) else "")
