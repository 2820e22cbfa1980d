"""CSV files, log-log plots with their exponents, and what is printed."""
import csv
import os

from . import fit


def write_csv(path, rows):
    """`rows`: dicts with the keys of the first."""
    aside = path + ".part"
    with open(aside, "w", newline="") as f:
        writer = csv.DictWriter(f, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    os.replace(aside, path)


def save(figure, folder, name):
    for kind in ("svg", "png"):
        path = os.path.join(folder, name + "." + kind)
        aside = path + ".part"
        figure.savefig(aside, format=kind, dpi=120, bbox_inches="tight")
        os.replace(aside, path)


def new_plot():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot

    return pyplot.subplots(figsize=(6, 4))


def plot_growth(folder, name, title, x_label, y_label, series):
    """Log-log plot of {label: (xs, ys)}, each with its fitted line; prints a table of the exponents."""
    figure, axes = new_plot()
    print(f"\n{title}\n| | points | exponent | exponent of the last two |\n|---|---|---|---|")
    for label, (xs, ys) in series.items():
        kept = [(x, y) for x, y in zip(xs, ys) if x > 0 and y > 0]
        xs, ys = [x for x, _ in kept], [y for _, y in kept]
        if len(set(xs)) < 2:
            axes.plot(xs, ys, "o", label=label)
            print(f"| {label} | {len(xs)} | - | - |")
            continue
        e, error, c = fit.exponent(xs, ys)
        line, = axes.plot(xs, [c * x ** e for x in xs], "-", linewidth=1)
        axes.plot(xs, ys, "o", color=line.get_color(), label=f"{label}: {e:.2f}")
        margin = "" if error != error else f" ± {error:.2f}"
        print(f"| {label} | {len(xs)} | {e:.2f}{margin} | {fit.last_exponent(xs, ys):.2f} |")
    axes.set(xscale="log", yscale="log", xlabel=x_label, ylabel=y_label, title=title)
    axes.grid(True, which="major", alpha=0.4)
    axes.legend(title="exponents", loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)  # covers no point
    save(figure, folder, name)


def plot_runs(folder, name, title, y_label, series):
    """Single values of {label: values}, one column each."""
    figure, axes = new_plot()
    for i, values in enumerate(series.values()):
        axes.plot([i] * len(values), values, "o", alpha=0.6)
    axes.set_xticks(range(len(series)), list(series), rotation=20, ha="right")
    axes.set(ylabel=y_label, title=title, ylim=(0, None))
    axes.grid(True, axis="y", alpha=0.4)
    save(figure, folder, name)
