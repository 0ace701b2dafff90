#!/bin/sh
# Scripts that build say in one line, before they install or build, what is wrong: sh scripts_test.sh CHECKOUT FOLDER
set -eu
from=$1 there=$2
rm -rf "$there"
mkdir -p "$there/cmake" "$there/examples/pictures"
cp "$from"/cmake/*.sh "$there/cmake"
echo 'echo "it installs"' >"$there/cmake/dependencies.sh"
: >"$there/build" # a file, in which not even root can make folders

failed=0
# A script's arguments, and a word of its one line.
refuses() {
  word=$1 && shift
  script=$1 && shift
  said=$(cd "$there" && sh "cmake/$script.sh" "$@" 2>&1) && ended=0 || ended=$?
  case $said in
    *"
"*) ;;
    *"$word"*) [ "$ended" -eq 0 ] || return 0 ;;
  esac
  echo "WRONG: $script.sh $* ends with $ended and says: $said"
  failed=1
}
for script in demo test charts lessons python web; do
  refuses "cannot be written to" "$script"
done
refuses "cannot be written to" demo mujoco
refuses "--depth is -1" demo --depth -1
refuses "--depth is 1e" demo --depth 1e
refuses "--fov is 200" demo --fov 200
refuses "--fov is 180" demo --fov=180
refuses "cannot be written to" demo --fov 20.5 --depth 1e-3
refuses "no file nope.obj" demo --mesh nope.obj
refuses "no option --deep" demo --deep 1
refuses "no option -x" demo -x
refuses "no option -3" demo mujoco out -3
refuses "--rest has no value" demo --rest
refuses "calibrate needs --fit" demo calibrate
refuses "what is lights" demo lights
refuses "no file nope.obj" charts --mesh nope.obj
refuses "what is --fast" charts --fast
refuses "--mesh wants a file" charts --mesh
for script in demo test charts lessons python; do
  for word in -h --help; do
    said=$(cd "$there" && sh "cmake/$script.sh" $word 2>&1) && ended=0 || ended=$?
    case $ended$said in
      *"it installs"* | *"cannot be written"* | [!0]* | 0) echo "WRONG: $script.sh $word: $said" && failed=1 ;;
    esac
  done
done
for word in -h --help; do
  case $(sh "$from/cmake/dependencies.sh" $word 2>&1) in
    "Installs what is missing"*) ;;
    *) echo "WRONG: dependencies.sh takes $word for a package" && failed=1 ;;
  esac
done
exit "$failed"
