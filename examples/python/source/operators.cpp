// Matrices of linear finite elements on a mesh.

#include "gelight/mesh/operators.hpp"

#include <tuple>

#include "arrays.hpp"
#include "topics.hpp"

using namespace py::literals;
using Triangulation = gelight::IntrinsicTriangulation<double>;

namespace {

// Lengths count in mean edges, so that none of their squares leaves the range of numbers.
double unit_of(const Surface& surface) {
  const double mean = gelight::detail::mean_edge_length(surface);
  return mean > 0 ? mean : 1;
}

Triangulation triangulation_of(const Surface& surface, bool intrinsic_delaunay) {
  return intrinsic_delaunay ? gelight::intrinsic_delaunay(surface, unit_of(surface))
                            : gelight::intrinsic_triangulation(surface, unit_of(surface));
}

struct Rows {
  std::vector<double> data;
  std::vector<Index> indices, indptr;
};

// Both triangles, row by row, of a matrix that is kept as the columns of its lower one.
Rows rows_of_both(const gelight::SymmetricMatrix<double>& matrix) {
  const auto& pattern = *matrix.pattern;
  Rows rows;
  rows.indptr.assign(static_cast<std::size_t>(pattern.size()) + 1, 0);
  const auto for_each = [&](const auto& work) {
    for (Index column = 0; column < pattern.size(); ++column) {
      for (Index e = pattern.begin(column); e < pattern.begin(column + 1); ++e) {
        work(pattern.row(e), column, matrix.values[e]);
        if (pattern.row(e) != column) work(column, pattern.row(e), matrix.values[e]);
      }
    }
  };
  for_each([&](Index row, Index, double) { ++rows.indptr[static_cast<std::size_t>(row) + 1]; });
  std::partial_sum(rows.indptr.begin(), rows.indptr.end(), rows.indptr.begin());
  rows.data.resize(static_cast<std::size_t>(rows.indptr.back()));
  rows.indices.resize(rows.data.size());
  std::vector<Index> next(rows.indptr.begin(), rows.indptr.end() - 1);
  for_each([&](Index row, Index column, double value) {
    const auto at = static_cast<std::size_t>(next[static_cast<std::size_t>(row)]++);
    rows.data[at] = value;
    rows.indices[at] = column;
  });
  return rows;
}

Rows laplacian_rows(const Surface& surface, bool intrinsic_delaunay) {
  const Triangulation mesh = triangulation_of(surface, intrinsic_delaunay);
  using Pattern = gelight::SymmetricPattern<double>;
  return rows_of_both(gelight::cotan_laplacian(mesh, std::make_shared<const Pattern>(mesh)));
}

std::vector<double> areas_of(const Surface& surface, bool intrinsic_delaunay) {
  const auto areas = gelight::vertex_areas(triangulation_of(surface, intrinsic_delaunay));
  const double unit = unit_of(surface);
  std::vector<double> out(areas.begin(), areas.end());
  for (double& area : out) area *= unit * unit;
  return out;
}

}  // namespace

void bind_operators(py::module_& m) {
  m.def(
      "cotan_laplacian",
      [](const Surface& surface, bool intrinsic_delaunay) {
        Rows rows = without_gil([&] { return laplacian_rows(surface, intrinsic_delaunay); });
        return std::make_tuple(array_of(std::move(rows.data)), array_of(std::move(rows.indices)),
                               array_of(std::move(rows.indptr)));
      },
      "surface"_a, py::kw_only(), "intrinsic_delaunay"_a = false,
      "The cotan Laplacian, positive semidefinite, of no unit: (L u)(i) = sum over edges ij of "
      "(cot a + cot b) / 2 (u(i) - u(j)). As rows, float64 (k,), int32 (k,), int32 (n + 1,): what "
      "`scipy.sparse.csr_matrix((data, indices, indptr), shape=(n, n))` takes.\n\n"
      "Any number of faces may share an edge; edges of faces without area are lengthened a little. "
      "intrinsic_delaunay: of the intrinsic Delaunay triangulation of the same surface, which has "
      "no negative weights inside.");
  m.def(
      "vertex_areas",
      [](const Surface& surface, bool intrinsic_delaunay) {
        return array_of(without_gil([&] { return areas_of(surface, intrinsic_delaunay); }));
      },
      "surface"_a, py::kw_only(), "intrinsic_delaunay"_a = false,
      "A third of the area of each vertex's faces, float64 (n,), in the square of the positions' "
      "unit: the diagonal of the lumped mass matrix of the same triangulation.");
}
