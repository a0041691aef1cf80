"""Makes the plots of docs/benchmarks.md, each beside the numbers in it.

  figures.py MEASURED FIGURES     from the CSV files of scripts/bench in the first folder, those that are there, into the second
"""

import csv
import statistics
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

HERE = Path(__file__).resolve().parent
QUARTILES = (25, 50, 75)

# What is shown beside each other in ratios.svg, by part: figures that begin so, and how they are called there.
RATIOS = [
    ("one-shot", "one shot, "),
    ("tls", "one shot over TLS"),
    ("distance", ""),
    ("fan-out", "one robot, "),
    ("fan-out", "10000 robots"),
    ("batch", ""),
    ("validation", ""),
]


def measured(file):
    """{figure: {program: [milliseconds, …]}}, in the file's order."""
    figures = defaultdict(dict)
    with open(file, newline="") as rows:
        for row in csv.DictReader(rows):
            figures[row["figure"]].setdefault(row["program"], []).append(float(row["milliseconds"]))
    return figures


def percentiles(values, wanted):
    if len(values) == 1:
        return [values[0] for _ in wanted]
    cuts = [min(values), *statistics.quantiles(values, n=100, method="inclusive"), max(values)]
    return [cuts[percent] for percent in wanted]


def write(file, rows):
    with open(file, "w", newline="") as table:
        csv.writer(table, lineterminator="\n").writerows(rows)


def draw(figures, name, **settings):
    definitions = [f"{key}='{value}'" for key, value in settings.items()]
    subprocess.run(["gnuplot", "-e", ";".join([f"table='{figures / name}.csv'", *definitions]), HERE / "plots" / f"{name}.gp"],
                   check=True, stdout=open(figures / f"{name}.svg", "w"))
    print(figures / f"{name}.svg")


def one_shot(source, figures):
    programs = measured(source / "one-shot.csv")["one shot, distribution"]
    columns = [percentiles(times, range(101)) for times in programs.values()]
    rows = [[percent, *(f"{column[percent]:.2f}" for column in columns)] for percent in range(101)]
    write(figures / "one-shot.csv", [["percent", *programs], *rows])
    draw(figures, "one-shot")


def fan_out(source, figures):
    cells = defaultdict(dict)  # count → column → microseconds per robot
    columns = []
    for figure, programs in measured(source / "fan-out.csv").items():
        count, _, what = figure.partition(" robots, ")
        if not count.isdigit() or "checked" in what:
            continue
        for program, times in programs.items():
            column = f"{program}: {what}"
            if column not in columns:
                columns.append(column)
            cells[int(count)][column] = f"{statistics.median(times) * 1000 / int(count):.2f}"
    write(figures / "fan-out.csv", [["robots", *columns], *([count, *(row.get(c, "") for c in columns)] for count, row in sorted(cells.items()))])
    draw(figures, "fan-out")


def ratios(source, figures):
    rows = []
    for part, beginning in RATIOS:
        file = source / f"{part}.csv"
        if not file.exists():
            continue
        for figure, programs in measured(file).items():
            if not figure.startswith(beginning) or len(programs) != 2:
                continue
            (_, ours), (peer, theirs) = programs.items()
            low, middle, high = percentiles([a / b for a, b in zip(ours, theirs)], QUARTILES)
            rows.append([f"{figure} / {peer}", f"{middle:.3f}", f"{low:.3f}", f"{high:.3f}",
                         f"{statistics.median(ours):.2f}", f"{statistics.median(theirs):.2f}", len(ours)])
    if rows:
        write(figures / "ratios.csv", [["what / beside what", "ratio", "lower quartile", "upper quartile", "fleetpub ms", "peer ms", "pairs"], *rows])
        draw(figures, "ratios", rows=len(rows))


def stages(source, figures):
    with open(source / "stages.csv", newline="") as rows:
        costs = list(csv.DictReader(rows))
    names = list(dict.fromkeys(row["stage"] for row in costs))
    table = []
    bars = []  # from top to bottom
    for run in dict.fromkeys(row["run"] for row in costs):
        part = {row["stage"]: row for row in costs if row["run"] == run}
        robots = int(next(iter(part.values()))["robots"])
        for measure, unit, scale in (("instructions", "thousand instructions", 1e3), ("system_nanoseconds", "µs in system calls", 1e3)):
            total = sum(float(row[measure]) for row in part.values())
            at = 0
            each = " each" if robots > 1 else ""
            bars.append(f"{run}: {total / robots / scale:,.{0 if total / robots / scale >= 100 else 1}f} {unit}{each}")
            for name in names:
                value = float(part[name][measure]) if name in part else 0
                share = 100 * value / total
                table.append([bars[-1], len(bars), names.index(name) + 1, name, f"{value / robots:.1f}", f"{at:.2f}", f"{at + share:.2f}"])
                at += share
    write(figures / "stages.csv", [["bar", "place", "number", "stage", "per robot", "from percent", "to percent"], *table])
    draw(figures, "stages", names=" ".join(name.replace(" ", "_") for name in names), bars=len(bars))


def main():
    source, figures = map(Path, sys.argv[1:])
    figures.mkdir(parents=True, exist_ok=True)
    for name, make in (("one-shot", one_shot), ("fan-out", fan_out), ("stages", stages)):
        if (source / f"{name}.csv").exists():
            make(source, figures)
    ratios(source, figures)


main()
