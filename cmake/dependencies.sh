#!/bin/sh
# Installs what is missing of the named Debian packages: sh cmake/dependencies.sh PACKAGE...
# One with a question mark behind its name is left out where apt does not know it.
# Where there is no apt it says what to install, and goes on: CMake then finds it or names it.
set -eu
case ${1-} in
  -h | --help) sed -n '2,4s/^# //p' "$0" && exit 0 ;;
esac

# What apt's names stand for, for those who install it another way.
describe() {
  case $1 in
    g++) echo "a C++20 compiler (g++ 12 or clang++ 14, or later)" ;;
    make) echo "make" ;;
    cmake) echo "CMake 3.22 or later" ;;
    libeigen3-dev) echo "Eigen 3.4" ;;
    libopenmesh-dev) echo "OpenMesh 9" ;;
    libcli11-dev) echo "CLI11 2" ;;
    libcairo2-dev) echo "cairo 1.16" ;;
    fonts-dejavu-core) echo "a sans-serif font" ;;
    doctest-dev) echo "doctest 2.4" ;;
    libstb-dev) echo "stb (stb_image.h, stb_image_write.h)" ;;
    libbullet-dev) echo "Bullet 3" ;;
    libmujoco-dev) echo "MuJoCo 2.2" ;;
    libwebp-dev) echo "libwebp 1.2" ;;
    libbenchmark-dev) echo "Google Benchmark 1.7" ;;
    libcgal-dev) echo "CGAL 5.5" ;;
    libembree-dev) echo "Embree 3" ;;
    libfftw3-dev) echo "FFTW 3.3" ;;
    libopenmpi-dev) echo "Open MPI 4 or another MPI" ;;
    libhdf5-dev) echo "HDF5 1.10.3" ;;
    nlohmann-json3-dev) echo "nlohmann's JSON 3.11" ;;
    libisal-dev) echo "ISA-L 2.30" ;;
    python3-h5py) echo "Python 3 with h5py 3" ;;
    libsuitesparse-dev) echo "SuiteSparse 5.12 (CHOLMOD)" ;;
    doxygen) echo "Doxygen 1.9" ;;
    emscripten) echo "Emscripten 3.1.6" ;;
    nodejs) echo "Node.js 18" ;;
    chromium) echo "Chromium" ;;
    pngquant) echo "pngquant 2" ;;
    python3-matplotlib) echo "Python 3 with matplotlib 3.6" ;;
    pybind11-dev) echo "pybind11 2.10" ;;
    python3-dev) echo "Python 3.9 or later, with its headers" ;;
    python3-numpy) echo "Python 3 with NumPy 1.24" ;;
    python3-pytest) echo "Python 3 with pytest 7" ;;
    *) echo "$1" ;;
  esac
}

if ! command -v apt-get >/dev/null 2>&1 || ! command -v dpkg-query >/dev/null 2>&1; then
  echo "This system has no apt-get. Please see that these are installed:"
  for package in "$@"; do echo "  - $(describe "${package%\?}")"; done
  echo "Going on with what is there."
  exit 0
fi

missing=
for package in "$@"; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "${package%\?}" 2>/dev/null || true)
  [ "$status" = installed ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null 2>&1; then
    echo "Not root and no sudo. As root, please run: apt-get install$(echo "$missing" | tr -d '?')" >&2
    exit 1
  fi
  as_root=sudo
fi
$as_root apt-get update -qq
known=
for package in $missing; do
  name=${package%\?}
  if [ "$name" = "$package" ] || apt-cache show "$name" >/dev/null 2>&1; then
    known="$known $name"
  else
    echo "Left out, for apt does not know it: $name"
  fi
done
[ -n "$known" ] || exit 0
echo "Installing:$known"
# shellcheck disable=SC2086 # one word a package
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $known
