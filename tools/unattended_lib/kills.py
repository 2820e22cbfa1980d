"""tools/unattended kills."""
import os
import random
import shutil
import signal

from . import common
from .watched_run import Moment, Run, done_again

EVERY = .3  # seconds between checkpoints
HOW = [(signal.SIGKILL, -9), (signal.SIGTERM, 143), (signal.SIGKILL, -9), (signal.SIGINT, 130), (signal.SIGTERM, 143)]


class Case:
    def __init__(self, name, arguments, outputs, checkpoints=("state",), files=(), orders=(), cold=False):
        self.name, self.outputs, self.checkpoints, self.files, self.cold = name, outputs, checkpoints, dict(files), cold
        self.arguments = [*arguments, "--threads", "1", "--checkpoint", "state", "--checkpoint-every", f"{EVERY}s"]
        self.orders = {job: i for i, job in enumerate(orders)}


def cases(scenes):
    cornell, glossy = os.path.join(scenes, "cornell-box.xml"), os.path.join(scenes, "glossy-box.xml")
    picture = ["a.exr", "a.pfm", "a.png"]
    out = [name for path in picture for name in ("-o", path)]
    frames = [f"a.{i:02}.{kind}" for i in range(1, 7) for kind in ("exr", "png")]
    jobs = """{"jobs": [
  {"name": "path", "scene": "%s", "output": ["p.pfm", "p.png"], "options": {"method": "path", "width": 128, "spp": 200}},
  {"name": "cache", "scene": "%s", "output": "c.exr", "options": {"width": 160, "save-records": "c.records"}},
  {"name": "again", "scene": "%s", "output": "d.pfm", "options": {"width": 128, "load-records": "c.records"}}]}
""" % (cornell, cornell, cornell)
    return [
        Case("irradiance", [cornell, "--width", "256", "--pixel-error", "0.005", "--save-records", "r", *out],
             [*picture, "r"]),
        Case("radiance", [glossy, "--width", "128", "--method", "radiance", "--save-records", "r", *out], [*picture, "r"]),
        Case("path tracing", [cornell, "--width", "160", "--spp", "400", "--method", "path", *out], picture),
        Case("path tracing, no kernels cached", [cornell, "--width", "96", "--spp", "64", "--method", "path", *out], picture,
             cold=True),
        Case("6 frames, camera path", [cornell, "--width", "160", "--frames", "1-6", "--camera-path", "path.json",
                                       "--save-records", "r", "-o", "a.##.exr", "-o", "a.##.png"], [*frames, "r"],
             files={"path.json": common.CAMERA_PATH}),
        Case("3 jobs", ["--batch", "jobs.json"], ["p.pfm", "p.png", "c.exr", "c.records", "d.pfm"],
             checkpoints=("state.path", "state.cache", "state.again"), files={"jobs.json": jobs},
             orders=("path", "cache", "again")),
    ]


class Prover:
    """Kills runs of one case, and counts."""

    def __init__(self, args, case, folder, table, chance):
        self.args, self.case, self.folder, self.table, self.chance = args, case, folder, table, chance
        self.kills = self.chains = self.missed = self.from_checkpoint = self.litter = 0
        self.stages, self.lost = {}, {"SIGKILL": [], "asked": []}
        unbroken = self.run(self.fresh("unbroken"))
        if unbroken.status != 0:
            raise SystemExit(f"unattended: {case.name}: the unbroken run ends with {unbroken.status}: {unbroken.err}")
        self.finals = {path: common.read(os.path.join(self.place, path)) for path in case.outputs}
        missing = [path for path, data in self.finals.items() if data is None]
        if missing:
            raise SystemExit(f"unattended: {case.name}: the unbroken run writes no {', '.join(missing)}")
        again = self.run(self.fresh("again"))  # nothing has to be compiled now, unless it is meant to be
        self.check_done(again, "a second unbroken run")
        self.seconds = again.seconds
        self.known_stages = list(again.stage_began)

    def fresh(self, name):
        self.place = os.path.join(self.folder, name)
        shutil.rmtree(self.place, ignore_errors=True)
        os.makedirs(self.place)
        for file, text in self.case.files.items():
            common.write(self.place, file, text)
        self.environment = None
        if self.case.cold:
            caches = os.path.join(self.folder, "caches")
            shutil.rmtree(caches, ignore_errors=True)
            self.environment = common.own_caches(caches)
        return self.place

    def run(self, place, **more):
        return Run(self.args, self.case, place, self.environment, **more)

    def wrong(self, where, what):
        self.table.fail(f"{self.case.name}: {where}: {what}")

    def check_files(self, run, where):
        for path in run.broken:
            self.wrong(where, f"{path} was there with other bytes than the unbroken run's")
        known = {*self.case.outputs, *self.case.checkpoints, *self.case.files}
        for path in common.files_in(self.place):
            if common.LITTER.search(path):
                self.litter += 1
            elif path not in known:
                self.wrong(where, f"{path} was left")

    def check_done(self, run, where):
        if run.status != 0:
            self.wrong(where, f"exit status {run.status}, expected 0: {run.err.strip()}")
        self.check_files(run, where)
        for path in self.case.outputs:
            if common.read(os.path.join(self.place, path)) != getattr(self, "finals", {}).get(path):
                self.wrong(where, f"{path} differs from the unbroken run's")
        for path in self.case.checkpoints:
            if os.path.exists(os.path.join(self.place, path)):
                self.wrong(where, f"{path} is still there")

    def moment(self, left):
        """Half of them spread over the time that is left, half over what it does, however short."""
        if self.chance.random() < .5:
            return Moment(self.chance.uniform(0, left))
        return Moment(self.chance.uniform(0, .15), self.chance.choice(self.known_stages))

    def there(self):
        return [path for path in self.case.checkpoints if os.path.exists(os.path.join(self.place, path))]

    def chain(self, wanted, how):
        """Kills one render up to `wanted` times, and lets it end. Returns how many kills hit."""
        self.fresh("killed")
        self.chains += 1
        hits, before, left = 0, None, self.seconds
        while True:
            where = f"render {self.chains}, run {hits + 1}"
            checkpoints = self.there()
            kill, status = how(hits)
            moment = self.moment(left) if hits < wanted else None
            group = self.chance.random() < .5  # terminals and schedulers signal all processes, compilers too
            run = self.run(self.place, finals=self.finals, moment=moment, how=kill, group=group)
            if checkpoints:
                self.from_checkpoint += 1
                if not any(f"going on from {path}" in run.err for path in checkpoints) and run.positions:
                    self.wrong(where, f"{checkpoints[0]} was there, but it did not go on from it: {run.err.strip()}")
            self.compare(before, run, where)
            if run.killed is None or run.status == 0:
                self.missed += moment is not None
                self.check_done(run, where)
                return hits
            hits += 1
            self.kills += 1
            self.stages[run.ended_by] = self.stages.get(run.ended_by, 0) + 1
            early = not run.err and run.ended_by == "start-up" and run.status == -kill  # it had not begun to listen
            if run.status != status and not early:
                self.wrong(where, f"exit status {run.status} after {kill.name} in {run.ended_by}, expected {status}: "
                                  f"{run.err.strip()}")
            if status > 0 and not early and f"stopped by {kill.name}" not in run.err:
                self.wrong(where, f"says nothing of {kill.name}: {run.err.strip()}")
            self.check_files(run, where)
            # A run that had not come to the render yet changes nothing: its predecessor is what there is to lose.
            if run.positions:
                before = (run, kill)
            left = max(left - run.seconds / 2, 1)
            print(f"unattended: {self.case.name}: {kill.name}{' to all' if group else ''} in {run.ended_by} after {run.seconds:.1f} s", flush=True)

    def compare(self, before, run, where):
        if before is None or not run.positions:
            return
        killed, kill = before
        lost, launch = done_again(killed, run)
        if kill == signal.SIGKILL:
            self.lost["SIGKILL"].append(lost)
            bound = EVERY + launch + .3  # it is due within a launch, which is heard of every 0.2 s, and has to be written
        else:
            self.lost["asked"].append(lost)
            bound = 0
        if lost > bound:
            self.wrong(where, f"{lost:.2f} s before {kill.name} were done again, expected at most {bound:.2f} s")

    def row(self):
        def most(values):
            return f"{max(values):.2f} s ({len(values)})" if values else "-"
        stages = ", ".join(f"{stage} {n}" for stage, n in sorted(self.stages.items(), key=lambda item: -item[1]))
        self.table.add(self.case.name, f"{self.seconds:.1f} s", self.chains, self.kills, stages, self.from_checkpoint,
                       most(self.lost["SIGKILL"]), most(self.lost["asked"]), self.litter)


def run(args):
    chance = random.Random(args.seed)
    table = common.Table(f"{args.times} kills, --checkpoint-every {EVERY}s, one thread, seed {args.seed}.",
                         ["case", "unbroken", "renders", "kills", "killed in", "runs from a checkpoint",
                          "most done again after SIGKILL, less one launch (of)", "after SIGTERM, SIGINT (of)", "names left aside"])
    chosen = [case for case in cases(args.scenes) if args.only in case.name]
    if not chosen:
        raise SystemExit(f"unattended: --only {args.only}: no such case")
    total = 0
    with common.work_folder(args) as folder:
        provers = []
        for i, case in enumerate(chosen):
            place = os.path.join(folder, str(i))
            os.makedirs(place, exist_ok=True)
            provers.append(Prover(args, case, place, table, chance))
        while total < args.times and not (table.wrong and len(table.wrong) > 20):
            for prover in provers:
                if total < args.times:
                    wanted = min(chance.randint(1, 4), args.times - total)
                    begun = total
                    total += prover.chain(wanted, lambda hits, begun=begun: HOW[(begun + hits) % len(HOW)])
        for prover in provers:
            prover.row()
    table.note(f"{total} kills in all: every output of every render has the bytes of the unbroken one, and had whenever it "
               "was there." if not table.wrong else f"{total} kills in all.")
    return table
