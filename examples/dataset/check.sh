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
run_ranks() { ranks=$1 && shift && timeout -k 9 120 "$mpirun" $many -n "$ranks" "$dataset" "$@"; }
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
python=$([ -x /usr/bin/python3 ] && echo /usr/bin/python3 || echo python3)
cat >equal.py <<'END'
import h5py, sys
for one, other in zip(sys.argv[1::2], sys.argv[2::2]):
    with h5py.File(one) as a, h5py.File(other) as b:
        assert list(a) == list(b) and all(a[k][:].tobytes() == b[k][:].tobytes() for k in a), other
END
# Whether two parts hold the same bits, however they are packed.
equal() {
  cmp -s "$1" "$2" && return 0
  if ! "$python" -c 'import h5py' 2>/dev/null; then echo "h5py is not there: $2 is not compared"; return 0; fi
  "$python" equal.py "$1" "$2"
}
same_as() { # TRUTH NAME
  [ "$(ls "$1.h5.parts")" = "$(ls "$2.h5.parts")" ] || fail "$2 has other parts"
  for truth in "$1".h5.parts/*.h5; do
    equal "$truth" "$2.h5.parts/${truth##*/}" || fail "$2 is not the same"
  done
}
same() { same_as one "$1"; }
part() { echo "$1.h5.parts/$2"-*.h5; } # whose name has a hash
"$dataset" scene.json threads.h5 --threads 3 >said 2>&1 || fail "three threads"
same threads
for ranks in 8 2; do
  rm -rf ranks.h5*
  run_ranks "$ranks" scene.json ranks.h5 >said 2>&1 || fail "$ranks ranks"
  same ranks
done

# Killed at random moments, of as little to do as shows each state of the files. Each part that is
# there is whole, and so is what joins them.
cat >tiny.json <<'END'
{"samples": 40, "part": 2, "image": [16, 12], "store": ["force", "pose", "seed"], "sensors": [{"model": "gelsight_mini", "light": "plane", "edge": 0.004}],
 "objects": [{"shape": "cube edge"}]}
END
"$dataset" tiny.json whole.h5 --threads 1 >said 2>&1 || fail "a tiny one"
# Runs two ranks until they have begun, that is, made something. (Before, nothing of ours is there,
# and a rank that dies while it connects can leave mpirun of Open MPI 4.1 waiting for ever.)
begin() { # NAME OPTIONS
  touch before
  run_ranks 2 tiny.json "$@" >said 2>&1 &
  run=$!
  until [ -n "$(find "$1.parts" -newer before 2>/dev/null)" ] || ! kill -0 "$run" 2>/dev/null; do sleep 0.01; done
}
begin timed.h5
begun=$(date +%s%N)
wait "$run" || fail "a tiny one on two ranks"
lasts=$((($(date +%s%N) - begun) / 1000000))
up_to() { od -An -N2 -tu2 /dev/urandom | awk -v most="$1" '{ print $1 / 65536 * most / 1000 }'; }
left_whole() { # NAME TRUTH
  for part in "$1".h5.parts/*.h5; do
    [ ! -e "$part" ] || equal "$2.h5.parts/${part##*/}" "$part" || fail "$part is broken"
  done
  # (Files that join parts differ by the name of the parts' folder, as long here.)
  [ ! -e "$1.h5" ] || [ "$(wc -c <"$1.h5")" = "$(wc -c <"$2.h5")" ] || fail "$1.h5 is broken"
}
# One of a run's ranks, picked at random, where ps tells which processes those are.
one_of() {
  # shellcheck disable=SC2046 # words
  set -- $(ps -eo pid=,args= 2>/dev/null |
    awk -v program="$dataset" -v out="$1.h5" '$2 == program && $4 == out { print $1 }')
  [ $# = 0 ] || { shift $(($(od -An -N1 -tu1 /dev/urandom) % $#)) && echo "$1"; }
}
for kill in $(seq "$kills"); do
  begin raked.h5 --threads 1
  sleep "$(up_to "$lasts")"
  rank=$(one_of raked)
  [ -z "$rank" ] || kill -9 "$rank" 2>/dev/null || true
  wait "$run" 2>/dev/null || true
  left_whole raked whole
  # (Begin anew when all is done, so that every kill has something to hit.)
  [ ! -e raked.h5 ] || rm -rf raked.h5*
done
run_ranks 2 tiny.json raked.h5 >said 2>&1 || fail "going on after dead ranks"
same_as whole raked
for kill in $(seq "$kills"); do
  "$dataset" tiny.json ended.h5 --threads 2 >/dev/null 2>&1 &
  sleep "$(up_to 100)"
  kill -9 $! 2>/dev/null || true
  wait $! 2>/dev/null || true
  left_whole ended whole
  [ ! -e ended.h5 ] || rm -rf ended.h5*
done
"$dataset" tiny.json ended.h5 >said 2>&1 || fail "going on after a kill"
same_as whole ended

# Stopped amid writing, by a limit on files, which is told: at the description, and at the header that
# joins the parts, which is the largest file. And what those leave that were killed there.
stops() { (ulimit -f "$1" && exec "$dataset" tiny.json amid.h5) >said 2>&1 && fail "it goes on with $1"; true; }
stops 0
[ ! -e amid.h5.parts/description ] || fail "a description that is half written"
stops $(($(wc -c <whole.h5) / 512 - 1))
grep -q "cannot write amid.h5.*File too large" said || fail "a file that is too large is not told of"
[ -e "$(part amid 000019)" ] && [ ! -e amid.h5 ] || fail "it stopped elsewhere"
[ ! -e amid.h5.*.tmp ] || fail "something is half written"
seventh=$(part amid 000007) && rm "$seventh"
for half in amid.h5 "$seventh"; do head -c 3000 whole.h5 >"$half.elsewhere.1.tmp"; done
"$dataset" tiny.json amid.h5 >said 2>&1 || fail "going on after death amid writing"
same_as whole amid
[ "$(find . -name 'amid.h5*.tmp' -o -path './amid.h5.parts/*.tmp')" = "" ] || fail "what was half written stays"
left_whole amid whole

# One of two ranks dies: the run ends and says so; the next one goes on.
run_ranks 2 scene.json dead.h5 --threads 1 >said 2>&1 &
run=$!
until [ -e "$(part dead 000002)" ] || ! kill -0 "$run" 2>/dev/null; do sleep 0.01; done
rank=$(one_of dead)
if [ -n "$rank" ] && kill -9 "$rank" 2>/dev/null && ! wait "$run"; then
  grep -q "exited on signal 9\|KILLED BY SIGNAL: 9" said || fail "a dead rank is not told of"
fi
wait "$run" 2>/dev/null || true
left_whole dead one
run_ranks 2 scene.json dead.h5 >said 2>&1 || fail "going on after a dead rank"
same dead

# All is there already: no more is said. And the last line of progress comes once.
"$dataset" scene.json dead.h5 >said 2>&1 || fail "nothing to do"
[ "$(cat said)" = "25 of 25 parts are there already" ] || fail "what is said of nothing to do"
[ "$("$dataset" tiny.json line.h5 2>&1 >/dev/null | grep -c "40 of 40")" = 1 ] || fail "the last line"

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
awk 'BEGIN { for (i = 0; i < 1000000; ++i) printf "["; for (i = 0; i < 1000000; ++i) printf "]" }' >deep.json
refused "it nests lists and objects 32 deep" "$dataset" deep.json no.h5
# A normal distribution wider than its ends is nearly even between them.
cat >wide.json <<'WIDE'
{"samples": 2000, "image": [8, 8], "store": ["mask"], "objects": [{"shape": "sphere"}],
 "sensors": [{"model": "gelsight_mini", "light": "linear"}],
 "pose": {"depth": {"normal": [0.0015, 0.5], "within": [0.0005, 0.0025]}}}
WIDE
"$dataset" wide.json wide.h5 >said 2>&1 || fail "a wide distribution"
if "$python" -c 'import h5py' 2>/dev/null; then
  "$python" -c 'import h5py
depth = h5py.File("wide.h5")["press"][:, 0]
assert abs(depth.std() / (0.002 / 12**0.5) - 1) < 0.05, depth.std()
assert len(set(depth)) == len(depth)' || fail "depths of a wide distribution"
fi
sed 's/"seed": 3/"seed": 4/' scene.json >other.json
refused "another description" "$dataset" other.json one.h5
# Two runs at once: the second one is refused, the first goes on.
"$dataset" scene.json twice.h5 --threads 1 >first 2>&1 &
first=$!
until [ -e "$(part twice 000001)" ] || ! kill -0 "$first" 2>/dev/null; do sleep 0.01; done
if kill -STOP "$first" 2>/dev/null; then
  refused "another process is writing" "$dataset" scene.json twice.h5
  kill -CONT "$first"
fi
wait "$first" || fail "the first of two runs"
same twice
# Somebody else's file, and a folder.
echo precious >theirs.h5 && mkdir -p folder.h5
refused "theirs.h5 is there" "$dataset" tiny.json theirs.h5
[ "$(cat theirs.h5)" = precious ] && [ ! -e theirs.h5.parts ] || fail "a refusal leaves something"
refused "folder.h5 is there" "$dataset" tiny.json folder.h5
refused "there is no folder .*nowhere" "$dataset" tiny.json nowhere/no.h5
[ ! -e nowhere ] || fail "a folder that nobody asked for"
mkdir -p new && refused '"new/" names no file' "$dataset" tiny.json new/
sed 's/"part": 2/"part": 18446744073709551615/' tiny.json >one_part.json
"$dataset" one_part.json one_part.h5 >said 2>&1 && [ -e "$(part one_part 000000)" ] || fail "one part"
# A description of which nothing was made can be changed.
sed 's/gelsight_mini/geltip/; s/0.004/0.002/; s/"part"/"pose": {"column": 0, "row": 0}, "part"/' tiny.json >beside.json
refused "presses beside the membrane" "$dataset" beside.json change.h5
[ ! -e change.h5.parts ] || fail "a refused description leaves a folder"
mkdir change.h5.parts && echo another >change.h5.parts/description
"$dataset" tiny.json change.h5 >said 2>&1 || fail "a description of which nothing was made"

cat >few.py <<'END'
import h5py, sys
with h5py.File("grown.h5") as few, h5py.File("whole.h5") as whole:
    count = int(sys.argv[1])
    assert all(few[k][:].tobytes() == whole[k][:count].tobytes() for k in whole)
END
# More samples of the same: what is there is kept, and the last part, which was short, made anew.
# Fewer are refused, and so are more of something else.
for few in 1 19; do
  rm -rf grown.h5*
  sed "s/: 40/: $few/" tiny.json >few.json
  "$dataset" few.json grown.h5 >said 2>&1 || fail "a few samples"
  first=$(stat -c %Y.%i "$(part grown 000000)")
  # (What is there stays readable until all is: stopped at the description and at the joined file.)
  cp grown.h5 before.h5
  for limit in 0 $(($(wc -c <whole.h5) / 512 - 1)); do
    (ulimit -f "$limit" && exec "$dataset" tiny.json grown.h5) >said 2>&1 && fail "it grows with $limit"
    cmp -s before.h5 grown.h5 || fail "a few samples are gone while there are to be more"
    if "$python" -c 'import h5py' 2>/dev/null; then
      "$python" few.py "$few" || fail "a few samples are others while there are to be more"
    fi
  done
  "$dataset" tiny.json grown.h5 >said 2>&1 || fail "more samples"
  [ "$few" = 1 ] || [ "$(stat -c %Y.%i "$(part grown 000000)")" = "$first" ] || fail "a part is made again"
  same_as whole grown
  left_whole grown whole
done
rm -rf few.h5* && cp whole.h5 kept.h5  # a copy, which joins the parts of whole.h5
refused "was begun with 40 rows, more than 19" "$dataset" few.json grown.h5
sed 's/plane/linear/; s/: 40/: 50/' tiny.json >grown_other.json
refused "another description" "$dataset" grown_other.json grown.h5
same_as whole grown

# Parts that a disk has damaged, cut off or mixed up: each is named and made again.
mended() { # PART
  "$dataset" tiny.json whole.h5 >mended 2>&1 || { cat mended && fail "going on with $1"; }
  grep -q "$1 is made again: ." mended || fail "nothing is said of $1"
  same_as grown whole
}
turn() { # FILE BYTE: one bit of it
  byte=$(od -An -tu1 -j"$2" -N1 "$1")
  # shellcheck disable=SC2059 # an octal escape
  printf "\\$(printf %o $((byte ^ 1)))" | dd of="$1" bs=1 seek="$2" conv=notrunc 2>/dev/null
}
third=$(part whole 000003)
size=$(wc -c <"$third")
turn "$third" $((size * 6 / 10)) && mended "$third"
head -c $((size / 2)) "$third" >cut && cp cut "$third" && mended "$third"
: >"$third" && mended "$third"
echo "no HDF5 at all" >"$third" && mended "$third"
cp "$(part whole 000004)" "$third" && mended "$third"
grep -q "was made as 000004" mended || fail "whose part it is, is not said"
named=0
for share in $(seq 0 15); do  # (In places that nothing reads, nothing need be said.)
  turn "$third" $((size * share / 16))
  "$dataset" tiny.json whole.h5 >said 2>&1 || fail "going on after byte $((size * share / 16))"
  same_as grown whole
  named=$((named + $(grep -c "$third is made again" said || true)))
done
[ "$named" -ge 8 ] || fail "of 16 damaged bytes $named are noticed"

# Values of a wrong kind or size: each is named before anything is written.
printf 'v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n' >large.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 -1\nf 1 2 3\nf 1 2 4\nf 1 2 5\n' >book.obj
sed '4s/0 0 1/0 nan 1/' book.obj >nan.obj
printf 'v 0 0 0\nv 0.01 0 0\nv 0.02 0 0\nf 1 2 3\n' >line.obj
printf 'v 0 0 0\nv 0.01 0 0\nv 0 0.01 0\nf 1 2 3\nf -3 -2 1\n' >corner.obj
printf 'OFF\n# nothing\n3 99999999999 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' >counts.off
printf 'ply\nformat ascii 1.0\nelement vertex 4000000000\nend_header\n' >counts.ply
printf 'v 10000 0 0\nv 10000.01 0 0\nv 10000 0.01 0\nf 1 2 3\n' >far.obj
wrong() { # WORDS FROM TO, in tiny.json
  sed "s~$2~$3~" tiny.json >wrong.json
  if cmp -s wrong.json tiny.json; then fail "$2 is not in tiny.json"; fi
  refused "$1" "$dataset" wrong.json wrong.h5
  [ ! -e wrong.h5.parts ] || fail "$1 leaves a folder"
}
wrong 'image is not \[columns, rows\] of 4 to 8192' '\[16, 12\]' '[3, 12]'
wrong 'objects are an empty list' '\[{"shape": "cube edge"}\]' '[]'
wrong 'line.obj has no area' '"shape": "cube edge"' '"mesh": "line.obj"'
wrong 'folder.h5 is a folder, not a mesh' '"shape": "cube edge"' '"mesh": "folder.h5"'
refused "folder.h5 is a folder, not a description" "$dataset" folder.h5 no.h5
wrong 'image\[0\] is 16.5, not a whole number' '\[16, 12\]' '[16.5, 12]'
wrong 'image\[0\] is 4294967312, not a whole number' '\[16, 12\]' '[4294967312, 12]'
wrong 'image is "16x12", not a list' '\[16, 12\]' '"16x12"'
wrong 'markers\[0\] is 2.5' '"samples"' '"markers": [2.5, 2], "samples"'
wrong 'objects is {.*, not a list' '\[{"shape": "cube edge"}\]' '{"shape": "cube edge"}'
wrong 'sensors is "digit", not a list' '\[{"model.*}\],' '"digit",'
wrong 'edge is 1.*e-09, not from' '0.004' '1e-9'
wrong 'edge is true, not a number' '0.004' 'true'
wrong 'model is 3, not a text' '"gelsight_mini"' '3'
wrong 'not a text of one line' '"shape"' '"name": "a\\nb", "shape"'
wrong 'not a text of one line' '"shape"' '"name": "a\\u0000b", "shape"'
wrong 'is not JSON' '0.004' 'NaN'
wrong 'is not JSON' '0.004' '1e999'
wrong 'has "part" twice' '"part": 2' '"part": 2, "part": 4'
wrong 'unit is 0, not from' '"shape": "cube edge"' '"mesh": "large.obj", "unit": 0'
wrong 'corner.obj, line 5: the face has vertex 1 twice' '"shape": "cube edge"' '"mesh": "corner.obj"'
wrong 'counts.off, line 3: 99999999999 things are more than' '"shape": "cube edge"' '"mesh": "counts.off"'
wrong 'counts.ply, line 3: 4000000000 things are more than' '"shape": "cube edge"' '"mesh": "counts.ply"'
wrong 'seed is -1, not a whole number' '"samples"' '"seed": -1, "samples"'
wrong 'be torn off' '"shape": "cube edge"' '"mesh": "book.obj"'
wrong 'nan.obj, line 4: "v 0 nan 1"' '"shape": "cube edge"' '"mesh": "nan.obj"'
wrong 'far.obj lies 1e+04 from the origin' '"shape": "cube edge"' '"mesh": "far.obj"'
wrong '9 m large' '"shape": "cube edge"' '"mesh": "large.obj"'
wrong 'not a number or its spread' '"shape"' '"size": "large", "shape"'
wrong '0.01, which reaches beyond 0 to 0.004, as deep as' '"part": 2' '"part": 2, "pose": {"depth": 0.01}'
wrong 'edge is 0.3, not from 0.0001 to 0.02' '0.004' '0.3'
wrong 'memory' '"samples": 40, "part": 2' '"samples": 1000000000000000, "part": 10000000000'
for seed in 0 -0; do
  sed "s/\"samples\"/\"seed\": $seed, \"samples\"/" tiny.json >zero.json
  "$dataset" zero.json "zero$seed.h5" >said 2>&1 || fail "the seed $seed"
done
same_as zero0 zero-0
# Light that is carried, in every sensor.
for model in geltip gelsight_mini digit sts; do
  sed "s/gelsight_mini/$model/; s/plane/transport/; s/: 40/: 2/" tiny.json >light.json
  "$dataset" light.json "light_$model.h5" >said 2>&1 || fail "transport in $model"
done

# A disk that takes no more, as a limit on files makes it: after some parts, for a larger one.
limited() { (ulimit -f 64 && "$dataset" "$@"); }
sed 's/"part": 10/"part": 40/' scene.json >large.json
refused "cannot write full.h5.parts.*File too large" limited large.json full.h5 --threads 1
printf '{"samples": 60, "part": 2, "image": [64, 48], "store": ["image"], "sensors": [{"model": "gelsight_mini", "light": "plane", "edge": 0.004}],
 "objects": [{"shape": "grating"}]}' >sheet.json
refused "cannot write sheet.h5.png.*: File too large" limited sheet.json sheet.h5
[ ! -e sheet.h5.png ] && [ -e sheet.h5 ] || fail "half a contact sheet"
[ "$(ls full.h5.parts | tr '\n' ' ')" = "description lock " ] || fail "something is left of a full disk"

# As like as can be to itself, and less so to the same poses in another light.
"$similarity" one.h5 ranks.h5 >said 2>&1 || fail "the similarity of equals"
grep -q '| all .*| 1.000 +- 0.000 .*| equal .*| 0.000 +- 0.000' said || fail "equals are not alike"
sed 's/"brightness": \[0.5, 1\]/"light": "plane"/' scene.json >plane.json
"$dataset" plane.json plane.h5 >said 2>&1 || fail "another light"
"$similarity" one.h5 plane.h5 --picture alike.png >said 2>&1 || fail "the similarity of two lights"
grep -q '| all .*| 0.[0-9]* ' said || fail "two lights are the same"
if grep -q "what is pressed" said; then fail "the same press is taken for another"; fi
refused "open full.h5" "$similarity" one.h5 full.h5
# What cannot be compared, and what is not the same press; a kind of which there is nothing.
for seed in 1 2; do
  printf '{"seed": %s, "samples": 4, "image": [64, 48], "store": ["image"], "objects": [{"shape": "grating"}], "sensors": [
    {"model": "gelsight_mini", "light": "plane", "edge": 0.004}, {"model": "digit", "light": "plane", "edge": 0.004}]}' $seed >kinds.json
  "$dataset" kinds.json kinds_$seed.h5 >said 2>&1 || fail "two kinds"
done
"$similarity" kinds_1.h5 kinds_2.h5 >said 2>&1 || fail "two seeds"
grep -q "in 4 of 4 pairs what is pressed, where or how deep differs" said || fail "other presses are not told of"
[ "$(grep -c "no images .*no images .*no images" said)" = 1 ] || fail "a kind without images is like another"
# Objects without a name, the first and the only one.
for names in '{"shape": "grating", "name": ""}, {"shape": "ring", "name": "b"}' '{"shape": "grating", "name": ""}'; do
  rm -rf nameless.h5*
  printf '{"samples": 8, "image": [64, 48], "store": ["image"], "objects": [%s], "sensors": [{"edge": 0.004, "light": "plane"}]}' "$names" >nameless.json
  "$dataset" nameless.json nameless.h5 >said 2>&1 || fail "a nameless object"
  "$similarity" nameless.h5 nameless.h5 >said 2>&1 || fail "the similarity of nameless objects"
done
refused "cannot write /dev/full: No space left" "$similarity" nameless.h5 nameless.h5 --picture /dev/full
# A set that was given another name, and then another set under the old one: its parts are not taken.
"$dataset" kinds.json old_name.h5 >said 2>&1 && mv old_name.h5 new_name.h5 && rm -r old_name.h5.parts
sed 's/"seed": 2/"seed": 5/' kinds.json >later.json
"$dataset" later.json old_name.h5 >said 2>&1 || fail "another set"
refused "the part .*old_name.h5.parts/.* of new_name.h5 is missing" "$similarity" new_name.h5 kinds_2.h5
mv old_name.h5.parts new_name.h5.parts
refused "new_name.h5.parts was begun with another description" "$dataset" kinds.json new_name.h5
# A bit that is turned, in what the joined file joins.
cp -r kinds_2.h5 turned.h5 && cp -r kinds_2.h5.parts turned.h5.parts
"$dataset" kinds.json turned.h5 >said 2>&1 || fail "a copy"
turn "$(part turned 000000)" $(($(wc -c <"$(part turned 000000)") - 5000))
refused "image of .*turned.h5.parts/000000.* is damaged in its row" "$similarity" turned.h5 kinds_2.h5
refused "one.h5 has 247 images of 64 x 48 pixels, kinds_1.h5 has 4 images" "$similarity" one.h5 kinds_1.h5
refused "there is no folder .*nowhere" "$similarity" one.h5 plane.h5 --picture nowhere/alike.png
# A part that was taken away, or that is another thing: no image in its place.
third=$(part plane 000003)
mv "$third" away.h5
refused "the part .*$third of plane.h5 is missing" "$similarity" one.h5 plane.h5
echo broken >"$third"
refused "the part .*$third of plane.h5 is missing" "$similarity" plane.h5 one.h5
cp "$(part plane 000004)" "$third"
refused "the part .*$third of plane.h5 is missing.*was made as 000004" "$similarity" plane.h5 one.h5
rm "$third"
# Straight light alone, to the image's edge.
printf '{"samples": 2, "image": [64, 48], "store": ["image"], "objects": [{"shape": "sphere"}], "sensors": [
  {"light": "linear", "edge": 0.004, "ambient": 0}]}' >frame.json
"$dataset" frame.json frame.h5 >said 2>&1 || fail "straight light alone"

# Five lines of Python read it.
python=$([ -x /usr/bin/python3 ] && echo /usr/bin/python3 || echo python3)
if "$python" -c 'import h5py' 2>/dev/null; then
  cat >read.py <<'END'
import h5py
with h5py.File("work/one.h5") as file:
    assert (file["object"][:] >= 0).all(), "a part is missing"
    image, mask = file["image"][246], file["mask"][:]
    number = file["seed"][:, 1]
print(image.shape, mask.shape, (number == range(247)).all(), mask.any(axis=(1, 2)).mean() > 0.9)
END
  mkdir elsewhere && ln -s "$work" elsewhere/work && cd elsewhere
  # The springs under a ball that is pressed into a plane: as many as its cap has volume.
  cat >../ball.json <<'END'
{"samples": 12, "image": [160, 120], "store": ["force"], "sensors": [{"model": "gelsight_mini", "light": "plane"}],
 "objects": [{"shape": "sphere", "size": [0.2, 0.4]}], "gel": {"modulus": [5e4, 2e5], "thickness": 0.003},
 "pose": {"column": [0.2, 0.8], "row": [0.25, 0.75], "lean": [0, 3], "depth": [0.001, 0.0015], "shift": [-0.001, 0.001]}}
END
  "$dataset" ../ball.json ../ball.h5 >../said 2>&1 || (cd .. && fail "a ball on a plane")
  cat >../labels.py <<'END'
import h5py, numpy as np
one, lost = h5py.File("work/one.h5"), h5py.File("work/plane.h5")
assert (np.flatnonzero(lost["object"][:] < 0) == range(30, 40)).all() and np.isnan(lost["depth"][30:40]).all()
assert np.isnan(lost["normals"][30:40]).all() and (lost["mask"][30:40] == 255).all()
place, depth, normals = one["place"][:], one["depth"][:], one["normals"][:]
fx, fy, cx, cy = one["camera"][:].T
assert (np.abs(place[:, 0] - np.round(place[:, 0])) > 1e-6).mean() > 0.9, "places on whole pixels"
# Normals are of length 1 or none, and there are as many on the frame as inside it.
length = np.linalg.norm(normals.astype(float), axis=-1)
assert (np.isnan(length) | (np.abs(length - 1) < 1e-5)).all()
known = np.isfinite(length)
assert known[:, 0].mean() > 0.9 * known[:, 2].mean() and known[:, :, -1].mean() > 0.9 * known[:, :, -3].mean()
# They stand on the points that depth and camera give.
rows, columns = np.indices(depth.shape[1:])
for i in range(0, 247, 31):
    z = depth[i].astype(float)
    p = np.stack([(columns - cx[i]) / fx[i] * z, (rows - cy[i]) / fy[i] * z, z], -1)
    n = np.cross(p[2:, 1:-1] - p[:-2, 1:-1], p[1:-1, 2:] - p[1:-1, :-2])
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    assert np.nanmedian((n * normals[i][1:-1, 1:-1]).sum(-1)) > 0.999
ball = h5py.File("work/ball.h5")
radius, (depth, _, _, modulus) = 0.008 * ball["place"][:, 2], ball["press"][:].T
cap = np.pi * depth**2 * (radius - depth / 3)
force = ball["force"][:] / (modulus / 0.003 * cap)[:, None]
assert np.abs(force - [0, 0, -1]).max() < 0.02, force
# A pose is a rotation times the size.
turned = one["pose"][:, :, :3]
assert np.allclose(turned @ turned.transpose(0, 2, 1), np.eye(3) * place[:, 2, None, None] ** 2, atol=1e-12)
frame = h5py.File("work/frame.h5")["image"][0].sum(axis=-1).astype(float)
for edge, inside in (frame[0], frame[1]), (frame[-1], frame[-2]), (frame[:, 0], frame[:, 1]), (frame[:, -1], frame[:, -2]):
    assert inside.mean() > 5 and edge.mean() > 0.8 * inside.mean(), "the image's edge is dark"
# Markers are told of where the camera sees the membrane, which hides behind nothing but what touches.
markers = one["markers"][:].reshape(247, 7, 9, 2)
at_rows, at_columns = (48 * (np.arange(7) + 0.5) / 7).astype(int), (64 * (np.arange(9) + 0.5) / 9).astype(int)
unseen = np.isnan(one["depth"][:][:, at_rows][:, :, at_columns])
assert (np.isnan(markers) == unseen[..., None]).all() and unseen.any() and not unseen.all(axis=(1, 2)).any()
light = one["light"][:]
assert np.isfinite(light[:, :3]).all() and np.isnan(light[:, 3]).all() and (light[:40, :3] == light[0, :3]).all()
assert (light[:, :3] <= 1).all() and (light[:, 4] == 0.9).all() and (light[:, 8] == 5).all()
for name in "place", "light", "camera", "press":
    assert len(one.attrs[name].split("\n")) == one[name].shape[1]
END
  "$python" ../labels.py || fail "the labels"
  said=$("$python" ../read.py)
  [ "$said" = "(48, 64, 3) (247, 48, 64) True True" ] || fail "h5py reads $said"
else
  echo "h5py is not there: reading by it is skipped"
fi
echo "all of it holds"
