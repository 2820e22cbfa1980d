"""tools/unattended faults."""
import contextlib
import ctypes
import os
import shutil
import subprocess
import time

from . import common

CLONE_NEWNS = 0x20000


def own_mounts():
    """Mounts made from now on are this process's and its children's alone. False: it may not mount."""
    libc = ctypes.CDLL(None, use_errno=True)
    if os.geteuid() != 0 or libc.unshare(CLONE_NEWNS) != 0:
        return False
    return subprocess.run(["mount", "--make-rprivate", "/"], capture_output=True, check=False).returncode == 0


@contextlib.contextmanager
def small_disk(where, options):
    os.makedirs(where, exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", where], check=True)
    try:
        yield where
    finally:
        subprocess.run(["umount", "-l", where], check=True)


def make_read_only(where):
    subprocess.run(["mount", "-o", "remount,ro", where], check=True)


class Faults:
    def __init__(self, args, table, folder):
        self.args, self.table, self.folder = args, table, folder
        self.cornell = os.path.join(args.scenes, "cornell-box.xml")
        self.small = ["--threads", "1", "--width", "32"]

    def fresh(self, name):
        place = os.path.join(self.folder, name)
        shutil.rmtree(place, ignore_errors=True)
        os.makedirs(place)
        return place

    def judge(self, case, done, place, status, says, there=(), absent=(), lines=1, equal=()):
        """`says`: parts of lines about what is wrong, one line each. Files `there` must be as those of `equal`, if any."""
        wrong = []
        if done.returncode != status:
            wrong.append(f"exit status {done.returncode}, expected {status}")
        said = done.stderr.splitlines()
        spoken = []
        for parts in says:
            hits = [line for line in said if all(part in line for part in parts)]
            if len(hits) != lines:
                wrong.append(f"{len(hits)} lines with {' and '.join(parts)}, expected {lines}")
            spoken += hits[:1]
        for path in there:
            if not os.path.exists(os.path.join(place, path)):
                wrong.append(f"no {path}")
        for path in absent:
            if os.path.exists(os.path.join(place, path)):
                wrong.append(f"{path} is there")
        for path, other in equal:
            if common.read(os.path.join(place, path)) != common.read(other):
                wrong.append(f"{path} is not as it should be")
        wrong += [f"{path} was left" for path in common.litter_in(place)]
        for what in wrong:
            self.table.fail(f"{case}: {what}: {done.stderr.strip()}")
        quoted = "; ".join(line.removeprefix("render: ").replace(self.folder + "/", "").replace(self.args.scenes, "scenes")
                           for line in spoken)
        self.table.add(case, f"`{quoted}`" if quoted else "", done.returncode, "**no**" if wrong else "yes")
        print(f"unattended: {case}: {'WRONG' if wrong else 'as it must be'}", flush=True)

    def call(self, place, *arguments, before=None, environment=None):
        return common.call(self.args, arguments, place, before=before, environment=environment)

    # Disks ------------------------------------------------------------------------------------------------------------

    def full_disk(self):
        """Room for frame 1 alone."""
        place, lone = self.fresh("full"), self.fresh("lone")
        disk = os.path.join(place, "disk")
        arguments = [self.cornell, *self.small, "--frames", "1-3"]
        self.call(lone, *arguments, "-o", "a.##.pfm", "--save-records", "r")
        with small_disk(disk, "size=20k"):  # a picture has 12 302 bytes
            done = self.call(place, *arguments, "-o", "disk/a.##.pfm", "--save-records", "r")
            self.judge("disk full at frame 2 of 3; records elsewhere", done, place, 3,
                       [["frame 2", "disk/a.02.pfm", "No space left"], ["frame 3", "disk/a.03.pfm", "No space left"],
                        ["1 rendered", "failed: 2, 3"]], ["disk/a.01.pfm", "r"], ["disk/a.02.pfm", "disk/a.03.pfm"],
                       equal=[("disk/a.01.pfm", os.path.join(lone, "a.01.pfm")), ("r", os.path.join(lone, "r"))])
        place = self.fresh("full")
        with small_disk(disk, "size=20k"):
            done = self.call(place, *arguments, "-o", "a.##.pfm", "--save-records", "disk/r")
            self.judge("disk full at the record file (frames done)", done, place, 1, [["disk/r", "No space left"]],
                       ["a.01.pfm", "a.02.pfm", "a.03.pfm"], ["disk/r"],
                       equal=[(f"a.0{i}.pfm", os.path.join(lone, f"a.0{i}.pfm")) for i in (1, 2, 3)])
        with small_disk(disk, "size=20k"):  # and with a checkpoint: nothing is lost once there is room
            state = ["--checkpoint", "state", "--checkpoint-every", "600s", "--overwrite"]
            self.call(place, *arguments, "-o", "a.##.pfm", "--save-records", "disk/r", *state)
            subprocess.run(["mount", "-o", "remount,size=1m", disk], check=True)
            done = self.call(place, *arguments, "-o", "a.##.pfm", "--save-records", "disk/r", *state)
            self.judge("the same with a checkpoint, and again once there is room", done, place, 0,
                       [["going on from state"], ["wrote disk/r"]], ["disk/r"], ["state"],
                       equal=[("disk/r", os.path.join(lone, "r"))])
        place = self.fresh("full")
        with small_disk(disk, "size=8k"):
            done = self.call(place, self.cornell, "--threads", "1", "--width", "128", "--spp", "200", "--method", "path",
                             "-o", "a.pfm", "--checkpoint", "disk/state", "--checkpoint-every", "60s")
            self.judge("disk too small for a checkpoint that was not due", done, place, 0, [], ["a.pfm"], ["disk/state"])
            done = self.call(place, self.cornell, *self.small, "--frames", "1-2", "-o", "b.##.pfm",
                             "--checkpoint", "disk/state", "--checkpoint-every", "600s")
            self.judge("disk too small for the checkpoint before a frame's file", done, place, 0,
                       [["frame 1", "disk/state", "No space left"], ["frame 2", "disk/state", "No space left"]],
                       ["b.01.pfm", "b.02.pfm"], ["disk/state"],
                       equal=[(f"b.0{i}.pfm", os.path.join(lone, f"a.0{i}.pfm")) for i in (1, 2)])
        place = self.fresh("full")
        jobs = '{"jobs": [{"name": "large", "scene": "%s", "output": "disk/a.exr", "options": {"width": 128, "aov": "all"}},' \
               '{"name": "small", "scene": "%s", "output": "disk/b.png", "options": {"width": 16}},' \
               '{"name": "elsewhere", "scene": "%s", "output": "c.pfm", "options": {"width": 32}}]}' % ((self.cornell,) * 3)
        common.write(place, "jobs.json", jobs)
        with small_disk(disk, "size=40k"):
            done = self.call(place, "--batch", "jobs.json", "--threads", "1")
            self.judge("disk full at one of three jobs", done, place, 3,
                       [["job large", "disk/a.exr", "No space left"], ["jobs: 2 done", "failed: large"]],
                       ["disk/b.png", "c.pfm"], ["disk/a.exr"], equal=[("c.pfm", os.path.join(lone, "a.01.pfm"))])

    def read_only(self):
        place = self.fresh("read-only")
        disk = os.path.join(place, "disk")
        with small_disk(disk, "size=1m"):
            make_read_only(disk)
            done = self.call(place, self.cornell, *self.small, "-o", "disk/a.pfm")
            self.judge("folder of the picture is read-only", done, place, 1, [["disk/a.pfm", "Read-only"]], [], ["disk/a.pfm"])
            for option in ("--checkpoint", "--save-records"):
                done = self.call(place, self.cornell, *self.small, "-o", "a.pfm", option, "disk/f")
                self.judge(f"folder of {option} is read-only: before anything is rendered", done, place, 1,
                           [["disk/f", "Read-only"]], [], ["a.pfm"])
            common.write(place, "jobs.json",
                         '{"jobs": [{"name": "bad", "scene": "%s", "output": "disk/a.pfm"},'
                         '{"name": "good", "scene": "%s", "output": "b.pfm"}]}' % (self.cornell, self.cornell))
            done = self.call(place, "--batch", "jobs.json", *self.small)
            self.judge("folder of one of two jobs is read-only", done, place, 3,
                       [["job bad", "disk/a.pfm", "Read-only"], ["jobs: 1 done", "failed: bad"]], ["b.pfm"], ["disk/a.pfm"])
        with small_disk(disk, "size=1m"):  # the folder of compiled kernels: nothing is said, it only takes longer
            environment = common.own_caches(disk)
            make_read_only(disk)
            done = self.call(place, self.cornell, *self.small, "--method", "path", "-o", "k.pfm", environment=dict(
                os.environ, IRRADIA_SHIPPED_KERNELS="", IRRADIA_KERNEL_CACHE=environment["IRRADIA_KERNEL_CACHE"]))
            self.judge("cache of kernels is read-only", done, place, 0, [], ["k.pfm"])
            done = self.call(place, self.cornell, *self.small, "--method", "path", "-o", "l.pfm", environment=environment)
            self.judge("the driver's cache is read-only", done, place, 1, [["pocl_cache_dir", "Read-only"]], [], ["l.pfm"])
        with small_disk(disk, "size=1m"):
            environment = common.own_caches(disk)
            done = self.call(place, self.cornell, *self.small, "--method", "path", "-o", "l.pfm", environment=environment)
            self.judge("the driver's cache is on a full disk", done, place, 1, [["pocl_cache_dir", "free space"]], [],
                       ["l.pfm"])

    def nobody(self):
        """Permissions, which bind anyone but root."""
        place = self.fresh("locked")
        locked = os.path.join(place, "locked")
        os.makedirs(locked)
        os.chmod(self.folder, 0o755)
        os.chmod(locked, 0o555)
        os.chmod(place, 0o777)
        before = None
        if os.geteuid() == 0:
            def before():
                os.setgroups([])
                os.setgid(65534)
                os.setuid(65534)
        home = self.fresh("home")
        os.chmod(home, 0o777)
        environment = dict(os.environ, HOME=home, XDG_CACHE_HOME=home, POCL_CACHE_DIR=home)
        done = self.call(place, self.cornell, *self.small, "-o", "locked/a.pfm", before=before, environment=environment)
        self.judge("folder without permission to write", done, place, 1, [["locked/a.pfm", "Permission denied"]])

    # Limits: the same without mounts ----------------------------------------------------------------------------------

    def file_size(self):
        import resource
        place, lone = self.fresh("limit"), self.fresh("lone")
        arguments = [self.cornell, *self.small]
        self.call(lone, *arguments, "-o", "a.pfm")
        common.write(place, "jobs.json",
                     '{"jobs": [{"name": "large", "scene": "%s", "output": "a.pfm", "options": {"width": 256, "spp": 16}},'
                     '{"name": "small", "scene": "%s", "output": "b.pfm", "options": {"width": 32}}]}'
                     % (self.cornell, self.cornell))
        limit = 600 << 10
        done = self.call(place, "--batch", "jobs.json", "--threads", "1",
                         before=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
        self.judge("a file passes the limit of its size (ulimit -f)", done, place, 3,
                   [["job large", "a.pfm", "File too large"], ["jobs: 1 done", "failed: large"]], ["b.pfm"], ["a.pfm"],
                   equal=[("b.pfm", os.path.join(lone, "a.pfm"))])

    # Inputs -----------------------------------------------------------------------------------------------------------

    def scene_text(self, mesh=None):
        with open(self.cornell, encoding="utf-8") as file:
            text = file.read().replace('value="models/', f'value="{self.args.scenes}/models/')
        if mesh:
            shape = f'<shape type="obj"><string name="filename" value="{mesh}"/><bsdf type="diffuse"/></shape>'
            text = text.replace("</scene>", shape + "\n</scene>")
        return text

    def inputs(self):
        place = self.fresh("inputs")
        for i in (1, 3):
            common.write(place, f"s.{i}.xml", self.scene_text())
        done = self.call(place, "s.#.xml", *self.small, "--frames", "1-3", "-o", "a.#.pfm", "--save-records", "r")
        self.judge("scene of frame 2 of 3 is missing", done, place, 3,
                   [["frame 2", "s.2.xml"], ["2 rendered", "failed: 2"]], ["a.1.pfm", "a.3.pfm", "r"], ["a.2.pfm"])
        common.write(place, "s.2.xml", self.scene_text())
        done = self.call(place, "s.#.xml", *self.small, "--frames", "1-3", "-o", "a.#.pfm")
        self.judge("the same command once it is there: frame 2 alone", done, place, 0,
                   [["left as they are", "frames 1, 3"], ["1 rendered"]], ["a.2.pfm"])
        place = self.fresh("inputs")
        for i in (1, 2, 3):
            common.write(place, f"s.{i}.xml", self.scene_text()[:900 if i == 2 else None])
        done = self.call(place, "s.#.xml", *self.small, "--frames", "1-3", "-o", "a.#.pfm", "--save-records", "r")
        self.judge("scene of frame 2 of 3 is cut off", done, place, 3, [["frame 2", "s.2.xml:"], ["2 rendered", "failed: 2"]],
                   ["a.1.pfm", "a.3.pfm", "r"], ["a.2.pfm"])
        place = self.fresh("inputs")
        for i in (1, 2, 3):
            common.write(place, f"s.{i}.xml", self.scene_text(f"m{i}.obj"))
            common.write(place, f"m{i}.obj", "v 0 0 0\nv .1 0 0\nv 0 .1 0\nf 1 2 3\n")
        self.vanishing(place)
        place = self.fresh("inputs")
        for i in (1, 2, 3):
            common.write(place, f"s.{i}.xml", self.scene_text(f"m{i}.obj"))
            common.write(place, f"m{i}.obj", "v 0 0 0\nv .1 0 0\nv 0 .1 0\nf 1 2 3\n" if i < 3 else "v 0 0 0\nv .1 0\n")
        done = self.call(place, "s.#.xml", *self.small, "--frames", "1-3", "-o", "a.#.pfm", "--save-records", "r")
        self.judge("mesh of frame 3, the last, is cut off", done, place, 3,
                   [["frame 3", "m3.obj"], ["2 rendered", "failed: 3"]], ["a.1.pfm", "a.2.pfm", "r"], ["a.3.pfm"])
        if os.path.getsize(os.path.join(place, "r")) < 1000:
            self.table.fail("mesh of frame 3, the last, is cut off: the record file has lost the records")

    def vanishing(self, place):
        """A mesh is removed once the first frame is there."""
        process = subprocess.Popen([self.args.render, "s.#.xml", "--threads", "1", "--width", "96", "--frames", "1-3", "-o",
                                    "a.#.pfm"], cwd=place, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while process.poll() is None and not os.path.exists(os.path.join(place, "s.gone")):
            if os.path.exists(os.path.join(place, "a.1.pfm")):
                os.remove(os.path.join(place, "m3.obj"))
                break
            time.sleep(.002)
        out, err = process.communicate()
        self.judge("mesh of frame 3 is removed while frame 2 is rendered",
                   subprocess.CompletedProcess([], process.returncode, out, err), place, 3,
                   [["frame 3", "m3.obj"], ["2 rendered", "failed: 3"]], ["a.1.pfm", "a.2.pfm"], ["a.3.pfm"])

    def references(self):
        place = self.fresh("references")
        self.call(place, self.cornell, *self.small, "-o", "r.1.exr", "-o", "whole.pfm")
        whole = common.read(os.path.join(place, "r.1.exr"))
        for name, data in (("r.2.exr", whole[:len(whole) // 2]), ("r.3.exr", whole)):
            with open(os.path.join(place, name), "wb") as file:
                file.write(data)
        done = self.call(place, self.cornell, *self.small, "--frames", "1-3", "-o", "a.#.pfm", "--report", "a.#.html",
                         "--reference", "r.#.exr")
        self.judge("reference of frame 2 is cut off", done, place, 3, [["frame 2", "r.2.exr"], ["2 rendered", "failed: 2"]],
                   ["a.1.pfm", "a.3.pfm", "a.1.html", "a.3.html"], ["a.2.pfm", "a.2.html"])


def run(args):
    table = common.Table("What is said of faults, and whether all else was done.", ["fault", "said", "exit status", "as it must be"])
    with common.work_folder(args) as folder:
        mounts = own_mounts()
        faults = Faults(args, table, folder)
        if mounts:
            faults.full_disk()
            faults.read_only()
        else:
            table.note("May not mount here: full and read-only disks were left out.\n")
        faults.nobody()
        faults.file_size()
        faults.inputs()
        faults.references()
    return table
