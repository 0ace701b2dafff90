#!/bin/sh
# What `all_pairs` promises, on a small mesh: the same rows on any number of ranks, also after kills;
# certificates where it is approximate, and lengths that a sphere's great circles tell.
# check.sh PROGRAMS MPIRUN FOLDER [KILLS]
set -eu
all_pairs=$1/all_pairs mpirun=$2 work=$3 kills=${4:-8}
rm -rf "$work" && mkdir -p "$work" && cd "$work"
# (mpirun by root, as where CI is that, and with more ranks than cores.)
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
many=$("$mpirun" --version 2>&1 | grep -q "Open MPI\|OpenRTE" && echo --oversubscribe || true)
fail() { echo "failed: $*" && cat said 2>/dev/null; exit 1; }
geltip="geltip --edge 0.003 --part 9"

# shellcheck disable=SC2086 # words
"$all_pairs" $geltip --type float64 one.h5 --threads 1 >said 2>&1 || fail "one thread"
grep -q "there and back differ by" said || fail "nothing is said of symmetry"
# shellcheck disable=SC2086
"$mpirun" $many -n 2 "$all_pairs" $geltip --type float64 two.h5 >said 2>&1 || fail "two ranks"
diff -r one.h5.parts two.h5.parts >said || fail "two ranks give other rows"

for kill in $(seq "$kills"); do
  # shellcheck disable=SC2086
  "$all_pairs" $geltip --type float64 killed.h5 >/dev/null 2>&1 &
  sleep "$(od -An -N1 -tu1 /dev/urandom | awk '{ print $1 / 512 }')"
  kill -9 $! 2>/dev/null || true
  wait $! 2>/dev/null || true
  [ ! -e killed.h5 ] || rm -rf killed.h5*
done
# shellcheck disable=SC2086
"$all_pairs" $geltip --type float64 killed.h5 >said 2>&1 || fail "going on after a kill"
diff -r one.h5.parts killed.h5.parts >said || fail "kills changed the rows"

# shellcheck disable=SC2086
"$all_pairs" $geltip --method fast_marching fast.h5 >said 2>&1 || fail "fast marching"
# shellcheck disable=SC2086
if "$all_pairs" $geltip --method fast_marching one.h5 >said 2>&1; then fail "another method goes on"; fi
grep -q "another description" said || fail "nothing is said of another description"
if "$all_pairs" not_there.obj no.h5 >said 2>&1; then fail "no mesh is one"; fi
grep -q "there is no mesh not_there.obj" said || fail "nothing is said of a missing mesh"
# Three faces at an edge, of which one would be torn off, and a face the wrong way round.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 -1\nf 1 2 3\nf 1 2 4\nf 1 2 5\n' >book.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\nf 1 2 4\n' >turned.obj
for mesh in book turned; do
  if "$all_pairs" $mesh.obj torn.h5 >said 2>&1; then fail "$mesh is torn without a word"; fi
  grep -q "be torn off" said && [ ! -e torn.h5.parts ] || fail "what is said of $mesh"
done
# A regular octahedron.
printf 'v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n' >octahedron.obj
printf 'f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n' >>octahedron.obj
# A point that is no number, of which OpenMesh would give the place to the next; and one that has gone
# into single precision far from the origin.
refused() { # WORDS FILE
  if "$all_pairs" "$2" no.h5 >said 2>&1; then fail "$2 is not refused"; fi
  grep -q "$1" said && [ ! -e no.h5.parts ] || fail "what is said of $2"
}
for number in nan inf -inf 1e300 1e400 0,5 ''; do
  printf 'v 0 0 0\nv 1 0 0\n  v 0 %s 1\nv 0 1 0\nv 1 1 0\nf 1 2 4\nf 2 5 4\n' "$number" >number.obj
  refused "number.obj, line 3: " number.obj
  printf 'OFF # text\n4 2 0\n0 0 0\n1 %s 0 # here\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n' "${number:-x}" >number.off
  refused "number.off, line 4: " number.off
  printf 'solid a\nfacet normal nan nan nan\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex %s 1 0\nendloop\nendfacet\nendsolid a\n' "${number:-x}" >number.stl
  refused "number.stl, line 6: " number.stl
done
sed 's/vertex  *[^ ]* 1 0/vertex 0 1 0/' number.stl >facet.stl
"$all_pairs" facet.stl facet.h5 >said 2>&1 || fail "a facet"
grep -q "of the distance at most, over 3 random pairs" said || fail "the pairs of three vertices"
sed 's/vertex /vertex 10000/' facet.stl >far.stl
refused "far.stl lies 1e+05 from the origin" far.stl
{
  head -c 80 /dev/zero && printf '\001\000\000\000' && head -c 24 /dev/zero
  printf '\000\000\200\077' && head -c 8 /dev/zero && printf '\000\000\300\177\000\000\200\077' && head -c 6 /dev/zero
} >binary.stl
refused "binary.stl, face 0 has a point that is not finite" binary.stl
printf 'v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n' >point.obj
refused "point.obj has no area" point.obj
# So far away that double precision bends it; and lengths that single precision cannot hold.
awk 'BEGIN { CONVFMT = "%.17g" } $1 == "v" { $2 += 1e13 } { print }' octahedron.obj >farther.obj
refused "farther.obj lies 1e+13 from the origin, where double precision" farther.obj
for length in 3e38 1e-40; do
  printf "v 0 0 0\\nv $length 0 0\\nv 0 $length 0\\nv $length $length 0\\nf 1 2 3\\nf 2 4 3\\n" >length.obj
  if "$all_pairs" length.obj "single_$length.h5" >said 2>&1; then fail "lengths of $length in single precision"; fi
  grep -q "the distance from vertex [0-3] to vertex [0-3] is .*, which float32 cannot hold" said || fail "what is said of $length"
  "$all_pairs" length.obj "double_$length.h5" --type float64 >said 2>&1 || fail "lengths of $length"
done
if "$all_pairs" facet.stl nowhere/no.h5 >said 2>&1 || [ -e nowhere ]; then fail "a folder nobody asked for"; fi
# Two parts, and a vertex of no face: from one to the other there is no way.
printf 'v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 2 3 4\nf 5 6 7\n' >parts.obj
for method in exact smooth fast_marching; do
  "$all_pairs" parts.obj "parts_$method.h5" --method $method >said 2>&1 || fail "$method in two parts"
done
for edge in 0 -1 nan 1e-7 1; do
  if "$all_pairs" geltip --edge "$edge" no.h5 >said 2>&1; then fail "an edge of $edge m"; fi
done

# An octahedron: next corners are an edge apart, opposite ones two heights of a face.
"$all_pairs" octahedron.obj octahedron.h5 --type float64 >said 2>&1 || fail "an octahedron"

# And a smaller one, a million of its edges away.
awk 'BEGIN { CONVFMT = "%.17g" } $1 == "v" { $2 = 0.7 * $2 + 1e6; $3 = 0.7 * $3 - 1e6; $4 *= 0.7 } { print }' octahedron.obj >far.obj
"$all_pairs" far.obj far.h5 --type float64 >said 2>&1 || fail "an octahedron far away"

# And one so far that its points lose digits as they are read, which is told.
awk 'BEGIN { CONVFMT = "%.17g" } $1 == "v" { $2 += 1e9 } { print }' octahedron.obj >lost.obj
for method in exact smooth fast_marching; do
  "$all_pairs" lost.obj "lost_$method.h5" --type float64 --method $method >said 2>&1 || fail "$method far away"
  grep -q "lost.obj lies 1e+09 from the origin: its points are rounded by" said || fail "digits are lost without a word"
done
"$all_pairs" octahedron.obj near_smooth.h5 --type float64 --method smooth >said 2>&1 || fail "smooth"
if grep -q "rounded" said; then fail "digits are lost near the origin"; fi

python=$([ -x /usr/bin/python3 ] && echo /usr/bin/python3 || echo python3)
if "$python" -c 'import h5py' 2>/dev/null; then
  "$python" - <<'END' || fail "what h5py reads"
import h5py, numpy as np
exact = h5py.File("one.h5")["distance"][:]
fast, bound = h5py.File("fast.h5")["distance"][:], h5py.File("fast.h5")["certified_error"][:]
away = ~np.eye(len(exact), dtype=bool)
error = np.abs(fast - exact)[away].reshape(len(exact), -1) / exact[away].reshape(len(exact), -1)
assert (error.max(axis=1) <= bound[:, 1] + 1e-6).all() and (error.mean(axis=1) <= bound[:, 0] + 1e-6).all()
assert np.allclose(exact, exact.T, rtol=1e-9, atol=0) and bound[:, 1].max() < 1
corners = h5py.File("octahedron.h5")["distance"][:]
assert (h5py.File("octahedron.h5")["position"][3] == (0, -1, 0)).all()
truth = np.where(np.arange(6)[:, None] // 2 == np.arange(6) // 2, np.sqrt(6), np.sqrt(2))
np.fill_diagonal(truth, 0)
assert np.allclose(corners, truth, rtol=1e-14, atol=0)
assert np.allclose(h5py.File("far.h5")["distance"][:], 0.7 * truth, rtol=1e-9, atol=0)
# (Whole corners are not rounded that far away.)
near = h5py.File("near_smooth.h5")["distance"][:]
assert np.allclose(h5py.File("lost_exact.h5")["distance"][:], truth, rtol=1e-9, atol=0)
assert np.allclose(h5py.File("lost_smooth.h5")["distance"][:], near, rtol=1e-9, atol=1e-12)
assert (h5py.File("lost_exact.h5")["position"][3] == (1e9, -1, 0)).all()
part = np.array([0, 1, 1, 1, 2, 2, 2])
for method in "exact", "smooth", "fast_marching":
    parts = h5py.File(f"parts_{method}.h5")["distance"][:]
    assert (np.isfinite(parts) == (part[:, None] == part)).all() and np.isclose(parts[2, 3], np.sqrt(2))
END
else
  echo "h5py is not there: comparing what is written is skipped"
fi
echo "all of it holds"
