"""The page: one HTML file that needs no other."""
import base64
import datetime
import html as escape_html
import math
import os
import pathlib
import shlex
import string

from . import processes

TEMPLATE = pathlib.Path(__file__).with_name("page.html")


def text(value):
    return escape_html.escape(str(value), quote=True)


def uri(data, kind):
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"


def seconds(t):
    return f"{t:.3g}" if t < 100 else f"{t:.0f}"


def percent(x, digits=3, sign=False):
    if x is None or not math.isfinite(x):
        return ""
    return f"{100 * x:{'+' if sign else ''}.{digits}g} %".replace("-", "−")


def count(n):
    return "" if n is None else f"{n:.0f}" if n < 1e4 else f"{n / 1e3:.1f} k" if n < 1e6 else f"{n / 1e6:.1f} M"


def several(n, what):
    return f"{n} {what}{'' if n == 1 else 's'}"


def cell(shown, value=None, kind=""):
    raw = "" if value is None else f' data-value="{text(f"{value:.8g}" if isinstance(value, float) else value)}"'
    return f"<td{f' class={kind}' if kind else ''}{raw}>{shown}</td>"


def head(names, left=1):
    cells = "".join(f"<th{' class=left' if i < left else ''}>{n}</th>" for i, n in enumerate(names))
    return f"<thead><tr>{cells}</tr></thead>"


def times_table(entries, bars):
    """Fastest measured of each bar stands out."""
    best = [min((e[2][i][0] for e in entries if e[2][i] and not e[2][i][1]), default=None) for i in range(len(bars))]
    rows = []
    for name, kind, times in entries:
        cells = []
        for i, found in enumerate(times):
            shown = "–" if not found else {"<": "&lt; ", "~": "~ ", "": ""}[found[1]] + seconds(found[0])
            cells.append(cell(shown, kind="best" if found and not found[1] and found[0] == best[i] else ""))
        label = text(name) + {"peer": " <span class=faint>(given)</span>"}.get(kind, "")
        rows.append(f"<tr class={kind}><td>{label}</td>{''.join(cells)}</tr>")
    return head(["", *(percent(b) for b in bars)]) + f"<tbody>{''.join(rows)}</tbody>"


def points_table(rows):
    names = ["series", "point", "seconds", "render s", "CPU s", "device s", "rays", "records", "peak MiB", "rel. RMSE",
             "noise", "bias", "mean bias", "relMSE", "FLIP", "SSIM"]
    out = []
    for r in rows:
        v = r.values
        interval = v["mean_bias_interval_95"]
        mean_bias = percent(v["mean_bias"], 2, True)
        if interval is not None and math.isfinite(interval):
            mean_bias += f" ± {percent(interval, 2)}"
        number = lambda key, show: cell("" if v[key] is None else show(v[key]), v[key])
        out.append(f"<tr class={'peer' if r.peer else 'ours'}>" + "".join([
            cell(text(r.point.series), r.point.series), cell(text(r.point.label), r.point.label, "left"),
            cell(seconds(r.seconds), r.seconds), number("render_seconds", seconds), number("cpu_seconds", seconds),
            number("device_seconds", seconds), number("rays", count), number("records", count),
            number("peak_bytes", lambda b: f"{b / 2**20:.0f}"), cell(percent(r.rel_rmse), r.rel_rmse),
            number("noise", percent), number("bias", percent), cell(mean_bias, v["mean_bias"]),
            number("relmse", lambda x: f"{x:.2e}"), number("flip", lambda x: f"{x:.4f}"),
            number("ssim", lambda x: f"{x:.4f}")]) + "</tr>")
    return head(names, 2) + f"<tbody>{''.join(out)}</tbody>"


def gallery(shown, reference_png):
    figures = [f'<figure data-now="picture"><img alt="reference" src="{uri(reference_png, "png")}">'
               "<figcaption>reference</figcaption></figure>"]
    for row, picture, heat in shown:
        picture, heat = uri(picture, "png"), uri(heat, "png")
        name = text(f"{row.point.series}, {row.point.label}")
        figures.append(f'<figure data-now="picture"><img alt="{name}" src="{picture}" data-picture="{picture}" '
                       f'data-map="{heat}"><figcaption>{name}<br><span>{percent(row.rel_rmse)} in '
                       f"{seconds(row.seconds)} s</span></figcaption></figure>")
    return "".join(figures)


def machines_table(rows):
    """A line for each machine, device and program that runs were made on."""
    groups = {}
    for r in rows:
        for run in r.runs:
            m = run["machine"]
            where = (run.get("version", ""), run["ran_on"], m["cpu"], f"{len(m['usable'])} of {m['cores']}",
                     f"{m['memory_bytes'] / 2**30:.0f} GiB" if m["memory_bytes"] else "", m["system"])
            groups.setdefault(where, []).append(run)
    lines = []
    for where, runs in groups.items():
        loads, dates = [r["load_before"] for r in runs], sorted(r["date"] for r in runs)
        cells = [*map(text, where), f"{min(loads):.1f} to {max(loads):.1f}", len(runs),
                 dates[0][:16].replace("T", " ") + " to " + dates[-1][11:16]]
        lines.append("<tr>" + "".join(f"<td class=left>{c}</td>" for c in cells) + "</tr>")
    names = ["program", "ran on", "CPU", "cores usable", "memory", "system", "load before a run", "runs", "when"]
    return head(names, len(names)) + f"<tbody>{''.join(lines)}</tbody>"


def notes_on_points(o, flip_note):
    what = {"total": "the whole program, kernels compiled before", "render": "rendering alone",
            "cpu": "of the CPU, user and system", "device": "of the device's kernels"}[o.time]
    return (f"Seconds: {what}; of peers, rendering and denoising alone. Medians over seeds. Noise is the root of the "
            "variance over seeds, bias the root of what is left of the squared error (−: below 0, so none was seen), "
            "both relative to the mean; mean bias with its 95 % interval. " + text(flip_note))


def html(study, rows, series, peers, times, plots, shown, reference_png, scale, flip_note):
    from .plots import BARS
    o = study.o
    scene = pathlib.Path(o.scene).name
    runs = [run for r in rows for run in r.runs]
    noise = "two halves" if o.ref_b else f"error {percent(o.ref_error)}, taken out" if o.ref_error else \
        "its own error is not known and stays in the figures"
    subtitle = (f"{study.size[0]} × {study.size[1]} pixels; reference {text(pathlib.Path(o.reference).name)} ({noise})"
                f"{', masked' if o.mask else ''}; {len(rows)} points, {several(o.seeds, 'seed')}, {len(runs)} runs; "
                f"{several(o.threads or 'all', 'thread')} on the host")
    failures = "".join(f"<p class=warning>{text(p.series)}, {text(p.label)} failed: {text(why)}</p>"
                       for p, why in study.failed)
    failures += "".join(f"<p class=warning>{text(note)}</p>" for note in study.notes)
    if len(runs) < len(study.plan):
        failures += f"<p class=warning>{len(runs)} of {len(study.plan)} runs are done.</p>"
    figures = "".join(f'<h2>{text(name)}</h2><div class=plot><img alt="{text(name)}" '
                      f'src="{uri(data, "svg+xml")}"></div>' for name, data in plots)
    times_note = ("Between measured points, as if log time were linear in log error. &lt;: the quickest point is "
                  "better already; ~: beyond the last point by 1/√time, of path tracers; –: not reached. Blue: the "
                  "fastest.")
    if peers:
        times_note += f" Given: from {text(pathlib.Path(o.peers).name)}, dashed grey in the plot; not measured here."
    provenance = (f"Checkout {text(processes.commit(study.o.root) or 'unknown')}; sweep {text(study.sweep_name)}; "
                  f"scene {study.scene.hash}, render {study.ours.hash}; Python {text(study.machine['python'])}; "
                  f"written {datetime.datetime.now().astimezone().strftime('%Y-%m-%d %H:%M %Z')}.")
    commands = "\n".join(f"{r.point.series}, {r.point.label}: {shlex.join(base(r.runs[0]['command']))}" for r in rows)
    return string.Template(TEMPLATE.read_text()).substitute(
        title=text(f"Speed against error: {scene}"), subtitle=subtitle, failures=failures, plots=figures,
        times_note=times_note, times=times_table(times, BARS), scale=percent(scale),
        gallery=gallery(shown, reference_png), points_note=notes_on_points(o, flip_note), points=points_table(rows),
        machines=machines_table(rows), provenance=provenance,
        command=text("tools/study " + shlex.join(o.arguments)), commands=text(commands))


def base(command):
    return [os.path.basename(command[0]), *command[1:]]
