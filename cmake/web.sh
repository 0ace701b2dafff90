#!/bin/sh
# A page on which one presses a finger: installs what is missing, builds it, serves it.
set -eu
cd "$(dirname "$0")/.."
test= port=8000
while [ $# -gt 0 ]; do
  case $1 in
    -h | --help)
      cat <<'HELP'
sh cmake/web.sh [--port 8000]  builds the page into build/web/page and serves it on this machine
sh cmake/web.sh --test         builds it and tests it in Chromium; pictures go to build/web/pictures
HELP
      exit 0
      ;;
    --test) test=yes ;;
    --port) port=$2 && shift ;;
    *) echo "web.sh: what is $1?" >&2 && exit 2 ;;
  esac
  shift
done

sh cmake/writable.sh build/web
more=
# Node of another origin brings an npm of its own, beside which Debian's cannot be.
command -v node >/dev/null 2>&1 || more="$more nodejs"
command -v npm >/dev/null 2>&1 || more="$more npm"
[ -z "$test" ] || more="$more g++ chromium?"
# shellcheck disable=SC2086 # one word a package
sh cmake/dependencies.sh make cmake emscripten libeigen3-dev $more

jobs=$(getconf _NPROCESSORS_ONLN)
launcher=$(command -v ccache >/dev/null 2>&1 && echo -DCMAKE_CXX_COMPILER_LAUNCHER=ccache || true)
mkdir -p build
# shellcheck disable=SC2086 # nothing where there is no ccache
emcmake cmake -S examples/web -B build/web/wasm $launcher >build/web.log 2>&1 ||
  { cat build/web.log && exit 1; }
cmake --build build/web/wasm -j "$jobs"

mkdir -p build/web/npm
cp examples/web/package.json build/web/npm/
if [ ! -d build/web/npm/node_modules/playwright-core ] || [ ! -d build/web/npm/node_modules/three ]; then
  npm install --prefix build/web/npm --no-audit --no-fund --ignore-scripts --no-package-lock
fi

page=build/web/page
rm -rf "$page"
mkdir -p "$page/three"
cp examples/web/index.html examples/web/style.css examples/web/*.js "$page/"
rm "$page/serve.js" "$page/browser_test.js"
cp build/web/wasm/page.wasm "$page/"
three=build/web/npm/node_modules/three
cp $three/build/three.module.js $three/build/three.core.js $three/LICENSE "$page/three/"

size=$(cat "$page"/*.js "$page/page.wasm" | gzip -9 | wc -c)
echo "Its code without three.js is $((size / 1000)) kB, gzipped."
if [ "$size" -gt 250000 ]; then
  echo "That is more than 250 kB." >&2
  exit 1
fi

if [ -n "$test" ]; then
  # shellcheck disable=SC2086
  cmake -S examples/web -B build/web/native $launcher -DCMAKE_CXX_FLAGS_RELEASE=-O1 >build/web.log
  cmake --build build/web/native -j "$jobs"
  exec node examples/web/browser_test.js build/web
fi
exec node examples/web/serve.js "$page" "$port"
