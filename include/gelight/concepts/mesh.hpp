#pragma once

#include <array>
#include <concepts>
#include <type_traits>

#include "gelight/core/types.hpp"

namespace gelight {

/// How a mesh type is read. Specialise it for a type of your own with
///
///     using Scalar = ...;                               // float or double
///     static auto vertex_count(const M&);               // integers
///     static auto face_count(const M&);
///     static auto position(const M&, Index vertex);     // [0], [1], [2] are x, y, z
///     static std::array<Index, 3> face(const M&, Index face);
///
/// A type that has `Scalar` and these four as members needs no specialisation.
template <class M>
struct MeshTraits;

namespace detail {

template <class M>
concept MeshByMembers = requires(const M& mesh, Index i) {
  typename M::Scalar;
  mesh.vertex_count();
  mesh.face_count();
  mesh.position(i);
  mesh.face(i);
};

}  // namespace detail

/// A mesh type that has the members itself.
template <detail::MeshByMembers M>
struct MeshTraits<M> {
  /// The member of the same name.
  ///@{
  using Scalar = typename M::Scalar;
  static auto vertex_count(const M& mesh) { return mesh.vertex_count(); }
  static auto face_count(const M& mesh) { return mesh.face_count(); }
  static decltype(auto) position(const M& mesh, Index vertex) { return mesh.position(vertex); }
  static decltype(auto) face(const M& mesh, Index face) { return mesh.face(face); }
  ///@}
};

/// A type for which MeshTraits is specialised.
template <class M>
concept HasMeshTraits = requires {
  sizeof(MeshTraits<M>);
};

/// Anything that tells its vertices' positions and its faces' vertices through MeshTraits.
template <class M>
concept TriangleMesh = HasMeshTraits<M> && requires(const M& mesh, Index i) {
  requires std::floating_point<typename MeshTraits<M>::Scalar>;
  { MeshTraits<M>::vertex_count(mesh) } -> std::integral;
  { MeshTraits<M>::face_count(mesh) } -> std::integral;
  { MeshTraits<M>::position(mesh, i)[0] } -> std::convertible_to<typename MeshTraits<M>::Scalar>;
  { MeshTraits<M>::face(mesh, i) } -> std::convertible_to<std::array<Index, 3>>;
};

/// What the coordinates of a mesh are made of.
template <TriangleMesh M>
using MeshScalar = typename MeshTraits<M>::Scalar;

}  // namespace gelight
