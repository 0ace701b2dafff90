#!/usr/bin/env python3
"""Charts of speed against accuracy from the JSON of the benchmarks pareto*, scene, stability*, traced*,
of the program membranes and of examples/calibration_chart.

charts.py RESULTS [KIND]: reads RESULTS/*.json, rewrites those of our own programs with no more than the charts need,
one line a case, draws beside them, as PNG or what KIND names (svg, pdf), and writes what the charts say between the marks
of RESULTS/README.md. Draws nothing with the KIND "words". Needs matplotlib.
"""
import glob
import json
import math
import os
import re
import shutil
import subprocess
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: E402

# One colour and one marker per method, told apart in grey too (Okabe and Ito's colours).
STYLE = {
    "Dijkstra": ("#56B4E9", "v"),
    "fast marching": ("#E69F00", "s"),
    "virtual source": ("#009E73", "D"),
    "heat": ("#CC79A7", "^"),
    "exact": ("#000000", "o"),
    "exact with resets": ("#0072B2", "P"),
    "smooth": ("#7A4FBF", ">"),
    "CGAL exact": ("#000000", "o"),
    "CGAL heat": ("#CC79A7", "^"),
    "heat, intrinsic Delaunay": ("#CC79A7", "X"),
}
SPARE = [("#8C564B", "<"), ("#5D6D7E", "d"), ("#17808A", "p"), ("#A0A000", "h"), ("#C2185B", "*")]
KNOWN = len(STYLE)
MESHES = {
    "sphere": "sphere",
    "membrane": "fingertip membrane",
    "saddle": "saddle",
    "noisy": "noisy sphere",
    "needles": "sphere of needles",
    "graded": "edges 1 : 1000",
}
UNSEEN = ["hourglass", "helicoid", "bumpy", "terrain"]  # no figure of the planner is from these
KIND = sys.argv[2] if len(sys.argv) > 2 else "png"
EXACT = 1e-8  # where an error of rounding alone is drawn


# What Google Benchmark writes of a run beside a benchmark's own figures.
BOOKKEEPING = {"family_index", "per_family_instance_index", "run_name", "run_type", "repetitions",
               "repetition_index", "threads", "iterations", "real_time", "cpu_time", "time_unit"}


def to_four_digits(value):
    """Of a number that is not whole: counts stay as they are."""
    if not isinstance(value, float) or not math.isfinite(value):
        return value
    return int(value) if value.is_integer() else float(f"{value:.4g}")


def program_of(path, context):
    """The program of ours that wrote a file, or "": told by its own word, or where that is no more there by its name."""
    told = context.get("program", context.get("executable", os.path.splitext(path)[0]))
    name = re.sub("(_benchmark)?([.]exe)?$", "", os.path.basename(str(told)))
    return name if name in PROGRAMS else ""


def shrunk(data, program):
    """Of what a benchmark wrote: how it came about, and each case's name and figures to four digits."""
    kept = ("date", "commit", "compiler", "flags", "cpu")
    rows = []
    for row in data["benchmarks"]:
        row = dict(row, median_s=row.get("median_s", seconds(row)))
        row = {k: to_four_digits(v) for k, v in row.items() if k not in BOOKKEEPING}
        row["name"] = re.sub("/(iterations:|manual_time|real_time|repeats:).*", "", row["name"])
        rows.append(row)
    context = {k: data["context"][k] for k in kept if k in data["context"]}
    return {"context": dict(context, program=program) if program else context, "benchmarks": rows}


def write(path, data):
    """One line a case."""
    lines = ",\n".join(json.dumps(row, separators=(",", ":")) for row in data["benchmarks"])
    with open(path, "w") as file:
        file.write('{"context": %s,\n"benchmarks": [\n%s\n]}\n' % (json.dumps(data["context"]), lines))


def style(method):
    """A method's colour and marker: of those that are not named above, spare ones in turn."""
    if method not in STYLE:
        STYLE[method] = SPARE[(len(STYLE) - KNOWN) % len(SPARE)]
    return STYLE[method]


def reason_of(error):
    """What went wrong, in words for who wrote the file rather than for who wrote this program."""
    if isinstance(error, json.JSONDecodeError):
        return f"line {error.lineno}, column {error.colno}: this is no JSON: {error.msg}"
    if isinstance(error, UnicodeDecodeError):
        return f"byte {error.start} is not UTF-8: this is no JSON"
    if isinstance(error, RecursionError):
        return "it nests too deep"
    if isinstance(error, KeyError):
        return 'there is no "' + "/".join(map(str, error.args[0] if isinstance(error.args[0], tuple) else error.args)) + '"'
    if isinstance(error, OSError):
        return error.strerror
    if isinstance(error, (TypeError, AttributeError, IndexError, ZeroDivisionError)):
        return "a field is missing, or of another kind than the chart wants"
    return " ".join(str(error).split())


class Unreadable(Exception):
    """Says which file is not what it has to be, where and why."""


def read_json(path):
    """A file's object of JSON. Raises Unreadable, which names file, line and reason."""
    try:
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
    except (OSError, ValueError, RecursionError) as error:
        raise Unreadable(f"{path}, {reason_of(error)}") from error
    if not isinstance(data, dict):
        raise Unreadable(f"{path}, line 1: it is not an object, as {{...}}")
    return data


def read_results(path):
    """The context and the rows of a file, as Google Benchmark writes it. Raises Unreadable as `read_json` does."""
    data = read_json(path)
    for key, kind, what in (("context", dict, "no object"), ("benchmarks", list, "no list")):
        if key not in data:
            raise Unreadable(f'{path} has no "{key}", as Google Benchmark writes it')
        if not isinstance(data[key], kind):
            raise Unreadable(f'{path}: its "{key}" is {what}, as Google Benchmark writes it')
    return data


def load(folder):
    """All benchmarks of a folder's JSON files that succeeded, each with its context, and what failed."""
    rows, failed = [], []
    paths = [p for name in ("pareto*", "scene*", "stability*", "traced*", "membranes") for p in glob.glob(
        os.path.join(folder, name + ".json"))]
    for path in sorted(paths):
        try:
            data = read_results(path)
            program = program_of(path, data["context"])
            if any("run_name" in row for row in data["benchmarks"]):
                data = shrunk(data, program)
                if program:  # others' files stay as they are
                    write(path, data)
        except Exception as error:  # whatever a file may hold: the others' rows are drawn all the same
            failed.append(str(error) if isinstance(error, Unreadable) else f"{path}: {reason_of(error)}")
            continue
        rows_of_file, context = data["benchmarks"], data["context"]
        if not any(str(row["name"]).split("/")[0] in TOPICS for row in rows_of_file
                   if isinstance(row, dict) and "name" in row):
            failed.append(f"{path}: no row is of what a chart shows ({', '.join(TOPICS)})")
        for number, row in enumerate(rows_of_file):
            if wrong := fault_of(row):
                failed.append(f"{path}: row {number}, {wrong}")
                continue
            row["context"] = context if program else dict(context, file=os.path.basename(path))
            row["own"] = bool(program)
            row["path"] = row["name"].split("/")
            if len(row["path"]) < 3 and row["path"][0] in ("distance", "stability"):
                failed.append("{}: no name of the form {}/MESH/METHOD".format(
                    row["name"], row["path"][0]))
                continue
            if not program and len(row["path"]) > 2 and row["path"][2] in METHODS:  # not to be mixed with ours
                row["path"][2] += f" ({os.path.basename(path)})"
            row.setdefault("median_s", seconds(row))
            if row.get("error_occurred"):
                failed.append("{}: {}".format(row["name"], row.get("error_message", "it failed")))
            else:
                rows.append(row)
    return one_row_a_case(rows), failed


def one_row_a_case(rows):
    """The rows, those of one case of traced light from several files as one: what the first lacks is the others'."""
    first, out = {}, []
    for row in rows:
        if row["path"][0] == "traced" and row["name"] in first:
            first[row["name"]].update({k: v for k, v in row.items() if k not in first[row["name"]]})
            continue
        first[row["name"]] = row
        out.append(row)
    return out


METHODS = tuple(STYLE)
PROGRAMS = ("pareto", "pareto_cgal", "pareto_image", "scene", "scene_planned", "stability", "stability_cgal", "traced_embree", "membranes")
TOPICS = ("distance", "certify", "plan", "stability", "scene", "traced", "membranes", "transport", "log_map",
          "normals", "smoothing", "frame")
TEXTS = {"name", "label", "run_name", "run_type", "aggregate_name", "aggregate_unit", "time_unit", "error_message", "skip_message"}


def fault_of(row):
    """What keeps a row from every chart, if anything does."""
    if not isinstance(row, dict) or not isinstance(row.get("name"), str):
        return "has no name"
    if row.get("error_occurred"):
        return None
    name = row["name"]
    if row.get("time_unit", "ns") not in ("ns", "us", "ms", "s"):
        return f"{name}: time in {row['time_unit']}"
    for key, value in row.items():
        if key not in TEXTS and not (isinstance(value, (int, float)) and math.isfinite(value)):
            return f"{name}: {key} is {json.dumps(value)}, not a number"
        if key in ("real_time", "median_s", "ratio") and value <= 0:
            return f"{name}: {key} is {json.dumps(value)}, not positive"
        if key in ("mean", "smooth_mean") and value < 0:
            return f"{name}: {key} is {json.dumps(value)}, an error below 0"
    if name.startswith("distance/"):
        if not {"mean", "smooth_mean"} & row.keys():
            return f"{name}: no error, neither mean nor smooth_mean"
        if not {"real_time", "median_s"} & row.keys():
            return f"{name}: no time, neither real_time nor median_s"
    return None


def seconds(row):
    """Of an iteration, as Google Benchmark writes it."""
    return row.get("real_time", 0) * {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1}[
        row.get("time_unit", "ns")]


def save(figure, folder, name, rows):
    """The chart, and at its foot how the rows came about that it draws."""
    words = (("", "file"), ("", "cpu"), ("commit ", "commit"), ("", "compiler"), ("", "flags"))
    contexts = [dict(row.get("context", {})) for row in rows]
    for context in contexts:
        context["cpu"] = context.get("cpu") or "machine unknown"
    made = dict.fromkeys(", ".join(word + str(context[key]) for word, key in words
                                   if context.get(key, "unknown") != "unknown")
                         for context in contexts)
    figure.text(0.995, 0.003, "; ".join(made), ha="right", va="bottom", fontsize=6, color="0.4")
    write_chart(figure, folder, name)


def write_chart(figure, folder, name):
    """A PNG as small as pngquant makes it, where there is one."""
    path = os.path.join(folder, f"{name}.{KIND}")
    figure.savefig(path, dpi=110, facecolor="white")
    plt.close(figure)
    if KIND == "png" and shutil.which("pngquant"):
        subprocess.run(["pngquant", "--force", "--output", path, "128", path], check=True)


def ink(colour):
    """A colour as dark as words need it."""
    return tuple(0.72 * c for c in matplotlib.colors.to_rgb(colour))


def label_ends(axes, ends, size=9):
    """Names to the right of a panel, each at its line's last point, moved apart where they would overlap.

    ends: (name, colour, x, y). Call it once limits and layout stand.
    """
    step = 1.25 * size / 72 * axes.figure.dpi / axes.bbox.height
    heights = axes.transAxes.inverted().transform(axes.transData.transform([e[2:] for e in ends]))[:, 1]
    order = sorted(range(len(ends)), key=lambda i: heights[i])
    placed = []
    for i in order:
        placed.append(max(heights[i], placed[-1] + step if placed else -1))
    for k in reversed(range(len(placed))):
        placed[k] = min(placed[k], placed[k + 1] - step if k + 1 < len(placed) else 1)
    for i, height in zip(order, placed):
        axes.text(1.02, height, ends[i][0], transform=axes.transAxes, va="center", fontsize=size,
                  color=ink(ends[i][1]))


def label_beside(axes, labels, size=8, far=False):
    """A name beside each mark, on the side where it covers least of lines, marks and other names.

    labels: (name, colour, x, y). Call it once limits and layout stand.
    """
    figure = axes.figure
    renderer = figure.canvas.get_renderer()
    taken = []  # points that are drawn on, in pixels: their radius, and how bad it is to cover them
    for line in axes.lines:
        points = line.get_transform().transform(line.get_xydata())
        alone = line.get_linestyle() == "None" or len(points) == 1
        taken += [(x, y, 6, 30) for x, y in points if line.get_marker() != "None"]
        for (x, y), (u, v) in [] if alone else zip(points, points[1:]):
            steps = max(1, min(400, int(math.hypot(u - x, v - y) / 3)))
            taken += [(x + (u - x) * k / steps, y + (v - y) * k / steps, 1, 1) for k in range(steps + 1)]
    boxes = [text.get_window_extent(renderer).extents for text in axes.texts]
    frame, pixel = axes.bbox, figure.dpi / 72
    for name, colour, x, y in labels:
        text = axes.annotate(name, (x, y), xytext=(0, 0), textcoords="offset points", fontsize=size,
                             color=ink(colour), zorder=6, ha="center", va="center")
        extent = text.get_window_extent(renderer)
        wide, high = extent.width / pixel, extent.height / pixel
        px, py = axes.transData.transform((x, y))
        best = None
        for gap in (6, 12, 20, 30) if far else (6, 12):
            for sx, sy in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)):
                dx, dy = sx * (gap + wide / 2), sy * (gap + high / 2)
                if sx and sy:
                    dx, dy = sx * (gap / 2 + wide / 2), sy * (gap / 2 + high / 2)
                box = (px + pixel * (dx - wide / 2) - 1, py + pixel * (dy - high / 2) - 1,
                       px + pixel * (dx + wide / 2) + 1, py + pixel * (dy + high / 2) + 1)
                hits = sum(bad for u, v, r, bad in taken
                           if box[0] - r < u < box[2] + r and box[1] - r < v < box[3] + r)
                hits += 300 * sum(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in boxes)
                hits += 200 * (box[0] < frame.x0 or box[2] > frame.x1 + 4 or box[1] < frame.y0 or box[3] > frame.y1)
                hits += 0.1 * gap + (0.3 if sx and sy else 0)
                if best is None or hits < best[0]:
                    best = hits, (dx, dy), box
        text.set_position(best[1])
        boxes.append(best[2])


def span_of(values, words):
    """From the least to the largest, in words: "3 to 5", or "3" where they read alike."""
    low, high = words(min(values)), words(max(values))
    return low if low == high else f"{low} to {high}"


def times(ratio):
    return f"{ratio:.0f}" if ratio >= 9.95 else f"{ratio:.1f}"


def percent(share):
    """A share to two digits, in per cent, whatever its size."""
    return f"{float(f'{100 * share:.2g}'):g} %".replace("e-0", "e-")


def plain_ticks(axis, steps=(1,), percent=False):
    """A logarithmic axis' numbers written out."""
    axis.set_major_locator(LogLocator(subs=steps))
    axis.set_major_formatter(FuncFormatter(
        lambda x, _: (f"{100 * x:g} %" if percent else f"{x:g}").replace("e-0", "e-").replace("e+0", "e")))
    axis.set_minor_formatter(NullFormatter())


def front(points):
    """Those points (time, error) than which none is both quicker and more accurate."""
    best, kept = float("inf"), []
    for time, error in sorted(points):
        if error < best:
            kept.append((time, error))
            best = error
    return kept


def marker(axes, method, x, y, size=8):
    colour, shape = style(method)
    hollow = method.startswith("CGAL")
    axes.plot(x, y, linestyle="none", marker=shape, markersize=size, markeredgewidth=1.4,
              markerfacecolor="none" if hollow else colour,
              markeredgecolor=colour if hollow else "white", zorder=4)


def is_ours(row):
    """Not CGAL's, which programs of ours measure, nor of a file of others."""
    return row.get("own", True) and not row["path"][2].startswith("CGAL")


def draw_mesh(axes, rows, error_name, time_of, floor, left_out=("planner",)):
    """Every method's dial on one mesh: time against error, the front, the floor."""
    groups, ours = {}, []
    for row in rows:
        method = row["path"][2]
        if error_name not in row or method in left_out:
            continue
        point = 1e3 * time_of(row), max(row[error_name], EXACT)
        groups.setdefault(method, []).append(point)
        if is_ours(row):
            ours.append(point)
    for method, points in groups.items():
        axes.plot(*zip(*sorted(points)), color=style(method)[0], linewidth=0.8, alpha=0.5, zorder=3)
        for x, y in points:
            marker(axes, method, x, y)
    kept = front(ours)
    if kept:
        xs, ys = [], []
        for (x, y), following in zip(kept, kept[1:] + [kept[-1]]):
            xs += [x, following[0]]
            ys += [y, y]
        axes.plot(xs, ys, color="0.8", linewidth=4, zorder=1, solid_joinstyle="round")
    axes.set_xscale("log")
    if groups:
        axes.set_xlim(*axes_time(groups))
    axes.set_yscale("log")
    plain_ticks(axes.xaxis)
    axes.set_ylim(EXACT / 3, 1)
    if floor > 0:
        axes.axhspan(EXACT / 3, floor, color="0.92", zorder=0)
        axes.axhline(floor, color="0.35", linewidth=1, linestyle=(0, (4, 2)), zorder=1)
        axes.text(0.985, floor * 0.7, "grey: finer than the mesh itself", va="top", ha="right", fontsize=7,
                  color="0.25", transform=axes.get_yaxis_transform())
    axes.grid(True, which="major", color="0.88", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.set_yticks([1, 1e-2, 1e-4, 1e-6, EXACT])
    axes.set_yticklabels(["100 %", "1 %", "0.01 %", "0.0001 %", "rounding"])
    return groups


def axes_time(groups):
    times = [x for points in groups.values() for x, _ in points]
    return min(times) / 2, max(times) * 4


# Their marks are on those of our own, or among others' lines, or they answer another question, distances on the
# smooth surface: they stand in sphere.png and in the JSON.
NOT_IN_DISTANCES = ("planner", "exact with resets", "CGAL heat", "smooth")


def claim_of_distances(rows, time_of):
    """How long exact distances take, and how many times as long CGAL's, over the meshes that have both."""
    found = {(r["path"][1], r["path"][2]): time_of(r) for r in rows if r["path"][2] in ("exact", "CGAL exact")}
    pairs = [(t, found[mesh, "CGAL exact"]) for (mesh, method), t in found.items()
             if method == "exact" and (mesh, "CGAL exact") in found]
    if not pairs:
        return ": time against error"
    return (f": exact distances take {span_of([1e3 * ours for ours, _ in pairs], '{:.0f}'.format)} ms, "
            f"CGAL's {span_of([peer / ours for ours, peer in pairs], times)} times as long")


def chart_distances(rows, folder):
    rows = [r for r in rows if r["path"][0] == "distance"]
    if not rows:
        return
    meshes = [m for m in dict.fromkeys(r["path"][1] for r in rows)]
    kinds = [("query", "one more source", lambda r: r["median_s"]),
             ("first", "mesh to first answer", lambda r: r.get("setup_s", 0) + r.get("first_s", r["median_s"]))]
    for kind, words, time_of in kinds:
        width = min(3, len(meshes))
        height = (len(meshes) + width - 1) // width
        figure, axes = plt.subplots(height, width, figsize=(max(8.5, 12.5 * width / 3), 3.7 * height + 0.6),
                                    squeeze=False, sharey=True)
        drawn = []
        for place, mesh in zip(axes.flat, meshes):
            here = [r for r in rows if r["path"][1] == mesh]
            groups = draw_mesh(place, here, "mean", time_of, here[0].get("floor", 0), NOT_IN_DISTANCES)
            drawn.append((place, groups))
            size = max((r.get("vertices", 0) for r in here), default=0)
            place.set_title(MESHES.get(mesh, mesh) + (f", {size:,.0f} vertices" if size else ""),
                            fontsize=10)
        for place in axes.flat[len(meshes):]:
            place.axis("off")
        for place in axes[-1]:
            place.set_xlabel(f"milliseconds, {words}")
        for place in axes[:, 0]:
            place.set_ylabel("mean error against the exact distance")
        figure.suptitle(words[0].upper() + words[1:] + claim_of_distances(rows, time_of), fontsize=14,
                        fontweight="bold")
        figure.text(0.5, 1 - 0.55 / figure.get_figheight(), "Left is faster, down is more accurate. Marks of one "
                    "method: its settings. Wide grey line: nothing of ours is both faster and more accurate.",
                    fontsize=9 if width == 3 else 7.5, ha="center", color="0.25")
        figure.tight_layout(rect=(0, 0.015, 1, 1 - 0.35 / figure.get_figheight()))
        for place, groups in drawn:
            label_beside(place, [(method, style(method)[0], *sorted(points)[0])
                                 for method, points in groups.items()])
        save(figure, folder, f"distance_{kind}", rows)


def chart_sphere(rows, folder):
    """One mesh, large, against the great circle: what a tenth of a percent costs."""
    rows = [r for r in rows if r["path"][:2] == ["distance", "sphere"]]
    if not rows:
        return
    figure, axes = plt.subplots(figsize=(8.4, 5.6))
    floor = max(r.get("floor", 0) for r in rows)
    groups = draw_mesh(axes, rows, "smooth_mean", lambda r: r["median_s"], floor)
    low, high = axes.get_xlim()
    axes.set_xlim(low / 2, high * 1.6)
    least = min([max(floor, 1e-4)] + [y for _, y in groups.get("smooth", [])])
    marks = [(0.1, "10 %"), (0.01, "1 %"), (1e-3, "0.1 %"), (1e-4, "0.01 %"), (1e-6, "1e-6"), (EXACT, "rounding")]
    marks = [(y, name) for y, name in marks if y > least / 8]
    axes.set_ylim(least / 8, 0.3)
    axes.set_yticks([y for y, _ in marks])
    axes.set_yticklabels([name for _, name in marks])
    claim = "What accuracy costs"
    if "CGAL exact" in groups and "exact" in groups:
        (x, y), (x_peer, _) = groups["exact"][0], groups["CGAL exact"][0]
        axes.plot([x * 1.3, x_peer / 1.2], [y, y], color="0.15", linewidth=1.2)
        axes.plot(x * 1.3, y, "<", color="0.15", markersize=5)
        axes.text((x * x_peer) ** 0.5, y * 1.1, f"{x_peer / x:.0f} times as fast", ha="center",
                  va="bottom", fontsize=10, fontweight="bold")
        claim = f"Exact distances in {x:.0f} ms, {x_peer / x:.0f} times as fast as CGAL's"
    axes.set_xlabel("milliseconds for one more source")
    axes.set_ylabel("mean error against the great circle")
    size = " of {:,.0f} vertices".format(rows[0]["vertices"]) if "vertices" in rows[0] else ""
    axes.set_title(f"{claim}\non a sphere{size}; left is faster, down is more accurate", fontsize=12,
                   fontweight="bold")
    figure.tight_layout(rect=(0, 0.015, 1, 1))
    label_beside(axes, [(method, style(method)[0], *sorted(points)[0]) for method, points in groups.items()], 10)
    save(figure, folder, "sphere", rows)


def words_distances(rows, folder):
    """Which methods are on the front of how many meshes: none of ours is both quicker and more accurate."""
    rows = [r for r in rows if r["path"][0] == "distance" and "mean" in r
            and r["path"][2] not in ("planner", "smooth") and is_ours(r)]
    if not rows:
        return
    meshes = dict.fromkeys(r["path"][1] for r in rows)
    on_front = {}
    for mesh in meshes:
        here = [r for r in rows if r["path"][1] == mesh]
        best = front([(r["median_s"], r["mean"]) for r in here])
        for method in {r["path"][2] for r in here if (r["median_s"], r["mean"]) in best}:
            on_front[method] = on_front.get(method, 0) + 1
    lines = [f"On the front for one more source, of {len(meshes)} meshes: " +
             ", ".join(f"{m} on {on_front[m]}" for m in STYLE if m in on_front) +
             ("; never: " + ", ".join(m for m in STYLE if m not in on_front and any(r["path"][2] == m for r in rows))
              if any(r["path"][2] not in on_front for r in rows) else "") + "."]
    write_between(os.path.join(folder, "README.md"), "distances", lines)


def words_sphere(rows, folder):
    """What the chart of the sphere says."""
    rows = {"/".join(r["path"][2:]): r for r in rows if r["path"][:2] == ["distance", "sphere"]}
    if not rows:
        return
    three = "exact/default", "fast marching/default", "virtual source/default"
    if any(name not in rows for name in three):
        return
    exact, marching, virtual = (rows[name] for name in three)
    lines = [f"Off by {percent(marching['smooth_mean'])} in {1e3 * marching['median_s']:.1f} ms (fast marching), by "
             f"{percent(virtual['smooth_mean'])} in {1e3 * virtual['median_s']:.1f} ms (virtual sources), by no more "
             f"than the mesh itself, {percent(exact['smooth_mean'])}, in {1e3 * exact['median_s']:.0f} ms (exact)."]
    smooth = [rows[name] for name in ("smooth/normals from the mesh", "smooth/normals given") if name in rows]
    if len(smooth) == 2:
        fitted, given = smooth
        lines[0] += (f" On the smooth surface, which the mesh stands for, by {percent(fitted['smooth_mean'])} with "
                     f"normals fitted to the mesh and {percent(given['smooth_mean'])} with given ones, in "
                     f"{1e3 * given['median_s']:.0f} ms.")
    if peer := next((r for name, r in rows.items() if name.startswith("CGAL exact")), None):
        lines[0] += (f" CGAL's exact distances are the same and take {times(peer['median_s'] / exact['median_s'])} "
                     f"times as long, in {times(peer['peak_MB'] / exact['peak_MB'])} times the memory.")
    write_between(os.path.join(folder, "README.md"), "sphere", lines)


def chart_certificate(rows, folder):
    exact = {r["path"][1]: r for r in rows
             if r["path"][0] == "distance" and r["path"][2] == "exact"}
    certified = [r for r in rows if r["path"][0] == "certify" and r["path"][1] in exact and "mean" in r]
    if not certified:
        return
    figure, axes = plt.subplots(figsize=(7.5, 4.6))
    for row in certified:
        mesh = row["path"][1]
        share = row["median_s"] / exact[mesh]["median_s"]
        axes.plot([share, share], [row["mean"], row["p99"]], color="0.6", linewidth=2, zorder=1)
        axes.plot(share, row["mean"], "o", color="#0072B2", markersize=9, zorder=2)
    axes.set_yscale("log")
    axes.axvline(1, color="0.35", linestyle=(0, (4, 2)), linewidth=1)
    axes.text(1, 0.98, " an exact solve", transform=axes.get_xaxis_transform(), va="top",
              fontsize=8, color="0.25")
    axes.set_xlim(0, 1.45)
    axes.set_ylim(bottom=min(r["mean"] for r in certified) / 3)
    plain_ticks(axes.yaxis, percent=True)
    axes.set_xlabel("time of the certificate, as a share of an exact solve")
    axes.set_ylabel("gap between the bounds, as a share of the distance")
    axes.text(0.985, 0.03, "dot: mean over the vertices\nline: up to the 99th percentile", fontsize=8,
              ha="right", transform=axes.transAxes, color="0.25")
    axes.grid(True, color="0.88", linewidth=0.6)
    shares = [row["median_s"] / exact[row["path"][1]]["median_s"] for row in certified]
    axes.set_title(f"A proof of the error takes {span_of(shares, times)} times an exact solve,\n"
                   f"and leaves {span_of([row['mean'] for row in certified], percent)} open in the mean",
                   fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0.015, 1, 1))
    label_beside(axes, [(MESHES.get(row["path"][1], row["path"][1]), "#000000", share, row["mean"])
                        for row, share in zip(certified, shares)], 9)
    save(figure, folder, "certificate", certified + [exact[row["path"][1]] for row in certified])


def words_certificate(rows, folder):
    """How tight the bounds are, and what one more exact solve would take."""
    exact = {r["path"][1]: r["median_s"] for r in rows
             if r["path"][0] == "distance" and r["path"][2] == "exact"}
    certified = [r for r in rows if r["path"][0] == "certify" and r["path"][1] in exact and "mean" in r]
    if not certified:
        return

    def named(row, value):
        return f"{value} ({MESHES.get(row['path'][1], row['path'][1])})"

    gaps = sorted(certified, key=lambda r: r["mean"])
    solves = sorted(certified, key=lambda r: exact[r["path"][1]] / r["median_s"])
    lines = ["`Certifier` bounds the exact distance at every vertex from both sides, "
             f"{named(gaps[0], percent(gaps[0]['mean']))} to {named(gaps[-1], percent(gaps[-1]['mean']))} apart in the "
             "mean: tight where the mesh is smooth. One more exact solve leaves no gap, in "
             + " to ".join(named(r, times(exact[r["path"][1]] / r["median_s"])) for r in (solves[0], solves[-1])) +
             " times the time of the bounds."]
    write_between(os.path.join(folder, "README.md"), "certificate", lines)


PROMISES = {"expected": "error expected", "sampled": "checked at 4 targets",
            "certified": "proved everywhere, or exact\nand checked at 4 targets"}


def chart_planner(rows, folder):
    """A mark a mesh: the planner's time over that of the best method in hindsight."""
    rows = [r for r in rows if r["path"][0] == "plan"]
    if not rows:
        return
    tolerances = sorted({r["tolerance"] for r in rows}, reverse=True)
    known = list(MESHES) + UNSEEN
    meshes = {r["path"][1] for r in rows}
    last_of = {}  # a mesh of the reader's own is named once a panel, at its tightest tolerance
    for row in rows:
        at = row["path"][2], row["path"][1]
        last_of[at] = max(last_of.get(at, 0), tolerances.index(row["tolerance"]))
    figure, panels = plt.subplots(1, 3, figsize=(11.5, 4.6), sharey=True)
    figure.subplots_adjust(left=0.065, right=0.93, bottom=0.16, top=0.76, wspace=0.12)
    for axes, (kind, title) in zip(panels, PROMISES.items()):
        here = [r for r in rows if r["path"][2] == kind]
        axes.set(yscale="log", title=title, xlabel="tolerance asked for (mean error)")
        axes.title.set_fontsize(10)
        axes.axhline(1, color="0.35", linewidth=1)
        for row in here:
            mesh, x = row["path"][1], tolerances.index(row["tolerance"])
            if mesh not in known:
                axes.plot(x, row["ratio"], "D", color="#D55E00", zorder=4)
                if x == last_of[kind, mesh]:
                    axes.annotate(mesh, (x, row["ratio"]), textcoords="offset points", xytext=(0, 8),
                                  fontsize=8, color=ink("#D55E00"), ha="center")
                continue
            axes.plot(x + 0.03 * (known.index(mesh) - 4.5), row["ratio"], "o", markersize=5,
                      color="#0072B2", alpha=0.75, zorder=3, markeredgewidth=1,
                      markerfacecolor="white" if mesh in UNSEEN else "#0072B2")
        ends = []
        for name, colour, pick in (("dearest", "#D55E00", max), ("median", "#000000", median)):
            points = [(tolerances.index(t), pick([r["ratio"] for r in here if r["tolerance"] == t]))
                      for t in tolerances if any(r["tolerance"] == t for r in here)]
            if points and len(meshes) > 1:  # of a single mesh both are its own line
                axes.plot(*zip(*points), color=colour, linewidth=1.6, zorder=2)
                ends.append((name, colour, *points[-1]))
        axes.set_xticks(range(len(tolerances)))
        axes.set_xticklabels([percent(t) for t in tolerances])
        axes.set_xlim(-0.4, len(tolerances) - 0.6)
        axes.set_ylim(min(0.2, min(r["ratio"] for r in rows) / 1.2), max(2, 1.2 * max(r["ratio"] for r in rows)))
        ticks = [t for t in (0.25, 0.5, 1, 1.5, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if t <= axes.get_ylim()[1]]
        axes.set_yticks(ticks)
        axes.set_yticklabels([f"{t:g}" for t in ticks])
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.grid(True, axis="y", color="0.9", linewidth=0.6)
        if ends and axes is panels[2]:
            label_ends(axes, ends)
    panels[0].set_ylabel("planner's time / best method's")
    figure.suptitle("Not knowing the best method beforehand costs at most "
                    f"{max(r['ratio'] for r in rows):.2f} times its time", fontsize=13, fontweight="bold")
    figure.text(0.5, 0.885, f"{len(rows)} plans; a mark a mesh, hollow where none of the planner's figures is from "
                "it; below 1: quicker than any single method", ha="center", fontsize=9, color="0.25")
    save(figure, folder, "planner", rows)


def words_planner(rows, folder):
    """How far the planner's time is from the best in hindsight, and where it is farthest."""
    rows = [r for r in rows if r["path"][0] == "plan"]
    if not rows:
        return
    ratios = [r["ratio"] for r in rows]
    lines = [f"Of {len(rows)} plans {sum(x <= 1.5 for x in ratios)} take at most 1.5 times the time of the best method "
             f"in hindsight, {sum(x <= 1.1 for x in ratios)} at most 1.1 times; the median is {median(ratios):.2f}. "
             "Dearest, with the error of what was best:", ""]
    for row in sorted(rows, key=lambda r: -r["ratio"])[:4]:
        promise = PROMISES[row["path"][2]].split(",")[0]
        lines.append(f"- {MESHES.get(row['path'][1], row['path'][1])} at {100 * row['tolerance']:g} %, {promise}: "
                     f"{row['ratio']:.2f} times" + (f" ({percent(row['best_error'])})" if "best_error" in row else ""))
    write_between(os.path.join(folder, "README.md"), "planner", lines)


def median(values):
    values = sorted(values)
    return (values[(len(values) - 1) // 2] + values[len(values) // 2]) / 2


# Of each panel: its rows, the error, its name and what that is called.
IMAGES = [("transport", "", "angle_mean", "Vector transport on spheres", "mean angle off, degrees"),
          ("log_map", "", "angle_mean", "Log map on the same spheres", "mean angle off, degrees"),
          ("normals", "", "angle_mean", "Normals of a noisy depth map", "mean angle off, degrees"),
          ("smoothing", "sigma 5", "depth_max", "Depth smoothing, sigma 5", "largest error / depth range"),
          ("smoothing", "sigma 20", "depth_max", "Depth smoothing, sigma 20", "largest error / depth range"),
          ("frame", "", "levels_mean", "Whole frames, 640 x 480", "mean grey levels off")]


def dial(row):
    """A row of an image benchmark: the method whose dial it is, and its setting, in few words."""
    method, setting = row["path"][1], row["path"][2]
    for pattern, name, unit in (("cut off at (.*) sigma", "Gaussian, cut off", " sigma"), ("(.*) boxes", "boxes", "")):
        if found := re.fullmatch(pattern, method):
            return name, found[1] + unit
    if row["path"][0] == "smoothing":
        return method, ""
    setting = setting.replace("cut off at ", "").replace(" vertices", "")
    return method, f"{int(setting):,}" if setting.isdigit() else setting


def claim_of_images(topic, setting, rows):
    """What a panel says, from its rows: how much faster, how much nearer; none where rows lack."""
    def of(method, ending=""):
        return next(r for r in rows if r["path"][:2] == [topic, method] and setting in r["name"]
                    and r["name"].endswith(ending))

    try:
        if topic == "transport":
            heat, paths = of("vector heat", "/10242 vertices"), of("exact paths", "/10242 vertices")
            return (f"{times(paths['median_s'] / heat['median_s'])} times as fast by heat as along exact paths,\n"
                    f"{heat['angle_mean']:.2f} degrees off beside {paths['angle_mean']:.2f}")
        if topic == "log_map":
            heat, exact = of("vector heat", "/10242 vertices"), of("exact", "/10242 vertices")
            return (f"exact paths are {times(heat['angle_mean'] / exact['angle_mean'])} times as near,\n"
                    f"in {times(exact['median_s'] / heat['median_s'])} times the time")
        if topic == "normals":
            fit, sobel = of("plane fit", "/9 x 9"), of("Sobel")
            return (f"a plane fitted to 9 x 9 pixels is {times(sobel['angle_mean'] / fit['angle_mean'])} times\n"
                    f"as near as Sobel, in {times(fit['median_s'] / sobel['median_s'])} times the time")
        if topic == "smoothing":
            gaussian, recursive = of("cut off at 3 sigma"), of("recursive")
            return (f"recursive is {times(gaussian['depth_max'] / recursive['depth_max'])} times as near as a cut at "
                    f"3 sigma,\nin {times(recursive['median_s'] / gaussian['median_s'])} times its time")
        single, double = of("float", "3 sigma"), of("double", "3 sigma")
        return (f"float takes {percent(single['median_s'] / double['median_s'])} of double's time,\n"
                f"at {single['levels_mean'] / double['levels_mean']:.2f} times its error")
    except StopIteration:
        return None


def chart_images(rows, folder):
    """Transport, log maps, normals, smoothing and frames: one panel each, and what it says."""
    rows = [r for r in rows if r["path"][0] in [p[0] for p in IMAGES] and len(r["path"]) > 2]
    if not rows:
        return
    figure, axes = plt.subplots(2, 3, figsize=(12, 8))
    colours = ["#000000", "#0072B2", "#009E73", "#D55E00", "#A0527F"]
    for place, (topic, setting, error, title, label) in zip(axes.flat, IMAGES):
        here = [r for r in rows if r["path"][0] == topic and setting in r["name"] and error in r]
        if not here:
            place.axis("off")
            continue
        least = min([r[error] for r in here if r[error] > 0], default=1e-3) / 5
        place.set(xscale="log", yscale="log", xlabel="milliseconds", ylabel=label)
        for i, method in enumerate(dict.fromkeys(dial(r)[0] for r in here)):
            colour = colours[i % len(colours)]
            points = [(1e3 * r["median_s"], max(r[error], least), dial(r)[1]) for r in here
                      if dial(r)[0] == method]  # in the order of the dial
            place.plot(*zip(*[p[:2] for p in points]), marker="osD^v"[i % 5], linewidth=1, color=colour,
                       markersize=7, markeredgecolor="white")
            before = None
            for x, y, words in points:
                is_near = before and max(abs(math.log(x / before[0])), abs(math.log(y / before[1]))) < 0.15
                place.annotate(words, (x, y), textcoords="offset points", xytext=(7, -17 if is_near else -8),
                               fontsize=7.5, color="0.3")
                before = x, y
            highest = max(points, key=lambda p: p[1])[:2]
            place.annotate(method, highest, textcoords="offset points", fontsize=9, color=ink(colour),
                           xytext=(-6, 8) if len(points) > 1 else (7, 4))
        place.margins(0.2)
        low, high = place.get_xlim()
        place.set_xlim(low, high * (high / low) ** 0.3)  # for the words
        for axis, values in ((place.xaxis, [r["median_s"] for r in here]), (place.yaxis, [r[error] for r in here])):
            plain_ticks(axis, steps=(1, 2, 5) if max(values) < 30 * max(min(values), 1e-30) else (1,))
        said = claim_of_images(topic, setting, rows)
        place.set_title(title + (":\n" + said if said else ""), fontsize=9.5)
        place.grid(True, color="0.9", linewidth=0.6)
    figure.suptitle("Vectors and images: left is faster, down is more accurate", fontsize=13,
                    fontweight="bold")
    figure.tight_layout(rect=(0, 0.015, 1, 0.985))
    save(figure, folder, "images", rows)


def words_images(rows, folder):
    """What the panels of that chart say."""
    lines = []
    for topic, setting, _, title, _ in IMAGES:
        if said := claim_of_images(topic, setting, rows):
            lines.append(f"- {title}: {' '.join(said.split())}.")
    write_between(os.path.join(folder, "README.md"), "images", lines)


def chart_scene(rows, folder):
    """What each choice of a simulator's author changes in the image he gets."""
    rows = [r for r in rows if r["path"][0] == "scene" and r["path"][1] != "planned"]
    if not rows:
        return
    topics = list(dict.fromkeys(r["path"][1] for r in rows))
    figure, axes = plt.subplots(figsize=(8.6, 0.27 * (len(rows) + 2 * len(topics)) + 1.7))
    least, seen = 0.005, 0.5
    against = {"mesh edges": "against edges of 0.4 mm",
               "light field's grid": "against light at every pixel",
               "smoothing": "against a Gaussian cut off at 8 sigma",
               "light model": "instead of geodesic light"}
    colours = dict(zip(topics, ["#0072B2", "#B07800", "#009E73", "#A0527F"]))
    y, ticks, names = 0, [], []
    for topic in topics:
        axes.text(least * 1.1, y, topic, va="center", fontsize=10, fontweight="bold",
                  color=colours[topic])
        axes.text(seen * 1.2, y, against.get(topic, ""), va="center", fontsize=8,
                  color=colours[topic])
        y += 1
        for row in [r for r in rows if r["path"][1] == topic]:
            value = max(row["levels_mean"], least * 1.15)
            axes.plot([least, value], [y, y], color=colours[topic], linewidth=1.5, alpha=0.4)
            axes.plot(value, y, "o", color=colours[topic], markersize=8)
            axes.text(330, y, f"{row['levels_p99']:.0f}", ha="right", va="center", fontsize=8)
            axes.text(1500, y, f"{1e3 * row['median_s']:.0f} ms", ha="right", va="center",
                      fontsize=8, color=colours[topic])
            ticks.append(y)
            names.append(row["path"][2])
            y += 1
        y += 0.5
    axes.text(330, -0.1, "99 % of\npixels within", ha="right", va="center", fontsize=7,
              color="0.25")
    axes.text(1500, -0.1, "time", ha="right", va="center",
              fontsize=7, color="0.25")
    axes.axvline(seen, color="0.35", linestyle=(0, (4, 2)), linewidth=1)
    axes.axvspan(least, seen, color="0.94", zorder=0)
    axes.text(seen * 0.9, y - 0.9, "below half a grey level: precision wasted", ha="right",
              va="center", fontsize=8, color="0.25")
    axes.set_xscale("log")
    axes.set_xlim(least, 1800)
    axes.set_ylim(y - 0.3, -0.9)
    axes.set_yticks(ticks)
    axes.set_yticklabels(names, fontsize=8)
    axes.set_xticks([0.01, 0.1, 1, 10, 100])
    axes.set_xticklabels(["0.01", "0.1", "1", "10", "100"])
    axes.set_xlabel("mean change in grey levels where something touches the membrane\n"
                    "(time: of smoothing, for each frame; else of the light fields, once a sensor)")
    axes.grid(True, axis="x", color="0.88", linewidth=0.6)
    figure.suptitle(claim_of_scene(rows, seen), fontsize=12, fontweight="bold")
    figure.tight_layout(rect=(0, 0.015, 1, 1))
    save(figure, folder, "scene", rows)


def claim_of_scene(rows, seen):
    """The quickest choices that change less than half a grey level, and what light model changes."""
    enough = {}
    for row in sorted(rows, key=lambda r: r["median_s"]):
        if row["levels_mean"] < seen:
            enough.setdefault(row["path"][1], row["path"][2])
    words = [words.format(enough[topic].removeprefix("1:")) for topic, words in (
        ("mesh edges", "edges of {}"), ("light field's grid", "light at every {}th pixel"), ("smoothing", "{}"))
        if topic in enough]
    light = [r["levels_mean"] for r in rows if r["path"][1] == "light model"]
    claim = "Finer is not seen: " + ", ".join(words) if words else "What each choice changes in a GelTip's image"
    return claim + (f"\nanother light model changes {span_of(light, '{:.0f}'.format)} grey levels" if light else "")


def words_scene(rows, folder):
    """Each choice's change on 99 % of the pixels; bold: the quickest that keeps to one grey level."""
    rows = [r for r in rows if r["path"][0] == "scene" and r["path"][1] != "planned"]
    if not rows:
        return
    lines = ["| grey levels, 99 % of those pixels within | |", "|---|---|"]
    for topic in dict.fromkeys(r["path"][1] for r in rows):
        here = [r for r in rows if r["path"][1] == topic]
        kept = [r for r in here if r["levels_p99"] <= 1]
        enough = min(kept, key=lambda r: r["median_s"]) if kept else None
        cells = [f"**{r['path'][2]}: {r['levels_p99']:.0f}**" if r is enough else
                 f"{r['path'][2]}: {r['levels_p99']:.0f}" for r in here]
        lines.append(f"| {topic} | {', '.join(cells)} |")
    write_between(os.path.join(folder, "README.md"), "scene", lines)


def plans_of(rows):
    """The sensors that plan_sensor could plan for, and how many it was asked for."""
    rows = [r for r in rows if r["path"][:2] == ["scene", "planned"]]
    return [r for r in rows if "kept" in r], len(rows)


def claim_of_plans(plans, asked):
    """How many plans kept what they promised, and how many were as cheap as can be."""
    kept = sum(r["kept"] >= r["asked"] for r in plans)
    cheap = sum(r["dearer"] <= 1.5 for r in plans)
    lost = max((1 - r["kept"]) / (1 - r["asked"]) for r in plans)
    dearest = max(r["dearer"] for r in plans)
    return (f"Of {asked} sensors at random plan_sensor plans for {len(plans)}: {kept} keep the share asked for, "
            f"and {cheap} cost\nat most 1.5 times the cheapest choice in hindsight (the dearest {dearest:.2f} times; "
            f"at most {lost:.2f} times\nas many pixels are off as may be)")


def chart_plans(rows, folder):
    """What plans of sensors at random promised and kept, and what they cost against the cheapest."""
    plans, asked = plans_of(rows)
    if not plans:
        return
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.6, 4.2))
    least = min(min(r["asked"], r["kept"]) for r in plans) - 0.01
    left.fill_between([least, 1], [least, 1], least, color="0.92", zorder=0)
    left.plot([least, 1], [least, 1], color="0.35", linewidth=1)
    for row in plans:
        colour = "#0072B2" if row["kept"] >= row["asked"] else "#A0527F"
        left.plot(row["asked"], row["kept"], "o", color=colour, markersize=6, alpha=0.8)
    left.text(1 - 0.005, least + 0.004, "below the line: fewer than asked for", ha="right", fontsize=8, color="0.25")
    left.set_xlabel("share of the pixels asked for")
    left.set_ylabel("share kept, over 40 contacts not planned with")
    left.set_xlim(least, 1)
    left.set_ylim(least, 1.002)
    costs = sorted(r["dearer"] for r in plans)
    right.axhline(1.5, color="0.35", linestyle=(0, (4, 2)), linewidth=1)
    right.bar(range(1, len(costs) + 1), [c - 1 for c in costs], bottom=1, color="#009E73")
    right.plot(range(1, len(costs) + 1), costs, "o", color="#009E73", markersize=4)
    right.set_ylim(0.95, max(1.6, costs[-1] + 0.1))
    right.set_xlabel("sensors, the cheapest first")
    right.set_ylabel("cost over that of the cheapest in hindsight")
    for axes in (left, right):
        axes.grid(True, color="0.88", linewidth=0.6)
        axes.set_axisbelow(True)
    figure.suptitle(claim_of_plans(plans, asked), fontsize=10, fontweight="bold")
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    save(figure, folder, "scene_planned", plans)


def words_plans(rows, folder):
    """What the chart of plans says, into README.md between its marks."""
    plans, asked = plans_of(rows)
    if not plans:
        return
    longest = max(r["plan_seconds"] for r in plans)
    said = claim_of_plans(plans, asked).replace("\n", " ").replace("plan_sensor", "`plan_sensor`")
    write_between(os.path.join(folder, "README.md"), "plans", [said + ".", f"Each was planned in {longest:.1f} s at most."])


STABILITY = {"aspect": ("needles", "stretched by"), "obtuse": ("angles near 180 degrees", "sheared by"),
             "graded": ("small cells beside large", "largest width / smallest"),
             "rough": ("random heights", "height, in cells")}
# Their lines run among the others' or above the chart: they stand in the table of words_stability.
NOT_IN_STABILITY = ("Dijkstra", "heat", "CGAL heat")
ROUNDING = 1e-11  # as large as the largest relative error may be that is rounding's


def chart_stability(rows, folder):
    """Largest error against how bad the triangles are: where each method breaks."""
    rows = [r for r in rows if r["path"][0] == "stability" and "degree" in r and "mean" in r]
    if not rows:
        return
    figure, axes = plt.subplots(2, 2, figsize=(11, 7.6), sharey=True)
    figure.subplots_adjust(left=0.09, right=0.895, bottom=0.085, top=0.9, wspace=0.32, hspace=0.34)
    for place, (kind, (title, label)) in zip(axes.flat, STABILITY.items()):
        here = [r for r in rows if r["path"][1] == kind and r["path"][2] not in NOT_IN_STABILITY]
        place.set(xscale="log", yscale="log", ylim=(1e-16, 1e2), xlabel=label)
        ends = []
        for method in dict.fromkeys(r["path"][2] for r in here):
            colour, shape = style(method)
            hollow = method.startswith("CGAL")
            points = sorted((r["degree"] or 0.3, max(r.get("most", r["mean"]), 1e-16)) for r in here
                            if r["path"][2] == method)  # no shear: 0.3, on a logarithmic axis
            place.plot(*zip(*points), marker=shape, color=colour, markersize=7 if hollow else 6,
                       linewidth=0.8 if hollow else 1.5, zorder=4 if hollow else 3,
                       markerfacecolor="none" if hollow else colour,
                       markeredgecolor=colour if hollow else "white")
            ends.append((method.replace(", intrinsic Delaunay", "*"), colour, *points[-1]))
        plain_ticks(place.xaxis)
        ticks = [1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 1]
        place.set_yticks(ticks)
        place.set_yticklabels([percent(x) for x in ticks])
        place.axhspan(1e-16, ROUNDING, color="0.94", zorder=0)
        place.grid(True, which="major", color="0.9", linewidth=0.6)
        place.set_title(title.capitalize() + (" (the truth is the exact solver's)" if kind == "rough" else ""),
                        fontsize=10)
        if ends:
            label_ends(place, ends)
    figure.text(0.075, 0.006, "* on intrinsic Delaunay triangles", fontsize=8, color="0.3")
    axes[0, 0].text(0.03, 2e-12, "grey: rounding", fontsize=8, color="0.3",
                    transform=axes[0, 0].get_yaxis_transform())
    for place in axes[:, 0]:
        place.set_ylabel("largest relative error")
    exact = [r["most"] for r in rows if r["path"][2] == "exact"]
    figure.suptitle("However bad the triangles, exact distances stay at rounding: "
                    f"off by {percent(max(exact))} at most".replace("e-", "e\u2212")
                    if exact and max(exact) < ROUNDING else "Where each method breaks", fontsize=13, fontweight="bold")
    save(figure, folder, "stability", rows)


def words_stability(rows, folder):
    """A table of every method's mean and largest error, at the worst of each kind of triangles."""
    rows = [r for r in rows if r["path"][0] == "stability" and "mean" in r]
    if not rows:
        return
    kinds = [k for k in STABILITY if any(r["path"][1] == k for r in rows)]
    lines = ["| mean, largest error at the worst | " + " | ".join(STABILITY[k][0] for k in kinds) + " |",
             "|---" * (1 + len(kinds)) + "|"]
    for method in [m for m in STYLE if any(r["path"][2] == m for r in rows)]:
        cells = []
        for kind in kinds:
            here = [r for r in rows if r["path"][1:3] == [kind, method]]
            worst = [max(r.get(key, r["mean"]) for r in here) for key in ("mean", "most") if here]
            cells.append(", ".join(percent(x) for x in worst) or
                         ("the truth" if method == "exact" else ""))
        lines.append(f"| {method} | " + " | ".join(cells) + " |")
    write_between(os.path.join(folder, "README.md"), "stability", lines)


# Of the light fields those that the panels show, and those that they do not show unless somebody else names them: these
# stand in words_traced, in chart_light_fields and in the JSON.
TRACED = {"linear": ("#0072B2", "v"), "geodesic": ("#000000", "o"), "near": ("#009E73", "P"), "gel": ("#D55E00", "h")}
NOT_IN_TRACED = ("plane", "transport", "mirrored", "rectified", "radial", "linear_dimmed", "geodesic_dimmed")


def share_left(row, model, kind="levels_"):
    """What a light field is off in grey levels, as a share of what no light at all is."""
    return row[kind + model] / row[kind + "none"]


def claim_of_traced(rows, names, models, kind="levels_"):
    """Which field leaves least of the error, and whether every mark of every panel says so."""
    marks = list(dict.fromkeys((r["path"][1], r["path"][2]) for r in rows))
    left = {m: [mean(share_left(r, m, kind) for r in rows if tuple(r["path"][1:3]) == mark) for mark in marks]
            for m in models if all(kind + m in r for r in rows)}
    if not left:
        return "Light fields beside traced light"
    nearest = min(left, key=lambda m: mean(left[m]))
    is_everywhere = all(left[nearest][i] == min(of[i] for of in left.values()) for i in range(len(marks)))
    all_left = {m: percent(mean(share_left(r, m, kind) for r in rows)) for m in left}
    return (("On every sensor, in every gel " if is_everywhere and len(names) > 1 else "In the mean ") +
            f"\u201c{nearest}\u201d leaves the least error: {all_left[nearest]}" + "".join(
                f", \u201c{m}\u201d {all_left[m]}" for m in ("geodesic",) if m in left and m != nearest))


def chart_traced(rows, folder, kind="levels_", file="traced"):
    """Light fields beside traced light, a panel a sensor: the share of the error in grey levels that each leaves."""
    rows = [r for r in rows if r["path"][0] == "traced" and kind + "none" in r]
    if not rows:
        return
    models = dict(TRACED)
    for row in rows:  # fields that are not named above
        for key in row:
            if key.startswith(kind) and key[len(kind):] not in list(models) + list(NOT_IN_TRACED) + ["none"]:
                models[key[len(kind):]] = SPARE[len(models) % len(SPARE)]
    names = list(dict.fromkeys(r["path"][1] for r in rows))
    last_of = {m: r["path"][1] for m in models for r in sorted(rows, key=lambda r: names.index(r["path"][1]))
               if kind + m in r}
    figure, axes = plt.subplots(1, len(names), figsize=(max(8.5, 1.6 + 2.0 * len(names)), 4.3), sharey=True,
                                squeeze=False)
    figure.subplots_adjust(left=0.85 / figure.get_figwidth(), right=1 - 0.95 / figure.get_figwidth(), bottom=0.17,
                           top=0.76, wspace=0.12)
    figure.suptitle(claim_of_traced(rows, names, models, kind), fontsize=13, fontweight="bold")
    figure.text(0.5, 0.865, "Lower is nearer to light that is traced ray by ray. Marks: mean over the coatings, bars: "
                "from the least to the most.", fontsize=9, ha="center", color="0.25")
    drawn = []  # panels that are the last to show a field
    for place, name in zip(axes[0], names):
        here = [r for r in rows if r["path"][1] == name]
        gels = list(dict.fromkeys(r["path"][2] for r in here))
        ends = []
        for k, (model, (colour, shape)) in enumerate(models.items()):
            points = []
            for x, gel in enumerate(gels):
                shares = [100 * share_left(r, model, kind) for r in here if r["path"][2] == gel and kind + model in r]
                if shares:
                    points.append((x + 0.06 * (k - 1.5), mean(shares)))
                    place.plot([points[-1][0]] * 2, [min(shares), max(shares)], color=colour, linewidth=1.2, alpha=0.5)
            if points:
                place.plot(*zip(*points), marker=shape, color=colour, linewidth=1.4,
                           markersize=13 if shape == "*" else 7, markeredgecolor="white")
                if last_of[model] == name:
                    ends.append((model, colour, *points[-1]))
        place.set_xticks(range(len(gels)))
        place.set_xticklabels([gel.removesuffix(" mm") for gel in gels])
        place.set_xlim(-0.4, len(gels) - 0.6)
        place.set_ylim(bottom=0)
        place.set_title(name, fontsize=10)
        place.set_xlabel("gel's thickness, mm")
        place.grid(True, axis="y", color="0.9", linewidth=0.6)
        if name == names[-1] and ends:
            label_ends(place, ends)
        elif ends:
            drawn.append((place, ends))
    for place, ends in drawn:
        label_beside(place, ends)
    axes[0, 0].set_ylabel("grey levels off, % of those\nwithout any light")
    save(figure, folder, file, rows)


def chart_contacts(rows, folder):
    """The same of what balls change that are pressed in."""
    chart_traced(rows, folder, "contact_", "traced_contacts")


LIGHT_FIELDS = {"linear": "#0072B2", "plane": "#B07800", "geodesic": "#000000", "transport": "#A0527F",
                "near": "#009E73", "mirrored": "#7A4FBF", "gel": "#D55E00"}
TRACED_BESIDES = ("linear_dimmed", "geodesic_dimmed", "rectified", "radial")


def light_fields_of(rows):
    """By field: angle and grey levels beside traced light, of every case."""
    rows = [r for r in rows if r["path"][0] == "traced"]
    names = dict.fromkeys(list(LIGHT_FIELDS) + [k[6:] for r in rows for k in r if k.startswith("angle_")])
    fields = {}
    for name in names:
        here = [(r["angle_" + name], r["levels_" + name]) for r in rows
                if "angle_" + name in r and "levels_" + name in r]
        if here and name not in TRACED_BESIDES:
            fields[name] = here
    return fields, [r["levels_none"] for r in rows if "levels_none" in r]


def chart_light_fields(rows, folder):
    """Light fields by angle and by grey levels: a mark a field, bars where half of the cases lie."""
    fields, none = light_fields_of(rows)
    if not fields or not none:
        return
    figure, axes = plt.subplots(figsize=(8.2, 5.4))
    for i, (name, cases) in enumerate(fields.items()):
        colour = LIGHT_FIELDS.get(name, SPARE[i % len(SPARE)][0])
        angles, levels = (sorted(c) for c in zip(*cases))
        x, y = mean(angles), mean(levels)
        quarter = len(cases) // 4
        axes.plot([angles[quarter], angles[-1 - quarter]], [y, y], color=colour, linewidth=1.6, alpha=0.45)
        axes.plot([x, x], [levels[quarter], levels[-1 - quarter]], color=colour, linewidth=1.6, alpha=0.45)
        is_whole = len(cases) == len(none)
        axes.plot(x, y, "o", color=colour if is_whole else "white", markersize=9,
                  markeredgecolor="white" if is_whole else colour, zorder=4)
        to_left = name not in ("plane", "near")  # where no other's bars are
        axes.annotate(name if is_whole else f"{name}, in {len(cases)} of {len(none)} cases", (x, y), textcoords="offset points", xytext=(-8 if to_left else 8, 7), fontsize=11,
                      color=ink(colour), zorder=5, ha="right" if to_left else "left")
    axes.axhline(mean(none), color="0.35", linestyle=(0, (4, 2)), linewidth=1)
    axes.text(0.99, mean(none) * 1.012, "no light at all", ha="right", va="bottom", fontsize=9, color="0.25",
              transform=axes.get_yaxis_transform())
    axes.set_xlim(left=0)
    axes.set_ylim(0, 1.12 * max(mean(none), max(mean(c[1] for c in cases) for cases in fields.values())))
    axes.set_xlabel("degrees between the field and traced light (weighted by irradiance)")
    axes.set_ylabel("grey levels off where the membrane tilts by 20 degrees")
    axes.grid(True, color="0.9", linewidth=0.6)
    # (Means over other cases are not to be compared.)
    whole = {name: cases for name, cases in fields.items() if len(cases) == len(none)} or fields
    nearest = min(whole, key=lambda name: mean(c[1] for c in whole[name]))
    angle, levels = (mean(c[k] for c in whole[nearest]) for k in (0, 1))
    axes.set_title(f"Nearest to traced light comes \u201c{nearest}\u201d: {angle:.0f} degrees and "
                   f"{levels:.1f} grey levels off\n(no light at all: {mean(none):.1f})", fontsize=12, fontweight="bold")
    axes.text(0.985, 0.03, f"marks: mean of {len(none)} cases of\nsensor, gel and coating\n"
              "bars: the middle half of them", fontsize=8.5, color="0.3", ha="right", transform=axes.transAxes)
    figure.tight_layout(rect=(0, 0.02, 1, 1))
    save(figure, folder, "field_errors", [r for r in rows if r["path"][0] == "traced"])


def words_light_fields(rows, folder):
    """A table of that chart."""
    fields, none = light_fields_of(rows)
    if not fields or not none:
        return
    fields = {name: cases for name, cases in fields.items() if len(cases) == len(none)}
    lines = ["| mean of {} cases | {} |".format(len(none), " | ".join(fields)), "|---" * (1 + len(fields)) + "|",
             "| degrees off | " + " | ".join(f"{mean(c[0] for c in x):.0f}" for x in fields.values()) + " |",
             "| grey levels off (no light at all: {:.1f}) | ".format(mean(none)) +
             " | ".join(f"{mean(c[1] for c in x):.1f}" for x in fields.values()) + " |"]
    write_between(os.path.join(folder, "README.md"), "light fields", lines)


def words_traced(rows, folder):
    """What the chart of traced light says, into README.md between its marks."""
    rows = [r for r in rows if r["path"][0] == "traced"]
    if not rows or not os.path.exists(os.path.join(folder, "README.md")):
        return

    def span(values, digits=0):
        return f"{min(values):.{digits}f} to {max(values):.{digits}f}"

    def share(kind, model, of):
        return [100 * r[kind + model] / r["levels_none"] for r in of]

    four = ["linear", "plane", "geodesic", "transport"]
    lines = ["| | angle: geodesic | linear | near | gel | tilt | irradiance, 5th : 95th percentile | "
             "error in grey levels: best of four | near | mirrored | gel |",
             "|---|---|---|---|---|---|---|---|---|---|---|"]
    for name in dict.fromkeys(r["path"][1] for r in rows):
        here = [r for r in rows if r["path"][1] == name]
        best = [min(share("levels_", m, [r])[0] for m in four) for r in here]
        lines.append("| {} | {} | {} | {} | {} | {} | {} | {} % | {} % | {} % | {} % |".format(
            name, *(span([r["angle_" + m] for r in here]) for m in ("geodesic", "linear", "near", "gel")),
            span([r["tilt"] for r in here]),
            f"1 : {1 / max(r['falloff'] for r in here):.0f} to "
            f"1 : {1 / min(r['falloff'] for r in here):.0f}",
            span(best), span(share("levels_", "near", here)),
            span(share("levels_", "mirrored", here)), span(share("levels_", "gel", here))))
    flat = [r for r in rows if r["path"][1] == "flat pad"]
    curved = [r for r in rows if r["path"][1] != "flat pad"]
    nearer = {m: sum(r["angle_" + m] < r["angle_geodesic"] for r in curved) for m in
              ("linear", "rectified")}
    left = [r["levels_gel"] / min(r["levels_" + m] for m in four) for r in rows]
    if all("contact_none" in r for r in rows):
        best = min(four, key=lambda m: mean(share_left(r, m, "contact_") for r in rows))
        contacts = ("- Of balls that are pressed in, pixel by pixel: no light at all is off by "
                    f"{mean(r['contact_none'] for r in rows):.0f} grey levels in the mean, `gel_field` by "
                    f"{mean(r['contact_gel'] for r in rows):.1f}, near light by "
                    f"{mean(r['contact_near'] for r in rows):.1f}, the best of the four ({best}) by "
                    f"{mean(r['contact_' + best] for r in rows):.1f}, geodesic light by "
                    f"{mean(r['contact_geodesic'] for r in rows):.1f}. `gel_field` is the nearest of these in "
                    f"{sum(all(r['contact_gel'] < r['contact_' + m] for m in four + ['near']) for r in rows)} "
                    f"of {len(rows)} cases.")
    else:
        contacts = None
    lines += ["", "In degrees, and as shares of the error without any light.", "",
              "- On curved membranes the straight line is nearer to the light than the geodesic in "
              f"{nearer['linear']} of {len(curved)} cases; laid into the membrane in "
              f"{nearer['rectified']}: it is the tilt that makes the difference.",
              f"- Geodesic light is off by {span([r['angle_geodesic'] for r in curved])} degrees, most "
              "of it tilt: in azimuth by "
              f"{span([r['azimuth_geodesic'] for r in curved])}; the straight line, by "
              f"{span([r['azimuth_linear'] for r in curved])}.",
              "- With the traced strength at every place, direction alone leaves geodesic light "
              f"{span(share('given_', 'geodesic', rows))} % of the error, the straight line "
              f"{span(share('given_', 'linear', rows))} %, near light "
              f"{span(share('given_', 'near', rows))} %.",
              "- Without fall-off none of the four helps much over a whole curved sensor: "
              f"{span([min(share('levels_', m, [r])[0] for m in four) for r in curved])} % of the "
              f"error are left, {span([min(share('levels_', m, [r])[0] for m in four) for r in flat])}"
              " % on the flat pad.",
              f"- `gel_field` at least halves the error of the best of the four in "
              f"{sum(x <= 0.5 for x in left)} of {len(rows)}, and brings it to a quarter in "
              f"{sum(x <= 0.25 for x in left)}: {span([100 * x for x in left])} % are left. "
              "Nothing in it is fitted but the gain. It takes "
              f"{100 * max(r['seconds_gel'] / r['seconds_geodesic'] for r in rows):.0f} % of the "
              "geodesic field's time, or less.",
              "- The light is directed by "
              f"{span([r['directed'] for r in rows], 2)} (1: a single ray); brighter coatings mix it. "
              "Directions are known to "
              f"{max(r['direction_error'] for r in rows):.1f} degrees (standard error), at "
              f"{span([r['rays_a_second'] / 1e6 for r in rows], 1)} million rays a second."]
    lines += [contacts] if contacts else []
    write_between(os.path.join(folder, "README.md"), "traced", lines)


def calibrations(folder):
    """Of calibration.json: its rows by sensor, model and presses, sensors, models, and how it came about."""
    path = os.path.join(folder, "calibration.json")
    if not os.path.exists(path):
        return {}, [], [], {}
    data = read_results(path)
    rows = {tuple(row["name"].split("/")[1:]): row for row in data["benchmarks"]}
    sensors = list(dict.fromkeys(name[0] for name in rows))
    models = [name[1] for name in rows if name[0] == sensors[0] and "frame_ms" in rows[name]]
    return rows, sensors, models, data["context"]


def chart_calibration(_, folder):
    """Error on photographs that were not fitted, by the number of presses and by time."""
    rows, sensors, models, context = calibrations(folder)
    if not rows:
        return
    colours = dict(zip(sensors, ("#0072B2", "#D55E00")))
    shapes = {"table": "o", "polynomial": "s", "lights": "^"}
    figure, (by_count, by_time) = plt.subplots(1, 2, figsize=(10.2, 4.4), sharey=True)
    labels, marks = [], []
    for sensor in sensors:
        counts = sorted(int(name[2]) for name in rows if name[:2] == (sensor, "table"))
        here = [rows[sensor, "table", str(count)] for count in counts]
        shift = 1.03 if sensor == sensors[0] else 1 / 1.03  # so that no bar hides another
        by_count.errorbar([count * shift for count in counts], [r["error"] for r in here],
                          [r["spread"] for r in here], color=colours[sensor], marker="o", capsize=3, linewidth=1.4,
                          elinewidth=0.7)
        labels.append((sensor.replace("_", " "), colours[sensor], counts[-1], here[-1]["error"]))
        floor = rows[sensor, "untouched"]["error"]
        for axes in (by_count, by_time):
            axes.axhline(floor, color=colours[sensor], linestyle=(0, (4, 3)), linewidth=1)
        by_time.text(0.99, floor - 0.12, f"{sensor.replace('_', ' ')}, nothing touches it", fontsize=8, va="top", ha="right",
                     color=ink(colours[sensor]), transform=by_time.get_yaxis_transform())
        for model in models:
            row = rows.get((sensor, model, "20"))
            if row is None:
                continue
            by_time.plot(row["frame_ms"], row["error"], marker=shapes[model], linestyle="none",
                         markersize=8, color=colours[sensor], markeredgecolor="white")
            marks.append((model, colours[sensor], row["frame_ms"], row["error"]))
    by_count.set_xscale("log")
    by_count.set_xlim(0.85, 75)
    by_count.set_xticks(counts)
    by_count.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    by_count.xaxis.set_minor_formatter(NullFormatter())
    by_count.set_xlabel("presses fitted (table; bars: spread of the presses held out)")
    by_count.set_ylabel("grey levels off inside of contacts\nthat were not fitted, levelled")
    by_count.set_ylim(bottom=0)
    by_time.set_xlim(0, 1.25 * max(r.get("frame_ms", 0) for r in rows.values()))
    by_time.set_xlabel("ms a frame, every pixel computed (20 presses fitted)")
    enough = max(presses_enough(rows, sensor, counts) for sensor in sensors)
    figure.suptitle(f"{enough} presses of a ball calibrate a sensor: within a tenth of what {counts[-1]} do",
                    fontsize=13, fontweight="bold")
    figure.tight_layout(rect=(0, 0.02, 0.97, 0.99))
    for name, colour, x, y in labels:
        by_count.annotate(name, (x, y), textcoords="offset points", xytext=(8, 0), fontsize=9, color=ink(colour),
                          va="center", annotation_clip=False)
    label_beside(by_time, marks, 9)
    save(figure, folder, "calibration", [{"context": context}])


def presses_enough(rows, sensor, counts):
    """The fewest presses that come within a tenth of the most."""
    table = {count: rows[sensor, "table", str(count)]["error"] for count in counts}
    return next(count for count in counts if table[count] <= 1.1 * table[counts[-1]])


def beside_phong(rows, sensor, models):
    """How a calibrated frame's time compares with a Phong frame's of the same run, in words."""
    ratios = [row["frame_ms"] / row["phong_frame_ms"] for x in models
              if "phong_frame_ms" in (row := rows[sensor, x, "20"])]
    return f"{min(ratios):.1f} to {max(ratios):.1f} times one of Phong with three lights, " if ratios else ""


def words_calibration(_, folder):
    """What that chart says: how many presses are enough, which model, where the floor is."""
    rows, sensors, models, _ = calibrations(folder)
    if not rows:
        return
    lines = ["| grey levels off | " + " | ".join(sensors) + " |", "|---" * (1 + len(sensors)) + "|"]
    counts = sorted(int(name[2]) for name in rows if name[:2] == (sensors[0], "table"))
    for model in models:
        for count in counts if model == "table" else [20]:
            here = [rows.get((sensor, model, str(count))) for sensor in sensors]
            cells = ["{error:.1f} ± {spread:.1f}".format(**row) if row else "" for row in here]
            lines.append(f"| {model}, {count} press{'es' if count > 1 else ''} | " +
                         " | ".join(cells) + " |")
    lines.append("| untouched gel and its background | " +
                 " | ".join(f"{rows[x, 'untouched']['error']:.1f}" for x in sensors) + " |")
    lines.append("")
    for sensor in sensors:
        enough = presses_enough(rows, sensor, counts)
        ranked = sorted((x for x in models if (sensor, x, "20") in rows),
                        key=lambda x: rows[sensor, x, "20"]["error"])
        best, second = (rows[sensor, x, "20"] for x in ranked[:2])
        times = [rows[sensor, x, "20"]["frame_ms"] for x in ranked]
        floor = rows[sensor, "untouched"]["error"]
        lines.append(
            f"- {sensor}: {enough} presses come within a tenth of twenty. The model is the "
            f"{ranked[0]}, off by {best['error']:.1f}; next, {ranked[1]}, by {second['error']:.1f}."
            f" A frame takes {beside_phong(rows, sensor, ranked)}{min(times):.2f} to"
            f" {max(times):.2f} ms with any of them, as all are"
            " rendered from a table. Where nothing touches the gel its photographs differ from the"
            f" background by {floor:.1f}, noise and drift that no model knows:"
            f" {100 * floor / best['error']:.0f} % of what is left.")
    write_between(os.path.join(folder, "README.md"), "calibration", lines)


MEMBRANES = {"blur": ("#B07800", "s", "own Gaussian"), "springs": ("#009E73", "D", "springs"),
             "bulging": ("#D55E00", "o", "bulging"), "coarse layer": ("#0072B2", "v", "coarse layer"),
             "layer": ("#000000", "P", "elastic layer")}
BLUR = "Gaussian of the gel"  # the best of the blurs: the others stand in the table of words_membranes


def membranes_of(rows):
    """By gel and model, a row for each Poisson ratio."""
    groups = {}
    for row in rows:
        if row["path"][0] == "membranes":
            groups.setdefault((row["path"][1], "/".join(row["path"][3:])), []).append(row)
    return groups


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def bulging_gain(groups):
    """How much nearer the bulging membrane's normals are than those of the gel's Gaussian, and how much
    longer it takes: geometric means over all gels."""
    nearer = longer = count = 0
    for (gel, model), rows in groups.items():
        if model != "bulging/4 kernels":
            continue
        for row, blur in zip(rows, groups[gel, "blur/Gaussian of the gel"]):
            nearer += math.log(blur["normals"] / row["normals"])
            longer += math.log(row["ms"] / blur["ms"])
            count += 1
    return math.exp(nearer / count), math.exp(longer / count)


def chart_membranes(rows, folder):
    """Membrane models beside the converged elastic layer, a panel a gel: what their normals are off, and their time."""
    rows = [row for row in rows if row["path"][0] == "membranes"]
    groups = membranes_of(rows)
    if not groups:
        return
    gels = {"thin": "thin gel: 0.35 contact radii", "medium": "medium: one contact radius",
            "thick": "thick: 4 contact radii"}
    figure, axes = plt.subplots(1, 3, figsize=(12, 4.7), sharex=True, sharey=True)
    drawn = []
    for place, gel in zip(axes, gels):
        labels = []
        for family, (colour, shape, label) in MEMBRANES.items():
            points = []
            for (of, model), here in groups.items():
                of_family, _, setting = model.partition("/")
                if of == gel and of_family == family and (family != "blur" or setting == BLUR):
                    points.append((mean(r["ms"] for r in here), mean(r["normals"] for r in here)))
            if points:
                place.plot(*zip(*points), marker=shape, color=colour, markersize=9, markeredgecolor="white",
                           linewidth=1.1)
                labels.append((label, colour, *points[-1 if family == "springs" else 0]))
        place.set(xscale="log", yscale="log", title=gels[gel], xlabel="milliseconds a press, 320 x 240")
        place.title.set_fontsize(10)
        plain_ticks(place.yaxis)
        plain_ticks(place.xaxis)
        place.grid(True, color="0.88", linewidth=0.6)
        drawn.append((place, labels))
    axes[0].set_ylabel("normals: mean degrees off")
    low, high = axes[0].get_xlim()
    axes[0].set_xlim(low, 2 * high)
    nearer, longer = bulging_gain(groups)
    figure.suptitle(f"Bulging comes {nearer:.1f} times as near to the elastic layer's normals as the gel's own "
                    f"Gaussian,\nin {longer:.1f} times its time (geometric means over twelve gels)",
                    fontsize=13, fontweight="bold")
    figure.text(0.5, 0.03, "Left is faster, down is more accurate. Marks: mean over a ball, an edge, a grating and two "
                "points, and four Poisson ratios; lines join the settings of one model.", ha="center", fontsize=8)
    figure.tight_layout(rect=(0, 0.06, 1, 0.99))
    for place, labels in drawn:
        label_beside(place, labels, 9, far=True)
    save(figure, folder, "membranes", rows)


def words_membranes(rows, folder):
    """What the chart of membranes says, into README.md between its marks."""
    groups = membranes_of(rows)
    if not groups:
        return
    models = {"blur/Gaussian, sigma 5": "Gaussian of sigma 5", "blur/Gaussian of the gel": "the gel's own Gaussian",
              "blur/pyramid": "Taxim's pyramid", "blur/flat GelSight": "flat GelSight's loop",
              "springs/alone": "springs", "springs/with tension": "springs with tension",
              "bulging/4 kernels": "`BulgingMembrane`", "coarse layer/1:2": "`ElasticLayer`, every other pixel"}
    lines = ["| mean degrees off | " + " | ".join(
        f"{gel}, {row['path'][2]}" for gel in ("thin", "medium", "thick")
        for row in groups[gel, "bulging/4 kernels"]) + " | ms |", "|---" * 14 + "|"]
    for model, words in models.items():
        here = [row for gel in ("thin", "medium", "thick") for row in groups[gel, model]]
        lines.append(f"| {words} | " + " | ".join(f"{r['normals']:.2f}" for r in here) +
                     f" | {mean(r['ms'] for r in here):.1f} |")
    write_between(os.path.join(folder, "README.md"), "membranes", lines)


def write_between(path, mark, lines):
    """Replaces what stands between a document's marks, if there is one that has them."""
    if not os.path.exists(path):
        return
    with open(path) as file:
        text = file.read()
    begin, end = f"<!-- {mark}: written by charts.py -->\n", f"<!-- end of {mark} -->"
    if begin in text and end in text:
        head, rest = text.split(begin)
        with open(path, "w") as file:
            file.write(head + begin + "\n".join(lines) + "\n" + end + rest.split(end)[1])


def chart_scaling(_, folder):
    """Samples a second by cores: what one core takes, measured, and what binds many, by a model."""
    path = os.path.join(folder, "scaling.json")
    if not os.path.exists(path):
        return
    data = read_json(path)
    measured, assumed = data["measured"], data["assumed"]
    core = min(measured["samples_a_second_a_core_one_rank"], measured["samples_a_second_a_core_two_ranks"])
    cores = [10 ** (k / 50) for k in range(201)]
    dealt = assumed["samples_a_part"] / (assumed["message_us"] * 1e-6)
    opened = assumed["samples_a_part"] * assumed["files_a_second"]
    figure, axes = plt.subplots(figsize=(8.6, 4.9))
    axes.plot(cores, [core * n for n in cores], color="0.6", dashes=(4, 3))
    ends, bound = [("the cores alone", "#888888", cores[-1], core * cores[-1])], []
    for (name, bandwidth), colour in zip(assumed["file_systems"].items(), ("#D55E00", "#0072B2", "#009E73")):
        most = min(bandwidth / measured["bytes_a_sample"], dealt, opened)
        axes.plot(cores, [min(core * n, most) for n in cores], color=colour, linewidth=2)
        ends.append((name.replace(", ", ",\n").replace(" (", "\n("), colour, cores[-1], min(core * cores[-1], most)))
        if most < core * cores[-1]:
            bound.append((most / core, name.split(",")[0].split(" (")[0]))
            axes.plot([most / core], [most], "o", color=colour)
            axes.annotate(f"{most / core:,.0f} cores\n{most:,.0f} a second", (most / core, most),
                          xytext=(6, -24), textcoords="offset points", fontsize=8, color=ink(colour))
    for ranks, key in ((1, "one_rank"), (2, "two_ranks")):
        rate = ranks * measured["samples_a_second_a_core_" + key]
        axes.plot([ranks], [rate], "ks", markersize=6, zorder=4)
    axes.annotate("measured", (2, rate), xytext=(9, -9), textcoords="offset points", fontsize=9)
    axes.set(xscale="log", yscale="log", xlabel="cores (more than two: by a model)", ylabel="samples a second")
    figure.suptitle(f"A core makes {core:,.0f} samples a second" + "".join(
        f"; {name} binds from {n:,.0f} cores on" if k == 0 else ("," if k > 1 else ",\n") + f" {name} from {n:,.0f}"
        for k, (n, name) in enumerate(sorted(bound))), fontsize=11, fontweight="bold")
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    axes.grid(alpha=0.3)
    figure.tight_layout(rect=(0, 0.03, 0.83, 1))
    label_ends(axes, ends)
    figure.text(0.995, 0.003, textwrap.fill(measured.get("what", ""), 150), ha="right", va="bottom", fontsize=5.5, color="0.4")
    write_chart(figure, folder, "scaling")


def main():
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__)
        return 0
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(__file__),
                                                                "..", "results")
    matplotlib.rcParams.update({"font.size": 9, "axes.spines.top": False,
                                "axes.spines.right": False})
    if not os.path.isdir(folder):
        print(f"charts.py: there is no folder {folder}", file=sys.stderr)
        return 2
    if not glob.glob(os.path.join(folder, "*.json")):
        print(f"charts.py: there are no results (*.json) in {folder}", file=sys.stderr)
        return 2
    rows, failed = load(folder)
    charts = (chart_distances, chart_sphere, chart_certificate, chart_planner, chart_images, chart_scene, chart_plans,
              chart_stability, chart_light_fields, chart_traced, chart_contacts, chart_membranes, chart_calibration,
              chart_scaling)
    words = (words_distances, words_sphere, words_certificate, words_planner, words_images, words_scene, words_plans,
             words_stability, words_light_fields, words_traced, words_membranes, words_calibration)
    for make in words if KIND == "words" else charts + words:
        try:
            make(rows, folder)
        except Unreadable as fault:
            plt.close("all")
            failed.append(str(fault))
        except Exception as fault:  # whatever a row may hold: the others' charts are drawn all the same
            plt.close("all")
            kind, topic = make.__name__.split("_", 1)
            failed.append(f"{kind} of {topic}: {reason_of(fault)}")
    for line in dict.fromkeys(failed):
        print("not drawn:", line, file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
