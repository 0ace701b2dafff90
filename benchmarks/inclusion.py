#!/usr/bin/env python3
"""What it costs to include each public header: python3 benchmarks/inclusion.py [--compiler g++]

Seconds of processor time and peak memory to parse a file that includes nothing else, the median of
several turns over all headers. Eigen/Core, which nearly all need, is the yardstick.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = ROOT / "include"


def headers():
    yield "Eigen/Core"
    for path in sorted(INCLUDE.rglob("*.hpp")):
        name = str(path.relative_to(INCLUDE))
        opt_in = "/io/" in name or name == "gelight/mesh/cholmod.hpp" or (
            name.startswith("gelight/views/") and path.stem in ("cgal", "opencv", "openmesh"))
        if name.count("/") < 3 and not opt_in:
            yield name


def parse(compiler, eigen, header):
    """Seconds and megabytes of one run of the compiler."""
    with tempfile.NamedTemporaryFile("w", suffix=".cpp") as source:
        source.write(f"#include <{header}>\n")
        source.flush()
        child = subprocess.Popen([compiler, "-std=c++20", "-fsyntax-only", "-I", INCLUDE,
                                  "-isystem", eigen, source.name])
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            raise SystemExit(f"{header} does not compile alone")
        return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--compiler", default="g++")
    options.add_argument("--eigen", default="/usr/include/eigen3")
    options.add_argument("--turns", type=int, default=5)
    options.add_argument("--out", default=ROOT / "benchmarks/results/inclusion.json")
    given = options.parse_args()

    runs = {header: [] for header in headers()}
    for _ in range(given.turns):
        for header in runs:
            runs[header].append(parse(given.compiler, given.eigen, header))
    table = {header: {"seconds": round(statistics.median(s for s, _ in r), 2),
                      "megabytes": round(statistics.median(m for _, m in r))}
             for header, r in runs.items()}
    version = subprocess.run([given.compiler, "--version"], capture_output=True, text=True)
    result = {"compiler": version.stdout.splitlines()[0], "turns": given.turns, "headers": table}
    pathlib.Path(given.out).write_text(json.dumps(result, indent=1) + "\n")
    eigen = table["Eigen/Core"]["seconds"]
    for header, cost in table.items():
        print(f"{header:45}{cost['seconds']:6.2f} s  {cost['seconds'] - eigen:+6.2f} s"
              f"{cost['megabytes']:6} MB")


if __name__ == "__main__":
    main()
