"""Prints the results of scripts/bench as one table: a line per benchmark, medians over its runs."""

import json
import pathlib
import statistics
import sys

COUNTERS = ("updates/s", "vs_paper", "update_ms", "spawn_ms", "collect_ms", "frame_ms", "frames/s")


def read(folder, prefix):
    """Runs by benchmark: {name: [result, ...]}."""
    runs = {}
    for file in sorted(folder.glob(f"{prefix}-*.json")):
        for result in json.loads(file.read_text())["benchmarks"]:
            if "error_message" not in result:
                runs.setdefault(result["name"], []).append(result)
    return runs


def milliseconds(result):
    return result["real_time"] * {"ns": 1e-6, "us": 1e-3, "ms": 1, "s": 1e3}[result["time_unit"]]


def spread(values):
    """Half of what lies between the smallest and the largest, of the median [%]."""
    return 50 * (max(values) - min(values)) / statistics.median(values)


def short(value):
    return f"{value / 1e6:.1f} M" if value >= 1e6 else f"{value:.3g}"


def main():
    folder = pathlib.Path(sys.argv[1])
    now, earlier = read(folder, "now"), read(folder, "earlier")
    columns = ["benchmark", "time [ms]", "+-", *COUNTERS]
    if earlier:
        columns += ["earlier [ms]", "faster"]
    rows = [columns]
    for name, results in now.items():
        times = [milliseconds(r) for r in results]
        label = results[0].get("label", "")
        row = [f"{name} {label}".strip(), f"{statistics.median(times):.4g}", f"{spread(times):.0f} %"]
        for counter in COUNTERS:
            values = [r[counter] for r in results if counter in r]
            row.append(short(statistics.median(values)) if values else "")
        if earlier:
            before = [milliseconds(r) for r in earlier.get(name, [])]
            row += (
                [f"{statistics.median(before):.4g}", f"{statistics.median(before) / statistics.median(times):.2f} x"]
                if before
                else ["", ""]
            )
        rows.append(row)
    widths = [max(len(row[i]) for row in rows) for i in range(len(columns))]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())


if __name__ == "__main__":
    main()
