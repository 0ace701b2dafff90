#!/bin/sh
# From a fresh clone to tactile images: installs what is missing, builds the demo, runs it.
# Options go to the demo; `sh cmake/demo.sh --help` lists them. `sh cmake/demo.sh bullet` lets things
# fall onto the half-silvered sensor instead, in the Bullet physics engine; `sh cmake/demo.sh calibrate
# --fit DIR --test DIR --out DIR` fits a sensor of your own to photographs of a ball.
set -eu
cd "$(dirname "$0")/.."
demo=geltip
more=
if [ "${1:-}" = bullet ]; then
  demo=bullet
  more=libbullet-dev
  shift
fi
if [ "${1:-}" = calibrate ]; then
  demo=calibrate
  shift
fi
# shellcheck disable=SC2086 # one word a package
sh cmake/dependencies.sh g++ make cmake libeigen3-dev libopenmesh-dev libstb-dev libcli11-dev \
  libcairo2-dev pkg-config fonts-dejavu-core $more
cmake --preset demo
cmake --build --preset demo --target $demo
exec build/demo/examples/$demo "$@"
