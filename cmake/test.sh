#!/bin/sh
# Installs what is missing, builds every test and runs it.
# Options go to CTest: `sh cmake/test.sh -R exact` runs the tests of the exact solver alone.
set -eu
case ${1:-} in
  -h | --help) sed -n '2,3s/^# //p' "$0" && exit 0 ;;
esac
cd "$(dirname "$0")/.."
sh cmake/writable.sh build/test
jobs=$(getconf _NPROCESSORS_ONLN)
sh cmake/dependencies.sh g++ make cmake libeigen3-dev libopenmesh-dev libstb-dev libcli11-dev \
  libcairo2-dev pkg-config fonts-dejavu-core doctest-dev libbullet-dev libwebp-dev \
  "libmujoco-dev?"
cmake --preset test
cmake --build --preset test -j "$jobs"
exec ctest --preset test -j "$jobs" "$@"
