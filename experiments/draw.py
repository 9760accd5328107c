#!/usr/bin/env python3
"""Draws the tables of paper_experiments.

Usage: draw.py FOLDER PICTURES

Reads FOLDER/tables and FOLDER/maps, writes PICTURES/*.png. A table that is not there is passed over.
"""
import csv
import io
import math
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image  # comes with matplotlib

BLUE, ORANGE, GREEN, RED, GREY = "#1f5fa8", "#d97706", "#2f855a", "#b91c1c", "#777777"
MIN_NCC = 0.6  # kMinNcc of pixel_sensor.h: maxima below it are no measurements
plt.rcParams.update({
    "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 9.5,
    "axes.grid": False, "figure.dpi": 100, "legend.frameon": False, "legend.fontsize": 8.5,
})


class Tables:
    """The tables of a folder, as columns by name: arrays of float, or lists of text."""

    def __init__(self, folder):
        self.folder = Path(folder)

    def has(self, name):
        return (self.folder / f"{name}.csv").exists()

    def read(self, name):
        with open(self.folder / f"{name}.csv", encoding="utf-8") as file:
            header, *rows = list(csv.reader(file))
        columns = {}
        for i, title in enumerate(header):
            values = [row[i] for row in rows]
            try:
                columns[title] = np.array([float(v) if v else math.nan for v in values])
            except ValueError:
                columns[title] = values
        return columns


def rows_where(table, column, value):
    """The rows of a table whose column has this value."""
    keep = [i for i, v in enumerate(table[column]) if v == value]
    return {k: np.array([v[i] for i in keep]) for k, v in table.items()}


def predictive(z, measurements, mu, sigma, inlier_ratio, z_min, z_max):
    """The posterior's density of the next measurement: Eq. (1) averaged over q, and over tau."""
    variance = sigma**2 + measurements["tau [mm]"] ** 2
    good = np.exp(-((z[:, None] - mu) ** 2) / (2 * variance)) / np.sqrt(2 * np.pi * variance)
    return inlier_ratio * good.mean(axis=1) + (1 - inlier_ratio) / (z_max - z_min)


def save(figure, path):
    buffer = io.BytesIO()
    figure.savefig(buffer, metadata={"Software": None})
    plt.close(figure)
    # A palette keeps the files small, and the repository with them.
    Image.open(buffer).convert("RGB").quantize(160, dither=0).save(path, optimize=True)
    print(f"drawn: {path}")


def depth_histogram(axes, depths, z_min, z_max, bins=100, density=True):
    axes.hist(depths, bins=bins, range=(z_min, z_max), density=density, color="#9db8d9")
    axes.set_xlim(z_min, z_max)
    axes.set_xlabel("depth along the ray [mm]")


def draw_curves(tables, name, path):
    pixel = tables.read(f"{name}_pixel")
    curves, maxima = tables.read(f"{name}_curves"), tables.read(f"{name}_maxima")
    z_min, z_max = pixel["Zmin [mm]"][0], pixel["Zmax [mm]"][0]
    truth = pixel["true depth [mm]"][0]
    count = int(pixel["neighbours"][0])
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.3), layout="constrained")
    shown = sorted(set(curves["neighbour"]))
    for i, neighbour in enumerate(shown):
        colour = plt.cm.viridis(0.9 * i / max(1, len(shown) - 1))
        curve = rows_where(curves, "neighbour", neighbour)
        tops = rows_where(maxima, "neighbour", neighbour)
        left.plot(curve["depth [mm]"], curve["NCC"], color=colour, lw=0.9)
        left.plot(tops["depth [mm]"], tops["NCC"], "k.", ms=4)
    left.set(xlabel="depth along the ray [mm]", ylabel="NCC", ylim=(-1, 1.05), xlim=(z_min, z_max),
             title=f"(a) NCC in {len(shown)} of {count} neighbours, the nearest darkest")
    left.axhline(MIN_NCC, color=GREY, lw=0.8, ls=":")
    bins = {"bins": 100, "range": (z_min, z_max)}
    right.hist(maxima["depth [mm]"], color="#d8e2ef", label="all", **bins)
    right.hist(maxima["depth [mm]"][maxima["NCC"] >= MIN_NCC], color="#4f7fb8",
               label=f"NCC ≥ {MIN_NCC}", **bins)
    right.set(xlabel="depth along the ray [mm]", xlim=(z_min, z_max), ylabel="local maxima per bin",
              title=f"(b) local maxima of {count} neighbours")
    right.margins(y=0.25)
    if not math.isnan(truth):
        for axes in (left, right):
            axes.axvline(truth, color=RED, lw=1, ls="--")
        right.plot([], [], color=RED, lw=1, ls="--", label="true depth")
    right.legend(loc="upper left", ncol=3)
    save(figure, path)


def draw_posteriors(tables, maps, path):
    cases = [c for c in ("success", "failure") if tables.has(f"fig3_{c}")]
    if not cases:
        return
    figure, grid = plt.subplots(3 * len(cases), 4, figsize=(9.6, 4.6 * len(cases)), sharex="row",
                                layout="constrained", squeeze=False)
    for block, case in enumerate(cases):
        states, measurements = tables.read(f"fig3_{case}"), tables.read(f"fig3_{case}_measurements")
        rows = grid[3 * block:3 * block + 3]
        for column, updates in enumerate(states["updates"].astype(int)):
            z_min, z_max = states["Zmin [mm]"][column], states["Zmax [mm]"][column]
            for row, kind in enumerate(("dense", "parametric")):
                axes = rows[row][column]
                density = maps.read(f"{kind}_{case}_{updates}")["density"]
                image = density.reshape(500, 100).T
                axes.imshow(image / image.max(), origin="lower", aspect="auto", cmap="magma",
                            extent=(z_min, z_max, 0, 1), interpolation="antialiased")
                axes.axvline(states["true depth [mm]"][column], color="#7dd3fc", lw=0.7, ls=":")
                axes.set_xticklabels([])
                if column == 0:
                    axes.set_ylabel(f"{kind}\ninlier ratio π")
            rows[0][column].set_title(f"{case}: {updates} updates")
            seen = measurements["depth [mm]"][measurements["update"] <= updates]
            depth_histogram(rows[2][column], seen, z_min, z_max, bins=50, density=False)
            if column == 0:
                rows[2][column].set_ylabel("measurements")
    save(figure, path)


def draw_evolution(tables, path):
    evolution, measurements = tables.read("fig4_evolution"), tables.read("fig4_measurements")
    z_min, z_max = evolution["Zmin [mm]"][0], evolution["Zmax [mm]"][0]
    figure, (a, b, c) = plt.subplots(1, 3, figsize=(9.6, 3.1), layout="constrained")
    n = evolution["update"]
    for axes, mean, sigma in ((a, "mu [mm]", "sigma [mm]"),
                              (b, "inlier ratio", "sigma of inlier ratio")):
        axes.fill_between(n, evolution[mean] - 2 * evolution[sigma],
                          evolution[mean] + 2 * evolution[sigma], color="#c7d7ec", lw=0,
                          label="mean ± 2σ")
        axes.plot(n, evolution[mean], color=BLUE, lw=1.2)
        axes.set(xlabel="updates", xlim=(0, n[-1]))
    a.axhline(evolution["true depth [mm]"][0], color=RED, lw=1, ls="--", label="true depth")
    a.set(ylabel="depth Z [mm]", ylim=(z_min, z_max), title="(a) depth")
    a.legend()
    b.set(ylabel="inlier ratio π", ylim=(0, 1), title="(b) inlier ratio")
    depth_histogram(c, measurements["depth [mm]"], z_min, z_max)
    z = np.linspace(z_min, z_max, 1500)
    last = {k: v[-1] for k, v in evolution.items()}
    c.plot(z, predictive(z, measurements, last["mu [mm]"], last["sigma [mm]"],
                         last["inlier ratio"], z_min, z_max), color=RED, lw=1.2,
           label="p(x | x₁ … xₙ)")
    c.set(ylabel="density [1/mm]", title=f"(c) {int(n[-1])} measurements")
    c.legend()
    save(figure, path)


def draw_kinds(tables, path):
    states, all_measurements = tables.read("fig5_states"), tables.read("fig5_measurements")
    figure, panels = plt.subplots(1, 3, figsize=(9.6, 3.1), layout="constrained")
    for i, kind in enumerate(states["kind"]):
        axes = panels[i]
        state = {k: v[i] for k, v in states.items()}
        measurements = rows_where(all_measurements, "kind", kind)
        z_min, z_max = state["Zmin [mm]"], state["Zmax [mm]"]
        depth_histogram(axes, measurements["depth [mm]"], z_min, z_max, bins=80)
        z = np.linspace(z_min, z_max, 1500)
        axes.plot(z, predictive(z, measurements, state["shown: mu [mm]"], state["sigma [mm]"],
                                state["inlier ratio"], z_min, z_max), color=RED, lw=1.2)
        axes.axvline(state["true depth [mm]"], color=GREEN, lw=1, ls="--", label="true depth")
        axes.set(title=f"({'abc'[i]}) {kind}: inlier ratio {state['inlier ratio']:.2f}")
    panels[0].set_ylabel("density [1/mm]")
    panels[0].legend(loc="upper left")
    save(figure, path)


def draw_table1(tables, path):
    figure, panels = plt.subplots(1, 2, figsize=(9.6, 4.2), layout="constrained", sharey=True)
    colours = {"dense 500x100": "#f0a860", "exact maximum": RED, "tau 0.5 px": "#d9579b",
               "tau 0.25 px": "#7c3aed", "parametric": GREEN, "random order": "#8fbf9f"}
    titles = {"table1": "(a) the largest maximum of each view",
              "table1_high": f"(b) all maxima with NCC ≥ {MIN_NCC}"}
    for axes, (name, title) in zip(panels, titles.items()):
        table = tables.read(name)
        levels = [k.split()[0] for k in table if k != "method"]
        columns = [k for k in table if k != "method"]
        histograms = [m for m in table["method"] if m.startswith("histogram")]
        for i, method in enumerate(table["method"]):
            values = [table[c][i] for c in columns]
            if method in histograms:
                shade = 0.3 + 0.7 * histograms.index(method) / len(histograms)
                axes.plot(levels, values, ".:", color=plt.cm.Blues(shade), label=f"{method} bins")
            else:
                colour = next(v for k, v in colours.items() if method.endswith(k))
                axes.plot(levels, values, "o-", color=colour, lw=1.3, ms=3.5,
                          label=method.replace("Gauss+Uniform", "G+U").replace(" tau", ", τ ="))
        axes.set(yscale="log", xlabel="share of the pixels [%]", title=title)
        ticks = [0.3, 0.5, 1, 2, 5, 10, 20, 50]
        axes.set_yticks(ticks, [str(t) for t in ticks])
        axes.minorticks_off()
        axes.grid(axis="y", color="#eeeeee")
    panels[0].set_ylabel("their largest error [mm]")
    panels[0].legend(fontsize=7, loc="upper left")
    save(figure, path)


def draw_house(tables, path):
    curves = tables.read("fig7_curves")
    figure, panels = plt.subplots(1, 2, figsize=(9.6, 3.5), layout="constrained", sharey=True)
    runs = list(dict.fromkeys(curves["run"]))
    for i, run in enumerate(runs):
        curve = rows_where(curves, "run", run)
        colour = ORANGE if run.startswith("paper") else BLUE
        style = "-" if i % 2 == 0 else "--"
        for axes, column in zip(panels, ("accuracy", "completeness")):
            axes.plot(curve["distance [mm]"], 100 * curve[column], style, color=colour, label=run)
    for axes, title, label in (
            (panels[0], "(a) accuracy", "points within d of the surface [%]"),
            (panels[1], "(b) completeness", "surface within d of a point [%]")):
        axes.set(xlabel="distance d [mm]", ylabel=label, title=title, ylim=(0, 100), xlim=(0, 10))
        axes.grid(color="#eeeeee")
    panels[1].legend(loc="lower right")
    save(figure, path)


def draw_em(tables, path):
    table = tables.read("em")
    names = table["way"]
    place = np.arange(len(names))[::-1]
    figure, axes = plt.subplots(figsize=(7.2, 2.8), layout="constrained")
    axes.barh(place + 0.2, 100 * table["not at the global maximum"], 0.36, color=BLUE,
              label="not at the global maximum")
    axes.barh(place - 0.2, 100 * table["wrong depth"], 0.36, color="#e5b98a",
              label="not at the true depth")
    for y, a, b in zip(place, table["not at the global maximum"], table["wrong depth"]):
        axes.text(100 * a + 0.8, y + 0.2, f"{100 * a:.1f}", va="center", fontsize=8)
        axes.text(100 * b + 0.8, y - 0.2, f"{100 * b:.1f}", va="center", fontsize=8)
    axes.set(yticks=place, xlabel="share of the pixels [%]", xlim=(0, 100))
    axes.set_yticklabels(names)
    axes.legend(loc="lower center", bbox_to_anchor=(0.4, 1), ncol=2)
    save(figure, path)


def draw_float(tables, path):
    table = tables.read("float_updates")
    sigma = table["sigma [share of range]"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.3), layout="constrained")
    for form, colour in (("textbook", RED), ("closed form", BLUE)):
        left.plot(sigma, 100 * table[f"{form} not positive"], color=colour, label=f"{form}, float")
    for column, label, colour in (
            ("textbook error [share of variance]", "textbook, float", RED),
            ("closed form error", "closed form, float", BLUE)):
        right.plot(sigma, np.maximum(table[column], 1e-9), color=colour, label=label)
    for axes in (left, right):
        axes.set_xscale("log")
        axes.invert_xaxis()
        axes.set_xlabel("σ before the update [share of the range]")
        axes.axvline(1 / 500, color=GREY, lw=0.8, ls=":")
        axes.axvline(1e-4, color=GREY, lw=0.8, ls="--")
    left.text(1 / 530, 96, "range/500", fontsize=8, color=GREY, va="top")
    left.text(0.94e-4, 96, "range/10⁴", fontsize=8, color=GREY, va="top")
    left.set(ylabel="updates with σ² ≤ 0 [%]", ylim=(-2, 100), title="(a) variances that are none")
    left.legend(loc="center left")
    right.set(yscale="log", ylabel="median relative error of σ²", title="(b) error of the variance")
    save(figure, path)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    folder, pictures = Path(sys.argv[1]), Path(sys.argv[2])
    tables, maps = Tables(folder / "tables"), Tables(folder / "maps")
    pictures.mkdir(parents=True, exist_ok=True)
    drawings = [
        ("fig2_pixel", lambda p: draw_curves(tables, "fig2", p), "fig2.png"),
        ("fig2_temple_pixel", lambda p: draw_curves(tables, "fig2_temple", p), "fig2_temple.png"),
        ("fig3_statistics", lambda p: draw_posteriors(tables, maps, p), "fig3.png"),
        ("fig4_evolution", lambda p: draw_evolution(tables, p), "fig4.png"),
        ("fig5_states", lambda p: draw_kinds(tables, p), "fig5.png"),
        ("table1", lambda p: draw_table1(tables, p), "table1.png"),
        ("fig7_curves", lambda p: draw_house(tables, p), "fig7.png"),
        ("em", lambda p: draw_em(tables, p), "em.png"),
        ("float_updates", lambda p: draw_float(tables, p), "float.png"),
    ]
    for table, draw, name in drawings:
        if tables.has(table):
            draw(pictures / name)


if __name__ == "__main__":
    main()
