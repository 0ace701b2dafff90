#!/bin/sh
# Builds and runs every lesson, and makes the pictures of examples/README.md anew.
set -eu
if [ $# -gt 0 ]; then
  case $1 in
    -h | --help) echo "sh cmake/lessons.sh builds and runs every lesson; pictures go to examples/pictures" ;;
    *) echo "lessons.sh: what is $1? It takes nothing" >&2 && exit 2 ;;
  esac
  exit 0
fi
cd "$(dirname "$0")/.."
sh cmake/writable.sh build/demo out examples/pictures
sh cmake/dependencies.sh g++ make cmake libeigen3-dev libopenmesh-dev libstb-dev libcli11-dev \
  libcairo2-dev pkg-config libwebp-dev libembree-dev fonts-dejavu-core pngquant
cmake --preset demo
cmake --build --preset demo -j "$(getconf _NPROCESSORS_ONLN)" --target lessons
lessons=$(sed -n 's/^\*\*\[.*(\([a-z_]*\)\.cpp).*/\1/p' examples/README.md)
for lesson in $lessons; do
  echo "== $lesson"
  "build/demo/examples/$lesson" out
  if [ -f "out/$lesson.webp" ]; then
    cp "out/$lesson.webp" examples/pictures
    continue
  fi
  picture=examples/pictures/$lesson.png
  pngquant --force --output "$picture" 64 "out/$lesson.png" 2>/dev/null || cp "out/$lesson.png" "$picture"
done
