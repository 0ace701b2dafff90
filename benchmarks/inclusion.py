#!/usr/bin/env python3
"""What it costs to include gelight, and to use it: python3 benchmarks/inclusion.py

Seconds of processor time (user) and peak memory, the median of several turns over all, so that what
slows the machine down slows all alike. Eigen/Core, which nearly all need, is the yardstick: what
counts are the ratios to it. Headers are parsed only; programs are compiled without optimisation and
at -O2, by each compiler, with GELIGHT_COMPILED, which leaves most of it to gelight.cpp, and with
gelight.hpp precompiled besides.
"""

import argparse
import json
import os
import pathlib
import re
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = ROOT / "include"

MESH = """#include <gelight/gelight.hpp>
int main() {
  const std::vector<std::array<double, 3>> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<std::array<int, 3>> faces{{0, 1, 2}};
  const gelight::MeshView<double> mesh(positions, faces);
  return gelight::SOLVER(mesh).distance(0)[1] > 0 ? 0 : 1;
}
"""


def readme():
    """The README's program, as it stands there."""
    return re.search(r"```cpp\n(.*?)```", (ROOT / "README.md").read_text(), re.S)[1]


def programs():
    yield "Eigen/Core", "#include <Eigen/Core>\nint main() {}\n"
    yield "gelight.hpp", "#include <gelight/gelight.hpp>\nint main() {}\n"
    yield "one fast marching solve", MESH.replace("SOLVER", "FastMarchingSolver")
    yield "one exact solve", MESH.replace("SOLVER", "ExactSolver")
    yield "the README's example", readme()


def headers():
    yield "Eigen/Core"
    for path in sorted(INCLUDE.rglob("*.hpp")):
        name = str(path.relative_to(INCLUDE))
        opt_in = "/io/" in name or name == "gelight/mesh/cholmod.hpp" or (
            name.startswith("gelight/views/") and path.stem in ("cgal", "opencv", "openmesh"))
        if name.count("/") < 3 and not opt_in:
            yield name


def command(compiler, folders, flags):
    system = [flag for folder in folders for flag in ("-isystem", folder)]
    return [compiler, "-std=c++20", *flags, "-I", INCLUDE, *system]


def precompile(compiler, folders, flags, folder):
    """A header in that folder that includes all of gelight, beside what it is precompiled to."""
    header = folder / "all.hpp"
    header.write_text("#include <gelight/gelight.hpp>\n")
    subprocess.run([*command(compiler, folders, flags), "-x", "c++-header", header,
                    "-o", f"{header}.{'pch' if 'clang' in compiler else 'gch'}"], check=True)
    return header


def commit():
    """The commit that is measured, with a plus where files differ from it."""
    def git(*words):
        return subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True).stdout
    changed = git("status", "--porcelain", "--untracked-files=no").strip()
    return git("rev-parse", "--short", "HEAD").strip() + ("+" if changed else "")


def compile_once(compiler, folders, text, flags):
    """Seconds and megabytes of one run of the compiler."""
    with tempfile.NamedTemporaryFile("w", suffix=".cpp") as source:
        source.write(text)
        source.flush()
        child = subprocess.Popen([*command(compiler, folders, flags),
                                  "-c", source.name, "-o", os.devnull])
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            raise SystemExit(f"does not compile:\n{text}")
        return used.ru_utime, used.ru_maxrss / 1024


def measure(jobs, turns, folders):
    """Of named jobs, each a compiler, a text and flags: medians of interleaved turns."""
    runs = {name: [] for name in jobs}
    for _ in range(turns):
        for name, (compiler, text, flags) in jobs.items():
            runs[name].append(compile_once(compiler, folders, text, flags))
    return {name: {"seconds": round(statistics.median(s for s, _ in r), 2),
                   "megabytes": round(statistics.median(m for _, m in r))}
            for name, r in runs.items()}


def show(title, table):
    print(f"\n{title}")
    yardstick = table["Eigen/Core"]["seconds"]
    for name, cost in table.items():
        cost["ratio"] = round(cost["seconds"] / yardstick, 2)
        print(f"{name:45}{cost['seconds']:7.2f} s  x{cost['ratio']:6.2f}{cost['megabytes']:6} MB")


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--compilers", nargs="+", default=["g++", "clang++-14"])
    options.add_argument("--eigen", default="/usr/include/eigen3")
    options.add_argument("--stb", default="/usr/include/stb", help="for the README's example")
    options.add_argument("--turns", type=int, default=5)
    options.add_argument("--only", choices=["headers", "programs"])
    options.add_argument("--out", default=ROOT / "benchmarks/results/inclusion.json")
    given = options.parse_args()

    folders = (given.eigen, given.stb)
    result = {"commit": commit(), "turns": given.turns, "compilers": {}}
    for compiler in given.compilers:
        version = subprocess.run([compiler, "--version"], capture_output=True, text=True)
        tables = {}
        if given.only != "programs":
            tables["headers"] = measure(
                {h: (compiler, f"#include <{h}>\n", ["-fsyntax-only"]) for h in headers()},
                given.turns, folders)
        if given.only != "headers":
            compiled = ["-O2", "-DGELIGHT_COMPILED"]
            for flags in (["-O0"], ["-O2"], compiled):
                tables[" ".join(flags)] = measure(
                    {name: (compiler, text, flags) for name, text in programs()},
                    given.turns, folders)
            with tempfile.TemporaryDirectory() as folder:
                header = precompile(compiler, folders, compiled, pathlib.Path(folder))
                tables[" ".join(compiled) + " precompiled"] = measure(
                    {name: (compiler, text, compiled + (["-include", header] if own else []))
                     for own, (name, text) in enumerate(programs())},
                    given.turns, folders)
        for title, table in tables.items():
            show(f"{compiler} {title}", table)
        result["compilers"][version.stdout.splitlines()[0]] = tables
    pathlib.Path(given.out).write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
