#!/bin/sh
# Installs what is missing, builds the Python module, runs its tests and tells where it is.
# Options go to CMake: `sh cmake/python.sh -DGELIGHT_NATIVE=ON` builds it for this processor.
# PYTHON names another interpreter than the system's; it needs NumPy and pytest.
set -eu
case ${1:-} in
  -h | --help) sed -n '2,4s/^# //p' "$0" && exit 0 ;;
esac
cd "$(dirname "$0")/.."
sh cmake/writable.sh build/python
sh cmake/dependencies.sh g++ make cmake libeigen3-dev pybind11-dev python3-dev python3-numpy \
  python3-pytest libembree-dev? libstb-dev?
python=${PYTHON:-/usr/bin/python3}
command -v "$python" >/dev/null || python=python3
cmake --preset python -DPython_EXECUTABLE="$(command -v "$python")" "$@"
cmake --build --preset python -j "$(getconf _NPROCESSORS_ONLN)" --target gelight_python
module=$PWD/build/python/examples/python
PYTHONPATH=$module "$python" -m pytest -q -p no:cacheprovider examples/python/tests
echo
echo "The module is in $module; to use it:"
echo "  export PYTHONPATH=$module"
