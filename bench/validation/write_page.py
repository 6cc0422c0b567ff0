"""Writes the data, the pictures and the tables of docs/validation.md."""
import csv
import json
import math
import subprocess

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot as plt  # noqa: E402


def number(x, digits=1):
    return "-" if x is None or math.isnan(x) else "0" if x == 0 else f"{x:.{digits}e}"


def row_of(verdict, rival):
    case = verdict.case
    row = {"configuration": case.name, "source": case.source, "closed form": f"{case.value:.7g}", "viewpeel": f"{verdict.value:.7g}",
           "error": number(verdict.error), "stated": number(verdict.stated), "allowed": number(verdict.allowed)}  # fmt: skip
    if case.levels:
        row["pieces"] = ", ".join(map(str, case.levels))
        row["error with the most pieces"] = number(verdict.answers[-1].value - case.value)
        row["order"] = "-" if math.isnan(verdict.order) else f"{verdict.order:.2f}"
    elif rival:
        row["View3D's error"], row["its CPU s"] = number(rival[0] - case.value), f"{rival[1]:.2f}"
    row["CPU s"] = f"{verdict.cpu_s:.2f}"
    return row


def plot_family(family, verdicts, colours, light, file):
    """Draws a panel for each configuration: for round shapes errors against the number of pieces, for flat shapes the
    error beside the stated error."""
    columns = 5
    rows = math.ceil(len(verdicts) / columns)
    figure, all_axes = plt.subplots(rows, columns, figsize=(2.6 * columns, 2.1 * rows), squeeze=False, layout="constrained")
    for axes in all_axes.ravel()[len(verdicts) :]:
        axes.set_visible(False)
    least = 1e-12  # errors below it are drawn there
    for axes, verdict in zip(all_axes.ravel(), verdicts):
        name = verdict.case.name
        axes.set_title(name if len(name) < 38 else name[:36] + " ...", fontsize=6, color=light["ink"])
        axes.set_yscale("log")
        axes.minorticks_off()
        if verdict.case.levels:
            pieces = verdict.case.levels
            errors = [max(least, abs(a.value - verdict.case.value)) for a in verdict.answers]
            axes.set_xscale("log")
            axes.plot(pieces, errors, "o-", color=colours[2], markersize=3, linewidth=1)
            axes.plot(pieces, [errors[-1] * (pieces[-1] / n) ** 2 for n in pieces], ":", color=light["faint"], linewidth=1)
            axes.plot([pieces[-1]], [max(least, abs(verdict.error))], "v", color=colours[6], markersize=4)
            axes.axhline(max(least, verdict.allowed), color=colours[0], linewidth=0.8)
            axes.set_xticks(pieces, [str(n) for n in pieces])
            axes.minorticks_off()
        else:
            bars = [abs(verdict.error), verdict.stated, verdict.allowed]
            axes.bar(["error", "stated", "allowed"], [max(least, b) for b in bars], color=[colours[2], colours[5], colours[0]], bottom=least / 10)
        axes.tick_params(labelsize=5, colors=light["faint"])
        for spine in axes.spines.values():
            spine.set_color(light["rule"])
    figure.suptitle(family, fontsize=9, color=light["ink"])
    figure.savefig(file, metadata={"Date": None})
    plt.close(figure)


def write(root, verdicts, rivals, comment, summary):
    """In: rivals: View3D's (form factor, CPU s) by the configuration's name; summary: rows of goals"""
    palette = json.loads((root / "page/palette.json").read_text())
    plt.rcParams.update({"svg.hashsalt": "validation", "svg.fonttype": "none", "font.family": "sans-serif"})
    for family in dict.fromkeys(v.case.family for v in verdicts):
        same = [v for v in verdicts if v.case.family == family]
        name = "validation_" + family.replace(" ", "_")
        rows = [row_of(v, rivals.get((family, v.case.name))) for v in same]
        write_table(root / f"docs/data/{name}.csv", rows, comment)
        plot_family(family, same, palette["sequential"], palette["light"], root / f"docs/pictures/{name}.svg")
    write_table(root / "docs/data/validation.csv", summary, comment)
    subprocess.run([root / "bench/plot", "--docs", root / "docs/validation.md"], check=True)


def write_table(file, rows, comment):
    with open(file, "w", newline="") as out:
        out.write(f"# {comment}\n")
        table = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
