"""The measurements: each runs `render` (or the benchmark) over sizes and returns rows for a CSV file."""
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

from . import report

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BOX = os.path.join(ROOT, "scenes", "cornell-box.xml")
METHODS = ("irradiance", "path")


class Renderer:
    """`render` with what all runs share."""

    def __init__(self, args, folder):
        self.args, self.folder = args, folder

    def line(self, scene, options):
        args = self.args
        line = [args.render, scene, "-o", os.path.join(self.folder, "x.pfm"), "-q"] + options
        if args.device is not None:
            line += ["--device", args.device]
        if args.threads and "--threads" not in options:
            line += ["--threads", str(args.threads)]
        return line

    def run(self, scene, options, environment=None):
        """--stats of one run, with `process`: seconds and CPU seconds of the whole process."""
        stats = os.path.join(self.folder, "x.json")
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        done = subprocess.run(self.line(scene, options) + ["--stats", stats], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True, env={**os.environ, **(environment or {})})
        seconds = time.perf_counter() - start
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode:
            raise RuntimeError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else
                               f"{self.args.render} ended with status {done.returncode}")
        with open(stats) as f:
            s = json.load(f)
        s["process"] = {"seconds": seconds,
                        "cpu": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime}
        return s

    def best(self, scene, options):
        """The run of the shortest render, of --repeat ones. The first one compiles kernels, which drivers may do when a
        kernel is launched first, and again for large launches: a run more makes sure that they are there."""
        runs = [self.run(scene, options) for _ in range(self.args.repeat + 1)][1:]
        return min(runs, key=lambda s: s["wall_seconds"]["render"])


def say(text):
    print(text, file=sys.stderr, flush=True)


def render_seconds(s):
    """Without the compiler, or what is left of it when kernels are cached."""
    return s["wall_seconds"]["render"] - s["stages"].get("build", {"seconds": 0})["seconds"]


def pixels(renderer, sizes, folder):
    rows = []
    for size in sizes:
        for method in METHODS:
            s = renderer.best(BOX, ["--method", method, "--spp", "4", "--width", str(size), "--height", str(size)])
            rows.append({"pixels": size * size, "method": method, "render_s": render_seconds(s),
                         "records": s["records"], "grid_s": s["phase_seconds"].get("grid", 0),
                         "records_s": s["phase_seconds"].get("records", 0),
                         "shade_s": s["phase_seconds"].get("shade", 0), "rays": s["rays"]["total"],
                         "device_peak_bytes": s["memory"]["device_peak_bytes"], "process_cpu_s": s["process"]["cpu"]})
            say(f"pixels: {size}x{size} by {method}: {rows[-1]['render_s']:.2f} s")
    series = {m: ([r["pixels"] for r in rows if r["method"] == m], [r["render_s"] for r in rows if r["method"] == m])
              for m in METHODS}
    of = [r for r in rows if r["method"] == "irradiance"]
    series["records made"] = ([r["pixels"] for r in of], [r["records_s"] for r in of])
    series["shading"] = ([r["pixels"] for r in of], [r["shade_s"] for r in of])
    report.plot_growth(folder, "pixels", "Cornell box, 4 samples a pixel", "pixels", "seconds", series)
    return rows


def records(renderer, sizes, folder):
    """Spacing sets the number: about 0.56 / spacing² records a pixel. Whatever else limits how far records reach is off, as
    it would keep their number above ten thousand."""
    width = renderer.args.width
    rows = []
    for wanted in sizes:
        spacing = max((0.56 * width * width / wanted) ** 0.5, 0.6)
        s = renderer.best(BOX, ["--spp", "1", "--hemisphere", "4x8", "--accuracy", "1", "--overlap", "1",
                                "--no-reach-limit", "--no-gradient-limit",
                                "--width", str(width), "--height", str(width),
                                "--min-spacing", f"{0.5 * spacing:.3f}", "--max-spacing", f"{spacing:.3f}"])
        stage = {name: t["seconds"] for name, t in s["stages"].items()}
        rows.append({"records": s["records"], "render_s": render_seconds(s),
                     "records_s": s["phase_seconds"]["records"], "shade_s": s["phase_seconds"]["shade"],
                     **{name + "_s": stage.get(name, 0) for name in (
                         "find_misses", "sample_hemispheres", "clamp_records", "insert_records",
                         "shade_pixels")},
                     "octree_bytes": 36 * s["octree"]["nodes"] + 8 * s["octree"]["entries"],
                     "octree_depth": s["octree"]["depth"], "device_peak_bytes": s["memory"]["device_peak_bytes"],
                     "process_cpu_s": s["process"]["cpu"]})
        say(f"records: {rows[-1]['records']} (spacing {spacing:.1f} pixels): {rows[-1]['render_s']:.2f} s")
    x = [r["records"] for r in rows]
    report.plot_growth(
        folder, "records", f"Cornell box, {width}x{width}, hemispheres of 4x8", "records", "seconds",
        {"render": (x, [r["render_s"] for r in rows]),
         "hemispheres": (x, [r["sample_hemispheres_s"] for r in rows]),
         "clamp and insertion": (x, [r["clamp_records_s"] + r["insert_records_s"] for r in rows]),
         "misses found": (x, [r["find_misses_s"] for r in rows]),
         "shading": (x, [r["shade_pixels_s"] for r in rows])})
    return rows


def triangles(renderer, sizes, folder):
    rows = []
    for wanted in sizes:
        with tempfile.TemporaryDirectory() as scene:
            subprocess.run([os.path.join(ROOT, "tools", "make-terrain"), scene, "--triangles", str(wanted)], check=True)
            s = renderer.best(os.path.join(scene, "terrain.xml"), ["--method", "path", "--spp", "4"])
        load = s["load_seconds"]
        rows.append({"triangles": s["scene"]["triangles"], "load_s": s["wall_seconds"]["load"],
                     "hierarchy_s": s["wall_seconds"]["accel"], "render_s": render_seconds(s),
                     "meshes_s": load.get("meshes", 0), "assembly_s": load.get("assembly", 0),
                     "trace_paths_s": s["stages"]["trace_paths"]["seconds"],
                     "rays_a_second": s["rays"]["total"] / s["stages"]["trace_paths"]["seconds"],
                     "load_peak_bytes": s["memory"]["load_peak_bytes"], "scene_bytes": s["memory"]["scene_bytes"],
                     "process_cpu_s": s["process"]["cpu"]})
        r = rows[-1]
        say(f"triangles: {r['triangles']}: loading {r['load_s']:.2f} s, hierarchy {r['hierarchy_s']:.2f} s, "
            f"rendering {r['render_s']:.2f} s")
    x = [r["triangles"] for r in rows]
    report.plot_growth(folder, "triangles", "Terrain, 320x240, path traced with 4 samples a pixel", "triangles",
                       "seconds", {label: (x, [r[key] for r in rows]) for label, key in (
                           ("loading", "load_s"), ("hierarchy", "hierarchy_s"), ("rendering", "render_s"))})
    return rows


def start(renderer, sizes, folder):
    """`sizes`: how many runs of each kind."""
    rows, series = [], {}
    for run in range(sizes[0]):
        for method in METHODS:
            with tempfile.TemporaryDirectory() as cache, tempfile.TemporaryDirectory() as other:
                # Where Irradia, PoCL and NVIDIA's driver keep compiled kernels.
                own, installed = ({"IRRADIA_KERNEL_CACHE": at, "POCL_CACHE_DIR": at, "CUDA_CACHE_PATH": at}
                                  for at in (cache, other))
                own["IRRADIA_SHIPPED_KERNELS"] = ""
                for state in ("installed", "cold", "warm"):
                    s = renderer.run(BOX, ["--method", method, "--spp", "1"], installed if state == "installed" else own)
                    rows.append({"run": run, "method": method, "state": state,
                                 "process_s": s["process"]["seconds"], "cpu_s": s["process"]["cpu"],
                                 "main_s": s["wall_seconds"]["total"], "render_s": s["wall_seconds"]["render"],
                                 "build_s": s["stages"].get("build", {"seconds": 0})["seconds"]})
                    series.setdefault(f"{method}, {state}", []).append(rows[-1]["process_s"])
    print("\nFrom the command to the picture, Cornell box, 1 sample a pixel: seconds of the process\n"
          "| | runs | least | median | CPU time, median | of it before main() | building kernels |\n"
          "|---|---|---|---|---|---|---|")
    for label, values in series.items():
        of = [r for r in rows if f"{r['method']}, {r['state']}" == label]
        before = statistics.median(r["process_s"] - r["main_s"] for r in of)
        print(f"| {label} | {len(values)} | {min(values):.3f} | {statistics.median(values):.3f} | "
              f"{statistics.median(r['cpu_s'] for r in of):.3f} | {before:.3f} | "
              f"{statistics.median(r['build_s'] for r in of):.3f} |")
    report.plot_runs(folder, "start", "Start to picture, Cornell box, 1 sample a pixel", "seconds", series)
    return rows


def scaling(renderer, sizes, folder):
    """`sizes`: numbers of threads; runs alternate, so that each meets the same machine."""
    rows = []
    for method in METHODS:
        options = ["--method", method, "--spp", "64"]
        renderer.run(BOX, options)
        for run in range(max(renderer.args.repeat, 3)):
            for threads in sizes:
                s = renderer.run(BOX, options + ["--threads", str(threads)])
                rows.append({"run": run, "method": method, "threads": threads, "render_s": render_seconds(s),
                             "process_s": s["process"]["seconds"], "cpu_s": s["process"]["cpu"]})
    print("\nThreads, Cornell box, 64 samples a pixel\n| | threads | least seconds | median | speed-up of the medians |\n"
          "|---|---|---|---|---|")
    series = {}
    for method in METHODS:
        values = {t: [r["render_s"] for r in rows if r["method"] == method and r["threads"] == t] for t in sizes}
        for t in sizes:
            series[f"{method}, {t}"] = values[t]
            print(f"| {method} | {t} | {min(values[t]):.3f} | {statistics.median(values[t]):.3f} | "
                  f"{statistics.median(values[sizes[0]]) / statistics.median(values[t]):.2f} |")
    report.plot_runs(folder, "scaling", "Threads, Cornell box, 64 samples a pixel", "seconds", series)
    return rows


def octree(renderer, sizes, folder):
    args = renderer.args
    out = os.path.join(renderer.folder, "octree.json")
    names = "|".join(str(n) for n in sizes)
    line = [args.bench, f"--benchmark_filter=octree/.*/({names})/", "--benchmark_out=" + out,
            "--benchmark_out_format=json"] + (["--device", args.device] if args.device is not None else [])
    try:
        done = subprocess.run(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    except FileNotFoundError:
        raise RuntimeError(f"{args.bench}: no such file; build the target irradia_bench (-DIRRADIA_BENCH=ON)") from None
    if done.returncode:
        raise RuntimeError(done.stderr.strip().splitlines()[-1])
    with open(out) as f:
        benchmarks = json.load(f)["benchmarks"]
    rows, series = [], {}
    for b in benchmarks:
        kind = " ".join(b["name"].split("/")[1:3])
        each = b.get("ns a look-up", b.get("ns an insertion"))
        rows.append({"records": int(b["records"]), "kind": kind, "ns_each": each, "met": b.get("met", ""),
                     "used": b.get("used", ""), "octree_bytes": int(b["octree bytes"]),
                     "entries_a_record": b["entries a record"], "depth": int(b["depth"])})
        xs, ys = series.setdefault(kind.replace("look_up", "look-up,").replace("insert", "insertion,"), ([], []))
        xs.append(int(b["records"]))
        ys.append(each)
    report.plot_growth(folder, "octree", "Octree, equal density: one look-up, one insertion", "records", "ns", series)
    return rows


# name: (function, sizes, what the sizes are)
ALL = {
    "pixels": (pixels, [256, 512, 1024, 2048], "edges of the picture"),
    "records": (records, [1000, 10000, 100000, 1000000], "numbers of records aimed at"),
    "triangles": (triangles, [10**i for i in range(2, 8)], "numbers of triangles"),
    "start": (start, [5], "number of runs"),
    "scaling": (scaling, [1, 2], "numbers of threads"),
    "octree": (octree, [1000, 10000, 100000, 1000000, 3000000], "numbers of records, of those the benchmark has"),
}
