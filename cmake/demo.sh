#!/bin/sh
# From a fresh clone to tactile images: installs what is missing, builds the demo, runs it.
# Options go to the demo; `sh cmake/demo.sh --help` lists them.
set -eu
cd "$(dirname "$0")/.."
sh cmake/dependencies.sh g++ make cmake libeigen3-dev libopenmesh-dev libstb-dev libcli11-dev \
  libcairo2-dev pkg-config fonts-dejavu-core
cmake --preset demo
cmake --build --preset demo --target geltip
exec build/demo/examples/geltip "$@"
