"""Log-log plots, as SVG and PNG."""
import colorsys
import math

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.ticker import FuncFormatter, NullFormatter  # noqa: E402

from .statistics import lower_envelope  # noqa: E402

HUES = {"irradiance": "#0b6fb8", "radiance": "#d9520e", "gather": "#22863a", "path": "#8a3ffc"}
PEER_HUES = ("#8c6d31", "#ad494a", "#637939")
MARKERS = "osD^vP*Xh<>p"
BARS = (0.05, 0.02, 0.01, 0.005)
INK, FAINT = "#24292f", "#8a8f96"
STYLE = {"font.size": 9.5, "axes.edgecolor": FAINT, "axes.labelcolor": INK, "text.color": INK, "xtick.color": INK,
         "ytick.color": INK, "axes.spines.top": False, "axes.spines.right": False, "svg.fonttype": "path",
         "svg.hashsalt": "irradia", "legend.frameon": False}


def shade(colour, share):
    """Near one hue, from dark (0) to light (1); neighbours differ in hue too."""
    r, g, b = (int(colour[i:i + 2], 16) / 255 for i in (1, 3, 5))
    h, l, s = colorsys.rgb_to_hls(r, g, b)
    h += 0.14 * (share - 0.5) * (1 if share * 10 % 2 < 1 else -1)
    return colorsys.hls_to_rgb(h % 1, min(0.68, l * 0.8 + share * 0.32), s)


def looks(series):
    """{series: (colour, marker)}: a method has a hue, its series shades of it."""
    methods, out = {}, {}
    for name, row in series.items():
        methods.setdefault(row[0].point.method, []).append(name)
    peers = [m for m, names in methods.items() if series[names[0]][0].peer]
    for method, names in methods.items():
        hue = PEER_HUES[peers.index(method) % len(PEER_HUES)] if method in peers else HUES.get(method, "#57606a")
        for i, name in enumerate(names):
            out[name] = shade(hue, i / (len(names) - 1)) if len(names) > 1 else hue, MARKERS[i % len(MARKERS)]
    return out


def plain(x, _=None):
    return f"{x:g}" if x < 1e4 else f"{x / 1e6:g} M" if x >= 1e6 else f"{x / 1e3:g} k"


def percent(x, _=None):
    return f"{100 * x:g} %"


def _axes(xlabel, peers):
    figure, axes = plt.subplots(figsize=(9.2 if peers else 8.2, 5.6))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(xlabel)
    axes.set_ylabel("relative RMSE")
    axes.grid(True, which="major", color="#e6e8eb", linewidth=0.8)
    axes.grid(True, which="minor", color="#f3f4f6", linewidth=0.6)
    axes.set_axisbelow(True)
    return figure, axes


def _finish(figure, axes, xs, ys, path):
    low, high = min(ys), max(ys)
    axes.set_xlim(min(xs) / 1.25, max(xs) * 1.25)
    axes.set_ylim(low / 1.25, high * 1.25)
    for axis, limits, text in ((axes.xaxis, axes.get_xlim(), plain), (axes.yaxis, axes.get_ylim(), percent)):
        narrow = limits[1] / limits[0] < 30
        axis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5), numticks=30))
        axis.set_major_formatter(FuncFormatter(text))
        axis.set_minor_locator(matplotlib.ticker.LogLocator(subs=range(1, 10) if narrow else (1,), numticks=30))
        axis.set_minor_formatter(NullFormatter())
    for bar in BARS:
        if axes.get_ylim()[0] < bar < axes.get_ylim()[1]:
            axes.axhline(bar, color="#c9302c", linewidth=0.9, linestyle=(0, (1, 2)), zorder=1)
    handles, names = axes.get_legend_handles_labels()
    if handles:
        axes.legend(handles, names, loc="upper left", bbox_to_anchor=(0, -0.13), ncol=3, fontsize=8.5, handlelength=2.4)
    return _write(figure, path)


def _write(figure, path):
    for kind in ("svg", "png"):
        metadata = {"Date": None} if kind == "svg" else {"Software": None}
        figure.savefig(f"{path}.{kind}", bbox_inches="tight", dpi=150, metadata=metadata)
    plt.close(figure)
    return f"{path}.svg"


def _apart(places, least):
    """Numbers at least so far apart, in the order given (sorted), moved as little as may be."""
    groups = [[p, 1] for p in places]  # centre, members
    merged = True
    while merged:
        merged = False
        for i in range(len(groups) - 1):
            (a, n), (b, m) = groups[i], groups[i + 1]
            if b - a < least * (n + m) / 2 - 1e-9:
                groups[i:i + 2] = [[(a * n + b * m) / (n + m), n + m]]
                merged = True
                break
    return [c + least * (k - (n - 1) / 2) for c, n in groups for k in range(n)]


def _peer_lines(axes, peers):
    """Dashed grey lines, named at the right margin."""
    ends = []
    for name, points in peers.items():
        line = lower_envelope([(t, e) for t, e, _ in points])
        axes.plot([t for t, _, _ in points], [e for _, e, _ in points], linestyle="none", marker=".", markersize=3,
                  color="#b9bec5", zorder=1.5)
        axes.plot(*zip(*line), linestyle=(0, (4, 2)), linewidth=1.1, color=FAINT, zorder=2)
        ends.append((math.log(line[-1][1]), line[-1], name))
    return sorted(ends)


def _name_peers(axes, ends):
    low, high = (math.log(y) for y in axes.get_ylim())
    places = _apart([y for y, _, _ in ends], (high - low) / 30)
    if not places:
        return
    shift = min(0.0, high - places[-1]) if places[-1] > high else max(0.0, low - places[0])
    right = axes.get_xlim()[1]
    for place, (_, (x, y), name) in zip(places, ends):
        at = math.exp(place + shift)
        axes.plot([x, right], [y, at], color="#c8ccd1", linewidth=0.6, zorder=1, clip_on=False)
        axes.annotate(" " + name, (right, at), fontsize=8, color="#6a7079", va="center", annotation_clip=False)


def against_time(series, peers, xlabel, path):
    with plt.rc_context(STYLE):
        figure, axes = _axes(xlabel, peers)
        look, xs, ys = looks(series), [], []
        ends = _peer_lines(axes, peers)
        for points in peers.values():
            xs += [t for t, _, _ in points]
            ys += [e for _, e, _ in points]
        for name, rows in series.items():
            colour, marker = look[name]
            x, y = [r.seconds for r in rows], [max(r.rel_rmse, 1e-9) for r in rows]
            axes.plot(x, y, color=colour, marker=marker, markersize=5, linewidth=1.8, label=name, zorder=4,
                      linestyle="--" if rows[0].peer else "-", markeredgecolor="white", markeredgewidth=0.6)
            xs, ys = xs + x, ys + y
        axes.set_xlim(min(xs) / 1.25, max(xs) * 1.25)
        axes.set_ylim(min(ys) / 1.25, max(ys) * 1.25)
        _name_peers(axes, ends)
        return _finish(figure, axes, xs, ys, path)


def against(series, value, xlabel, path, peers=False):
    """`value` of a row: what lies on the axis; rows of which it is None are left out. None if nothing is left."""
    kept = {name: [r for r in rows if value(r)] for name, rows in series.items()}
    kept = {name: rows for name, rows in kept.items() if len({value(r) for r in rows}) > 1 and not rows[0].peer}
    if not kept:
        return None
    with plt.rc_context(STYLE):
        figure, axes = _axes(xlabel, peers)
        look, xs, ys = looks(series), [], []
        for name, rows in kept.items():
            colour, marker = look[name]
            x, y = [value(r) for r in rows], [max(r.rel_rmse, 1e-9) for r in rows]
            axes.plot(x, y, color=colour, marker=marker, markersize=5, linewidth=1.8, label=name, zorder=4,
                      markeredgecolor="white", markeredgewidth=0.6)
            xs, ys = xs + x, ys + y
        return _finish(figure, axes, xs, ys, path)
