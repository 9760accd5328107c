"""Measures livemvs with one option at a time changed: what scripts/ablation calls."""

import argparse
import csv
import hashlib
import json
import os
import platform
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BEGIN = "<!-- begin: written by scripts/ablation -->"
END = "<!-- end: written by scripts/ablation -->"

# Name, and what differs from the default preset. Rows that narrow the window say search=window,
# which all of these data use anyway, because otherwise the program would turn to whole lines.
ROWS = {
    "default": "",
    "paper": "--preset paper",
    "density-range": "outlier_density=range",
    "window-fixed": "search=window search_sigmas=0 search_radius_px=3 search_radius_max_px=3",
    "window-8": "search=window search_radius_max_px=8",
    "no-ambiguity": "ambiguity_ncc=0",
    "no-gradient": "image_noise=0",
    "ncc-any": "min_ncc=-1",
    "ncc-0.6": "min_ncc=0.6",
    "no-warp": "warp_roll_deg=0 warp_scale=0",
    "levels-1": "levels=1",
    "levels-2": "levels=2",
    "levels-4": "levels=4",
    "levels-1-weak": "levels=1 min_patch_stddev=5",
    "stddev-5": "min_patch_stddev=5",
    "no-centre": "max_texture_offset_px=0",
    "centre-1": "max_texture_offset_px=1",
    "depth": "coordinate=depth",
    "tau-1": "measurement_sigma_px=1",
    "no-bias": "match_bias_px=0",
    "no-epipolar": "epipolar_error_px=0",
    "inlier-0.6": "eta_inlier=0.6",
    "no-sides": "min_side_ncc=-1",
    "sides-0.3": "min_side_ncc=0.3",
    "no-overhang": "overhang_px=0",
    "overhang-32": "overhang_px=32",
    "no-rims": "rim_px=0",
    "rims-4": "rim_px=4",
    "rims-8": "rim_px=8",
    "prune-paper": "eta_outlier=0.05 outlier_certainty=0.99",
    "no-age": "max_age=0",
    "no-unseen": "max_unseen=0",
    "prior-10": "prior_a=10 prior_b=10",
    "every-frame": "min_move=0",
    "move-0.05": "min_move=0.05",
    "move-0.1": "min_move=0.1",
    "plant-1": "plant_every=1",
    "plant-3": "plant_every=3",
    "no-cover": "cover_radius_px=-1",
    "cover-1": "cover_radius_px=1",
    "epsilon-1": "epsilon_px=1",
    "no-regularise": "regularise_px=0",
    "no-support": "min_support=0",
    "exposure": "",  # the default on a scene whose light comes and goes
}

# Boxes of the recordings in which they are reconstructed and judged.
BOXES = {
    "board-orbit": "-0.21 -0.14 -0.005 0.21 0.14 0.2",
    "cube": "-0.055 -0.055 -0.036 0.055 0.055 0.06",
}
MESHES = {"board-orbit": "mesh.ply.gz", "cube": "mesh.ply", "hazards": "mesh.ply"}
DATA = ("board-orbit", "cube", "hazards", "redkitchen")

# Per column: data set, name in the CSV, heading, decimals.
SURFACE = [
    ("points", "points", 0),
    ("within_1mm", "1 mm %", 1),
    ("within_5mm", "5 mm %", 1),
    ("complete_2mm", "compl. %", 1),
]
COLUMNS = [
    *[(data, *column) for data in ("board-orbit", "cube") for column in SURFACE],
    ("board-orbit", "updates_m", "updates M", 1),
    ("board-orbit", "cpu_s", "CPU s", 1),
    ("redkitchen", "points", "points", 0),
    ("redkitchen", "median_error_mm", "median mm", 1),
    ("redkitchen", "floats", "floats %", 1),
    ("hazards", "points", "points", 0),
    ("hazards", "within_1mm", "1 mm %", 1),
    ("hazards", "within_5mm", "5 mm %", 1),
    ("hazards", "false_points", "false points %", 1),
    ("hazards", "false_all", "false %", 1),
    ("hazards", "false_off_edges", "off edges %", 1),
    ("hazards", "phantoms", "phantoms %", 1),
]
TABLES = [("board-orbit", "cube"), ("redkitchen", "hazards")]


class Bench:
    """The program, its data and where results go."""

    def __init__(self, program, recordings, quick):
        self.program = str(program)
        self.recordings = Path(recordings)
        self.quick = quick
        self.work = ROOT / "build" / ("ablation-quick" if quick else "ablation")
        self.work.mkdir(parents=True, exist_ok=True)
        self.digest = hashlib.sha256(Path(program).read_bytes()).hexdigest()

    def call(self, *arguments):
        command = [self.program, *map(str, arguments)]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            sys.exit(f"ablation: error: {' '.join(command)}\n{done.stdout}")

    def scene(self, exposure):
        """The synthetic scene, rendered once."""
        folder = self.work / ("hazards-exposure" if exposure else "hazards")
        if self.quick:
            size = ["--frames", 12, "--size", "320x240", "--labels-every", 2]
        else:
            size = ["--frames", 120, "--size", "960x720", "--labels-every", 5]
        if exposure:
            size += ["--exposure-variation", 0.5]
        if not (folder / "README.txt").exists():
            print(f"rendering {folder.name}", flush=True)
            self.call("synth", "--scene", "hazards", "--noise", 2, *size, "-o", folder,
                      "--progress", "none")
        return folder

    def folder(self, data, row):
        """Where the data is; None where it is not or the row does not use it."""
        if data == "hazards":
            return self.scene(exposure=row == "exposure")
        folder = self.recordings / data
        return folder if row != "exposure" and not self.quick and folder.is_dir() else None

    def measure(self, data, row):
        """The numbers of a row on a data set: measured, or remembered from this program."""
        folder = self.folder(data, row)
        if folder is None:
            return {}
        arguments = run_arguments(data, row)
        memory = self.work / f"{data}.{row}.json"
        key = self.digest + " " + " ".join(arguments)
        if memory.exists():
            known = json.loads(memory.read_text())
            if known["key"] == key:
                return known["numbers"]
        cloud, stats = self.work / "cloud.ply", self.work / "stats.json"
        trace, result = self.work / "seeds.trace", self.work / "result.json"
        if data == "hazards":
            arguments = [*arguments, "--trace", trace]
        self.call("run", "--data", folder, *arguments, "--progress", "none", "--stats", stats,
                  "-o", cloud)
        if data == "redkitchen":
            self.call("depth-check", cloud, folder, "--json", result)
        elif data == "hazards":
            self.call("eval", cloud, folder / MESHES[data], "--samples", 1000, "--trace", trace,
                      "--labels", folder, "--json", result)
        else:
            self.call("eval", cloud, folder / MESHES[data], "--data", folder, "--box",
                      *BOXES[data].split(), "--json", result)
        numbers = read_numbers(data, json.loads(stats.read_text()), json.loads(result.read_text()))
        memory.write_text(json.dumps({"key": key, "numbers": numbers}))
        return numbers


def run_arguments(data, row):
    """What the row adds to `livemvs run`."""
    options = ROWS[row].split()
    if not options or options[0] == "--preset":
        arguments = options
    else:
        arguments = ["--set", *options]
    return arguments + (["--box", *BOXES[data].split()] if data in BOXES else [])


def read_numbers(data, stats, result):
    numbers = {"points": stats["points"]}
    if data == "redkitchen":
        if result["median_z_error"] is not None:
            numbers["median_error_mm"] = 1000 * result["median_z_error"]
        numbers["floats"] = 100 * result["floating_share"]
        return numbers
    within = {w["tau"]: w for w in result["within"]}
    numbers["within_1mm"] = 100 * within[1]["accuracy"]
    numbers["within_5mm"] = 100 * within[5]["accuracy"]
    if data == "hazards":
        labels = result["false_convergence"]["labels"]
        every = labels["textureless_or_occluded"]
        numbers["false_points"] = 100 * every["false_points_of_planted"]
        numbers["false_all"] = 100 * every["false_of_planted"]
        off_edges = labels["textureless_or_occluded_off_edges"]
        numbers["false_off_edges"] = 100 * off_edges["false_of_planted"]
        numbers["phantoms"] = 100 * every["phantoms_of_planted"]
        return numbers
    numbers["complete_2mm"] = 100 * within[2]["completeness"]
    numbers["updates_m"] = stats["updates"]["total"] / 1e6
    numbers["cpu_s"] = stats["cpu_seconds"]
    return numbers


def cell(numbers, column):
    data, name, _, decimals = column
    value = numbers.get(data, {}).get(name)
    return "" if value is None else f"{value:.{decimals}f}"


def markdown(rows, datasets):
    """A table of the columns of these data sets; empty where none was measured."""
    columns = [c for c in COLUMNS if c[0] in datasets]
    lines = ["| row | " + " | ".join(f"{c[0]} {c[2]}" for c in columns) + " |",
             "|---|" + "---:|" * len(columns)]
    for row, numbers in rows.items():
        cells = [cell(numbers, c) for c in columns]
        if any(cells):
            lines.append(f"| {row} | " + " | ".join(c or "–" for c in cells) + " |")
    return "\n".join(lines) if len(lines) > 2 else ""


def options_table():
    lines = ["| row | differs from the default by |", "|---|---|"]
    for row, options in ROWS.items():
        text = f"`{options}`" if options else "nothing"
        if row == "exposure":
            text = "nothing; the light of `hazards` varies by ± 50 % (`--exposure-variation 0.5`)"
        lines.append(f"| {row} | {text} |")
    return "\n".join(lines)


def git(*arguments):
    done = subprocess.run(["git", "-C", str(ROOT), *arguments], stdout=subprocess.PIPE, text=True)
    return done.stdout.strip() if done.returncode == 0 else ""


def origin():
    """Program and machine in a sentence."""
    sources = ["--", "src", "app", "cmake", "CMakeLists.txt"]
    commit = git("log", "-1", "--format=%h", *sources) or "unknown"
    if git("status", "--porcelain", *sources):
        commit += " with changes"
    model = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    system = platform.freedesktop_os_release()["PRETTY_NAME"]
    gcc = subprocess.run(["c++", "-dumpfullversion"], stdout=subprocess.PIPE, text=True).stdout
    return (f"Program of commit {commit}; {os.cpu_count()} processors "
            f"{model.group(1) if model else platform.machine()}, {system}, GCC {gcc.strip()}.")


def write_docs(rows):
    with open(ROOT / "docs" / "ablation.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["row", "options", *[f"{c[0]}.{c[1]}" for c in COLUMNS]])
        for row, numbers in rows.items():
            writer.writerow([row, ROWS[row], *[cell(numbers, c) for c in COLUMNS]])
    absent = [d for d in DATA if not any(d in n for n in rows.values())]
    parts = [origin()]
    if absent:
        parts[0] += f" Not measured, because the data was not there: {', '.join(absent)}."
    parts += [text for datasets in TABLES if (text := markdown(rows, datasets))]
    parts.append(options_table())
    page = ROOT / "docs" / "ablation.md"
    before, rest = page.read_text().split(BEGIN)
    after = rest.split(END)[1]
    page.write_text(before + "\n\n".join([BEGIN, *parts, END]) + after)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", nargs="?")
    parser.add_argument("--data", default="")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", nargs="+", choices=list(ROWS), default=list(ROWS))
    parser.add_argument("--list", action="store_true")
    args = parser.parse_args()
    if args.list:
        print("\n".join(f"{row:15s} {options}" for row, options in ROWS.items()))
        return
    bench = Bench(args.program, args.data, args.quick)
    rows = {row: {} for row in ROWS if row in args.only}
    for data in DATA:
        for row in rows:
            started = time.monotonic()
            numbers = bench.measure(data, row)
            if numbers:
                rows[row][data] = numbers
                text = ", ".join(f"{name} {value:.6g}" for name, value in numbers.items())
                print(f"{data:12s} {row:14s} {time.monotonic() - started:4.0f} s  {text}", flush=True)
    if args.quick or len(rows) < len(ROWS):
        for text in (markdown(rows, datasets) for datasets in TABLES):
            if text:
                print("\n" + text)
    else:
        write_docs(rows)
        print("wrote docs/ablation.csv and the tables of docs/ablation.md")


if __name__ == "__main__":
    main()
