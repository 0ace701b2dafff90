#!/bin/sh
# Measures speed against accuracy and draws the charts of benchmarks/results anew.
# --quick: less patience with every number; all of it then takes about a minute and a half once it
# is built.
# --to FOLDER: elsewhere than into benchmarks/results.  --mesh FILE: with a mesh of one's own.
set -eu
here=$PWD
cd "$(dirname "$0")/.."
patience=0.3 to=benchmarks/results quick='' mesh=
while [ $# -gt 0 ]; do
  case $1 in
    --quick) patience=0.02 quick=--quick ;;
    -h | --help)
      echo "sh cmake/charts.sh [--quick] [--to FOLDER] [--mesh FILE]"
      sed -n '2,5s/^# //p' cmake/charts.sh
      exit 0
      ;;
    --to)
      [ -n "${2:-}" ] || { echo "charts.sh: --to wants a folder" >&2 && exit 2; }
      to=$(cd "$here" && readlink -m "$2") && shift
      ;;
    --mesh)
      [ -n "${2:-}" ] || { echo "charts.sh: --mesh wants a file" >&2 && exit 2; }
      file=$(cd "$here" && readlink -f "${2:-}" || true)
      [ -f "$file" ] || { echo "charts.sh: there is no file ${2:-}" >&2 && exit 2; }
      mesh=--mesh=$file && shift
      ;;
    *) echo "charts.sh: what is $1?" >&2 && exit 2 ;;
  esac
  shift
done
sh cmake/writable.sh build/benchmark
mkdir -p "$to" 2>/dev/null && [ -w "$to" ] || { echo "charts.sh: $to cannot be written to" >&2 && exit 1; }
sh cmake/dependencies.sh g++ make cmake libeigen3-dev libopenmesh-dev libbenchmark-dev libcgal-dev \
  libembree-dev python3-matplotlib pngquant
programs="pareto_benchmark pareto_image_benchmark scene_benchmark stability_benchmark
  pareto_cgal_benchmark stability_cgal_benchmark traced_embree_benchmark"
cmake --preset benchmark >/dev/null
# CGAL's programs are left out where CGAL is absent, and so is Embree's.
known=$(cmake --build --preset benchmark --target help)
for program in $programs; do
  echo "$known" | grep -qw "$program" || programs=$(echo "$programs" | sed "s/$program//")
done
# shellcheck disable=SC2086 # one word a program
cmake --build --preset benchmark -j "$(getconf _NPROCESSORS_ONLN)" --target $programs
commit=$(git describe --always --dirty 2>/dev/null || echo unknown)
for program in $programs; do
  echo "$program"
  set --
  if [ "$program" = pareto_benchmark ]; then
    set -- ${quick:+"$quick"} ${mesh:+"$mesh"}
  elif [ "$program" = scene_benchmark ]; then
    set -- --benchmark_filter=-planned
  fi
  "build/benchmark/benchmarks/$program" "$@" --benchmark_min_time=$patience \
    --benchmark_context=commit="$commit" --benchmark_out="$to/${program%_benchmark}.json" \
    --benchmark_out_format=json >/dev/null || [ $? -eq 3 ]  # a row is wrong: charts.py tells which
done
build/benchmark/benchmarks/scene_benchmark --benchmark_filter=planned --benchmark_context=commit="$commit" \
  --benchmark_out="$to/scene_planned.json" --benchmark_out_format=json >/dev/null || [ $? -eq 3 ]
# Not with the others' options: it prints its JSON.
cmake --build --preset benchmark --target membranes
build/benchmark/benchmarks/membranes "$commit" >"$to/membranes.json"
python=$([ -x /usr/bin/python3 ] && echo /usr/bin/python3 || echo python3)
exec "$python" benchmarks/plot/charts.py "$to"
