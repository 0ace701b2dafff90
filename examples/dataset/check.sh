#!/bin/sh
# What `dataset` promises, on a small one: the same bits on any number of ranks and threads; nothing
# lost, twice or broken however often it is killed; a clear word where something is missing.
# check.sh PROGRAMS MPIRUN FOLDER [KILLS]
set -eu
dataset=$1/dataset similarity=$1/similarity mpirun=$2 work=$3 kills=${4:-20}
rm -rf "$work" && mkdir -p "$work" && cd "$work"
# mpirun is to start more ranks than there are cores, and by root where CI is that.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
many=$("$mpirun" --version 2>&1 | grep -q "Open MPI\|OpenRTE" && echo --oversubscribe || true)
# shellcheck disable=SC2086 # no word where there is none
run_ranks() { ranks=$1 && shift && "$mpirun" $many -n "$ranks" "$dataset" "$@"; }
fail() { echo "failed: $*" && cat said 2>/dev/null; exit 1; }

# 250 samples in 25 parts, two sensors, every kind of thing stored.
cat >scene.json <<'END'
{"seed": 3, "samples": 247, "part": 10, "sensor_every": 40, "image": [64, 48],
 "store": ["image", "mask", "depth", "normals", "force", "markers", "pose", "seed"],
 "sensors": [{"edge": 0.004, "brightness": [0.5, 1]}, {"model": "digit", "edge": 0.004, "light": "linear"}],
 "objects": [{"shape": "cube edge", "size": [0.5, 1]}, {"shape": "grating"}],
 "pose": {"depth": {"normal": [0.001, 0.0005], "within": [0.0002, 0.002]}, "shift": [-0.001, 0.001]}}
END

# A truth to compare with, from one thread.
"$dataset" scene.json one.h5 --threads 1 >said 2>&1 || fail "one thread"
same() { diff -r one.h5.parts "$1.h5.parts" >said || fail "$1 is not the same"; }
"$dataset" scene.json threads.h5 --threads 3 >said 2>&1 || fail "three threads"
same threads
for ranks in 8 2; do
  rm -rf ranks.h5*
  run_ranks "$ranks" scene.json ranks.h5 >said 2>&1 || fail "$ranks ranks"
  same ranks
done

# Killed within half a second, again and again. Each part that is there is whole.
moment() { od -An -N1 -tu1 /dev/urandom | awk '{ print $1 / 512 }'; }
left_whole() {
  for part in "$1".h5.parts/*.h5; do
    [ ! -e "$part" ] || cmp -s "$part" "one.h5.parts/${part##*/}" || fail "$part is broken"
  done
}
for kill in $(seq "$kills"); do
  "$dataset" scene.json killed.h5 --threads 2 >/dev/null 2>&1 &
  sleep "$(moment)"
  kill -9 $! 2>/dev/null || true
  wait $! 2>/dev/null || true
  left_whole killed
  # (Begin anew when all is done, so that every kill has something to hit.)
  [ ! -e killed.h5 ] || rm -rf killed.h5*
done
"$dataset" scene.json killed.h5 >said 2>&1 || fail "going on after a kill"
same killed

# One of two ranks dies: the run ends and says so; the next one goes on.
run_ranks 2 scene.json dead.h5 --threads 1 >said 2>&1 &
run=$!
until [ -e dead.h5.parts/000002.h5 ] || ! kill -0 "$run" 2>/dev/null; do sleep 0.01; done
rank=$(ps -eo pid=,args= 2>/dev/null |
  awk -v program="$dataset" '$2 == program && /dead.h5/ { print $1; exit }')
if [ -n "$rank" ] && kill -9 "$rank" 2>/dev/null && ! wait "$run"; then
  grep -q "exited on signal 9\|KILLED BY SIGNAL: 9" said || fail "a dead rank is not told of"
fi
wait "$run" 2>/dev/null || true
left_whole dead
run_ranks 2 scene.json dead.h5 >said 2>&1 || fail "going on after a dead rank"
same dead

# What cannot be: each ends with an error that names it.
refused() {
  words=$1 && shift
  if "$@" >said 2>&1; then fail "$words is not refused"; fi
  grep -q "$words" said || fail "there is no word of $words"
}
printf '{"samples": 5, "objects": [{"mesh": "not_there.obj"}]}' >no_mesh.json
refused "there is no mesh .*not_there.obj" "$dataset" no_mesh.json no.h5
refused "not_there.obj" run_ranks 2 no_mesh.json no.h5
sed 's/"depth": {/"deph": {/' scene.json >misspelt.json
refused 'has "deph", which means nothing' "$dataset" misspelt.json no.h5
sed 's/"seed": 3/"seed": 4/' scene.json >other.json
refused "another description" "$dataset" other.json one.h5
# A disk that takes no more, as a limit on files makes it: after some parts, for a larger one.
limited() { (trap '' XFSZ && ulimit -f 64 && "$dataset" "$@"); }
sed 's/"part": 10/"part": 40/' scene.json >large.json
refused "cannot write full.h5.parts.*File too large" limited large.json full.h5 --threads 1
[ -z "$(ls full.h5.parts | grep -v description)" ] || fail "something is left of a full disk"

# As like as can be to itself, and less so to the same poses in another light.
"$similarity" one.h5 ranks.h5 >said 2>&1 || fail "the similarity of equals"
grep -q '| all .*| 1.000 +- 0.000 .*| equal .*| 0.000 +- 0.000' said || fail "equals are not alike"
sed 's/"brightness": \[0.5, 1\]/"light": "plane"/' scene.json >plane.json
"$dataset" plane.json plane.h5 >said 2>&1 || fail "another light"
"$similarity" one.h5 plane.h5 --picture alike.png >said 2>&1 || fail "the similarity of two lights"
grep -q '| all .*| 0.[0-9]* ' said || fail "two lights are the same"
refused "open full.h5" "$similarity" one.h5 full.h5

# Five lines of Python read it.
python=$([ -x /usr/bin/python3 ] && echo /usr/bin/python3 || echo python3)
if "$python" -c 'import h5py' 2>/dev/null; then
  cat >read.py <<'END'
import h5py
with h5py.File("work/one.h5") as file:
    image, mask = file["image"][246], file["mask"][:]
    number = file["seed"][:, 1]
print(image.shape, mask.shape, (number == range(247)).all(), mask.any(axis=(1, 2)).mean() > 0.9)
END
  mkdir elsewhere && ln -s "$work" elsewhere/work && cd elsewhere
  said=$("$python" ../read.py)
  [ "$said" = "(48, 64, 3) (247, 48, 64) True True" ] || fail "h5py reads $said"
else
  echo "h5py is not there: reading by it is skipped"
fi
echo "all of it holds"
