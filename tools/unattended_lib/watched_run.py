"""One run of the executable that is watched, and killed at a given moment."""
import json
import os
import signal
import subprocess
import threading
import time

from . import common

STEP = .004  # seconds between looks at the files


class Moment:
    """When to kill: `after` seconds from the start or, with a stage, from the first word of that stage."""

    def __init__(self, after, stage=None):
        self.after, self.stage = after, stage

    def come(self, run, now):
        begun = run.began if self.stage is None else run.stage_began.get(self.stage)
        return begun is not None and now - begun >= self.after


class Run:
    """What `render --progress` said, when, and how it ended. A position in a render is (job, frame, rays traced)."""

    def __init__(self, args, case, folder, environment, finals=None, moment=None, how=signal.SIGKILL, group=False):
        self.stage_began, self.positions = {}, []
        self.stage, self.killed, self.broken, self.ended_by = "start-up", None, [], None
        self._at = (0, 0)
        self._orders = case.orders
        self._seen = {}
        stderr = os.path.join(folder, os.pardir, "stderr")
        with open(stderr, "w+b") as err:
            self.began = time.monotonic()
            process = subprocess.Popen([args.render, *case.arguments, "--progress"], cwd=folder, env=environment,
                                       stdout=subprocess.PIPE, stderr=err, stdin=subprocess.DEVNULL,
                                       start_new_session=True)
            listener = threading.Thread(target=self._listen, args=(process.stdout,))
            listener.start()
            while process.poll() is None:
                now = time.monotonic()
                if moment is not None and self.killed is None and moment.come(self, now):
                    self.killed, self.ended_by = time.monotonic(), self.stage
                    if group:
                        os.killpg(process.pid, how)
                    else:
                        process.send_signal(how)
                if finals is not None:
                    self._look(folder, finals)
                time.sleep(STEP)
            self.ended = time.monotonic()
            self.seconds = self.ended - self.began
            listener.join()
            process.stdout.close()
            err.seek(0)
            self.err = err.read().decode("utf-8", "replace")
        if finals is not None:
            self._look(folder, finals)
        self.status = process.returncode

    def _look(self, folder, finals):
        """Every output that is there must be whole."""
        for path, final in finals.items():
            whole = os.path.join(folder, path)
            try:
                state = os.stat(whole)
            except FileNotFoundError:
                continue
            mark = (state.st_ino, state.st_size, state.st_mtime_ns)
            if self._seen.get(path) == mark:
                continue
            self._seen[path] = mark
            found = common.read(whole)
            if found is not None and found != final and path not in self.broken:
                self.broken.append(path)

    def _listen(self, out):
        for line in out:
            now = time.monotonic()
            try:
                event = json.loads(line)
            except ValueError:
                continue  # the line in which it was killed
            kind, stage = event.get("event"), event.get("stage")
            if kind == "progress":
                self.stage = stage
                self.stage_began.setdefault(stage, now)
                if stage == "loading: checks":  # nothing is heard until the first launch is done
                    self.stage = "first launch"
                if event.get("rays"):
                    job = self._orders.get(event.get("job"), 0)
                    self.positions.append((now, (job, event.get("frame", 0), event["rays"])))

    def first(self):
        """Where the render was when it was first heard of."""
        return self.positions[0][1] if self.positions else None


def done_again(before, after):
    """Seconds of `before`, a run that was killed, that `after`, which went on from it, did again, less the launch with which
    it began; and the longest time in them in which nothing was heard: a launch."""
    first = after.first()
    again = [t for t, position in before.positions if position > first and t <= before.killed]
    if not again:
        return 0.0, 0.0
    heard = [*again, before.killed]
    return before.killed - again[0], max(b - a for a, b in zip(heard, heard[1:]))
