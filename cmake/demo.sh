#!/bin/sh
# From a fresh clone to tactile images: installs what is missing, builds the demo, runs it.
# Options go to the demo; `sh cmake/demo.sh --help` lists them at once, and installs nothing.
# `sh cmake/demo.sh bullet` lets things fall onto the half-silvered sensor instead, in the Bullet
# physics engine; `sh cmake/demo.sh mujoco [FOLDER [WIDTH]]` moves a GelTip by MuJoCo;
# `sh cmake/demo.sh calibrate --fit DIR --test DIR --out DIR` fits a sensor of your own to
# photographs of a ball.
set -eu
here=$PWD  # where the caller's files are
cd "$(dirname "$0")/.."
for word in "$@"; do
  case $word in
  -h | --help)
    cat <<'HELP'
sh cmake/demo.sh [options]         tactile images of a GelTip sensor, in out/
sh cmake/demo.sh bullet [options]  things fall onto a half-silvered sensor, by the Bullet engine
sh cmake/demo.sh mujoco [FOLDER [WIDTH]]
                                   a GelTip presses, rolls and slides, by MuJoCo: an animation
sh cmake/demo.sh calibrate --fit DIR --test DIR --out DIR
                                   a sensor of your own, fitted to photographs of a ball

Lengths are in metres. Options of the GelTip's:
  --radius 0.01146   radius of the membrane
  --length 0.0455    length from the camera to the tip
  --edge 0.001       edge length of the mesh
  --depth 0.0025     how deep objects are pressed
  --fov 90           field of view from top to bottom, degrees
  --width 640        pixels
  --height 480       pixels
  --mesh FILE        a membrane of your own (STL, OBJ, PLY, OFF); needs --contact
  --rest FILE        its depth map without contact (.npy of float32 or float64, or grey 16-bit .png)
  --contact FILE...  depth maps of what touches it (likewise)
  --scale 0.00001    metres to a step of the values in depth maps in .png
  --background FILE  what the camera sees in ambient light
  --out out          folder for the pictures
HELP
    exit 0
    ;;
  esac
done
demo=geltip
case ${1:-} in
  bullet | mujoco | calibrate) demo=$1 && shift ;;
  -* | '') ;;
  *) echo "demo.sh: what is $1? --help says what there is" >&2 && exit 2 ;;
esac
more=
case $demo in
  geltip) known="radius length edge depth fov width height mesh rest contact scale background out" ;;
  bullet) known="width height seconds every out" more=libbullet-dev ;;
  mujoco) known="" more="libwebp-dev libmujoco-dev" ;;
  calibrate) known="fit test out" ;;
esac
# Before anything is installed or built.
refuse() { echo "demo.sh: $1" >&2 && exit 2; }
# An option's value; the program says the rest of what is wrong with it.
check_value() {
  [ -n "$2" ] || refuse "$1 has no value"
  case $1=$2 in
    --radius=*[eE+-] | --length=*[eE+-] | --edge=*[eE+-] | --fov=*[eE+-] | --scale=*[eE+-] | --depth=*[eE+-])
      refuse "$1 is $2, which is not a number"
      ;;
    --fov=18[0-9]* | --fov=19[0-9]* | --fov=[2-9][0-9][0-9]*)
      refuse "$1 is $2 degrees, which is not between 0 and 180"
      ;;
  esac
  case $1 in
    --radius | --length | --edge | --fov | --width | --height | --scale | --seconds)
      case $2 in
        -* | *[!0-9.eE+-]*) refuse "$1 is $2, which is not a number above 0" ;;
        *[1-9]*) ;;
        *) refuse "$1 is $2, which is not a number above 0" ;;
      esac
      ;;
    --depth | --every)
      case $2 in
        -* | *[!0-9.eE+-]*) refuse "$1 is $2, which is not a number from 0 on" ;;
      esac
      ;;
    --mesh | --rest | --contact | --background | --fit | --test)
      case $2 in
        /*) [ -e "$2" ] ;;
        *) [ -e "$here/$2" ] ;;
      esac || refuse "there is no file $2"
      ;;
  esac
}
option='' wants=''
for word in "$@"; do
  case $word in
    --*)
      [ -z "$wants" ] || refuse "$option has no value"
      option=${word%%=*}
      case " $known " in
        *" ${option#--} "*) ;;
        *) refuse "$demo has no option $word; --help lists them" ;;
      esac
      wants=yes
      [ "$option" = "$word" ] || { check_value "$option" "${word#*=}" && wants=; }
      ;;
    *)
      case $wants$word in
        -*) refuse "$demo has no option $word; --help lists them" ;;
      esac
      [ -z "$option" ] || check_value "$option" "$word"
      wants=
      ;;
  esac
done
[ -z "$wants" ] || refuse "$option has no value"
if [ "$demo" = calibrate ]; then
  for option in fit test out; do
    case " $*" in
      *" --$option"*) ;;
      *) refuse "calibrate needs --$option DIR" ;;
    esac
  done
fi
sh cmake/writable.sh build/demo
# shellcheck disable=SC2086 # one word a package
sh cmake/dependencies.sh g++ make cmake libeigen3-dev libopenmesh-dev libstb-dev libcli11-dev \
  libcairo2-dev pkg-config fonts-dejavu-core $more
cmake --preset demo
cmake --build --preset demo --target "$demo"
program=$PWD/build/demo/examples/$demo
cd "$here"
exec "$program" "$@"
