#!/usr/bin/env python3
"""charts.py draws methods and meshes that it does not know, ends with a word, never a stack trace, and the words of
results/README.md are those that it writes of the results beside it.

Ends with 77 where matplotlib is absent.
"""
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile

CHARTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "charts.py")


def draw(files):
    """Exit code, what it says, and its charts' text by name, for files' contents by name."""
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            text = content if isinstance(content, (str, bytes)) else json.dumps(content)
            with open(os.path.join(folder, name), "wb") as file:
                file.write(text.encode() if isinstance(text, str) else text)
        done = subprocess.run([sys.executable, CHARTS, folder, "svg"], capture_output=True, text=True)
        charts = {}
        for name in os.listdir(folder):
            if name.endswith(".svg"):
                with open(os.path.join(folder, name)) as file:
                    charts[name[:-4]] = file.read()
        return done.returncode, done.stderr, charts


def check(holds, what):
    if not holds:
        sys.exit(f"charts_test.py: {what}")


def words_of(folder):
    """A folder's README.md once charts.py has written its words."""
    done = subprocess.run([sys.executable, CHARTS, folder, "words"], capture_output=True, text=True)
    check(done.returncode == 0, f"words end with {done.returncode}: {done.stderr}")
    with open(os.path.join(folder, "README.md")) as file:
        return file.read()


def check_words():
    """No figure in the words has another source than the results."""
    results = os.path.join(os.path.dirname(CHARTS), "..", "results")
    with open(os.path.join(results, "README.md")) as file:
        words = file.read()
    with tempfile.TemporaryDirectory() as folder:
        copied = shutil.copytree(results, os.path.join(folder, "results"), ignore=shutil.ignore_patterns("*.png"))
        check(words_of(copied) == words, "results/README.md is not what charts.py makes of the results")
        # Other results, other words: the dearest plan now takes three times as long.
        path = os.path.join(copied, "pareto.json")
        with open(path) as file:
            data = json.load(file)
        plan = next(row for row in data["benchmarks"] if row["name"].startswith("plan/sphere/expected"))
        plan["ratio"] = 3.0
        with open(path, "w") as file:
            json.dump(data, file)
        check("3.00 times" in words_of(copied), "the planner's words are not from its results")


def check_foreign():
    """Others' files stay as they are, and their methods are not on our front, whatever they say of themselves."""
    figures = {"run_type": "iteration", "time_unit": "ms", "iterations": 1}
    names = ["distance/m.obj/exact/default", "distance/m.obj/mine/1", "distance/m.obj/exact/mine"]
    rows = [dict(figures, name=name, run_name=name, real_time=time, mean=error)
            for name, time, error in zip(names, (90.0, 2.0, 3.0), (1e-3, 1e-5, 1e-5))]
    ours = {"context": {"executable": "build/pareto_benchmark", "cpu": "toy cpu"}, "benchmarks": rows[:1]}
    theirs = {"context": {"executable": "./mine", "note": "dear"}, "benchmarks": rows[1:]}
    with tempfile.TemporaryDirectory() as folder:
        def path(name):
            return os.path.join(folder, name)
        marks = "<!-- distances: written by charts.py -->\n<!-- end of distances -->"
        for name, content in (("pareto_tea.json", json.dumps(ours)), ("pareto_mine.json", json.dumps(theirs)),
                              ("README.md", marks)):
            with open(path(name), "w") as file:
                file.write(content)
        for _ in range(2):  # the second time ours is the shortened file
            words = words_of(folder)
            check("exact on 1" in words and "mine" not in words, f"others are on our front: {words}")
            with open(path("pareto_mine.json")) as file:
                check(json.load(file) == theirs, "another's file is rewritten")
        done = subprocess.run([sys.executable, CHARTS, folder, "svg"], capture_output=True, text=True)
        check(done.returncode == 0, f"others' files end with {done.returncode}: {done.stderr}")
        with open(path("distance_query.svg")) as file:
            chart = file.read()
        for text in ("pareto_mine.json, machine unknown; toy cpu", "exact (pareto_mine.json)"):
            check(text in chart, f"{text} is not in the chart")
        sys.argv[1:] = []
        spec = importlib.util.spec_from_file_location("charts", CHARTS)
        charts = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(charts)
        loaded, _ = charts.load(folder)
        _, axes = charts.plt.subplots()
        charts.draw_mesh(axes, loaded, "mean", lambda row: row["median_s"], 0)
        grey = [line for line in axes.lines if line.get_color() == "0.8"]
        check(len(grey) == 1 and min(grey[0].get_xdata()) > 80, "the grey front has a point of others")


def check_claims():
    """A chart's title says what its rows do, shares are in per cent alone, and what is not known is not at its foot."""
    def stability(most):
        return {"name": "stability/aspect/exact/10", "real_time": 1.0, "degree": 10, "mean": most / 2, "most": most}

    def traced(sensor, gel, near, thick=1):
        return {"name": f"traced/{sensor}/{thick} mm/albedo 0.5", "levels_none": 10, "levels_gel": gel, "levels_near": near}

    rows = [{"name": f"distance/tiny.obj/toy method/{k}", "real_time": 1.0, "time_unit": "ms", "mean": 10.0 ** -k} for k in range(1, 8)]
    context = {"commit": "unknown", "cpu": "toy cpu", "executable": "stability_benchmark"}
    for most, is_rounding in ((3e-13, True), (0.1, False)):
        _, _, charts = draw({"pareto_toy.json": {"context": context, "benchmarks": rows + [stability(most)]}})
        check(("stay at rounding" in charts["stability"]) == is_rounding, f"exact distances {most} off are misjudged")
        for name, chart in charts.items():
            check("1e-6" not in chart and ("stability" not in name or "1e-7 %" in chart), f"{name} changes its unit")
            check("commit unknown" not in chart and "toy cpu" in chart, f"{name}'s foot")
    for near, is_everywhere in ((5, True), (1, False)):
        _, _, charts = draw({"traced_toy.json": {
            "context": context, "benchmarks": [traced("pad", 2, 6), traced("dome", 2, near)]}})
        check(("On every sensor" in charts["traced"]) == is_everywhere, f"{near} beside 2 is misjudged")
        _, _, charts = draw({"traced_toy.json": {"context": context, "benchmarks": [
            traced("pad", 2, 6), traced("pad", 2, near, 5), traced("dome", 2, 6)]}})
        check(("On every sensor" in charts["traced"]) == is_everywhere, f"{near} beside 2 in one gel is misjudged")


def check_part_of_the_cases():
    """A light field that was traced beside few cases is not the nearest of all, and no case counts twice."""
    def case(sensor, **fields):
        return {"name": f"traced/{sensor}/1 mm/albedo 0.5", "levels_none": 10, **fields}

    ours = {"context": {"program": "traced_embree"}, "benchmarks": [
        case("pad", angle_gel=10, levels_gel=3), case("dome", angle_gel=12, levels_gel=5)]}
    toy = {"context": {"program": "traced_embree"}, "benchmarks": [
        case("pad", angle_gel=9, levels_gel=2, angle_toy=1, levels_toy=1)]}
    _, _, charts = draw({"traced_embree.json": ours, "traced_toy.json": toy})
    chart = charts["field_errors"]
    check("mean of 2 cases" in chart, "a case in two files counts twice")
    check("toy, in 1 of 2 cases" in chart, "nothing says that the toy has one case of two")
    check("4.0 grey levels" in chart, "the field of one case is taken for the nearest, or a mean is of both files")
    check("toy" in charts["traced"], "the toy has no name where it is drawn")


def check_broken():
    """A file that is no JSON, or another one than is wanted, is told by one plain line with its name and place."""
    good = {"context": {}, "benchmarks": []}
    for name in ("pareto_a.json", "calibration.json", "scaling.json", "membranes.json"):
        for content, says in (('{\n"context": {},\n', "line 3"), ("", "line 1"), ("[1]", "line 1"), ("[" * 100000, "deep"),
                              (b"\xff\xfe", "UTF-8"), ({}, "no \""), (dict(good, context=1, measured=1, assumed=1), "kind")):
            if name in ("membranes.json", "scaling.json") and says in ("line 1", "deep", "UTF-8"):
                continue  # read as the others are
            if name != "scaling.json" and says == "kind":
                says = "context"
            code, words, _ = draw({name: content})
            check(code == 1 and says in words, f"{name} of {str(content)[:20]} ends with {code}: {words[:500]}")
            check(len(words.splitlines()) == 1, f"{name} of {str(content)[:20]}: not one line: {words[:900]}")
            for repr_of in ("Error", "Traceback", "!r", "None"):
                check(repr_of not in words, f"{name}: {words[:500]}")


def main():
    if importlib.util.find_spec("matplotlib") is None:
        print("skipped: no matplotlib")
        sys.exit(77)
    check_words()
    check_foreign()
    check_claims()
    check_part_of_the_cases()
    row = {"real_time": 3.0, "time_unit": "ms", "mean": 0.002}
    rows = [dict(row, name="distance/tiny.obj/toy method/strong"),
            dict(row, name="distance/tiny.obj/foreign library/1.0", mean=0.01),
            dict(row, name="stability/aspect/toy method/10", degree=10),
            dict(name="plan/tiny.obj/expected/0.1", tolerance=0.1, ratio=1.2)]
    light = {"name": "traced/finger/1 mm/albedo 0.5", "levels_none": 9, "angle_toy light": 20,
             "given_toy light": 3, "levels_toy light": 4}
    code, words, charts = draw({"pareto_toy.json": {"context": {}, "benchmarks": rows},
                                "traced_toy.json": {"context": {}, "benchmarks": [light]}})
    check(code == 0 and not words, f"own rows end with {code}: {words}")
    for chart in ("distance_query", "distance_first"):
        for name in ("toy method", "foreign library", "tiny.obj"):
            check(name in charts.get(chart, ""), f"{name} is not in {chart}")
    check("toy method" in charts.get("stability", ""), "the toy method is not in stability")
    for chart in ("traced", "field_errors"):
        check("toy light" in charts.get(chart, ""), f"the toy light is not in {chart}")
    check("tiny.obj" in charts.get("planner", ""), "the mesh is not in planner")

    done = subprocess.run([sys.executable, CHARTS, "--help"], capture_output=True, text=True)
    check(done.returncode == 0 and "RESULTS" in done.stdout, f"--help ends with {done.returncode}: {done.stderr}")

    code, words, charts = draw({})
    check(code != 0 and "no results" in words and "Traceback" not in words, f"an empty folder ends with {code}: {words}")

    check_broken()

    code, words, charts = draw({
        "pareto_a.json": "{", "pareto_b.json": [1], "stability_c.json": {
            "context": {}, "benchmarks": [dict(row, name="distance/tiny.obj"),
                                          dict(row, name="scene/no/levels")]}})
    check(code == 1, f"bad files end with {code}")
    for name in ("pareto_a.json", "pareto_b.json", "distance/tiny.obj", "levels_mean"):
        check(name in words, f"{name} is not told of: {words}")
    check("Traceback" not in words, words)

    for wrong, says in (({"real_time": 3.0}, "no error"), ({"mean": 0.1}, "no time"),
                        ({"real_time": 3.0, "mean": -0.1}, "below 0")):
        code, words, charts = draw({"pareto_a.json": {
            "context": {}, "benchmarks": [dict(wrong, name="distance/tiny.obj/toy/1")]}})
        check(code == 1 and says in words and "tiny.obj/toy" in words, f"{wrong} ends with {code}: {words}")
        check("distance_query" not in charts and "Warning" not in words, f"{wrong} is drawn: {words}")


if __name__ == "__main__":
    main()
