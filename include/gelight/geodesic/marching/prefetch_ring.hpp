#pragma once

#include <cstddef>
#include <functional>

#include "gelight/core/array.hpp"
#include "gelight/core/prefetch.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// Takes a vertex from the queue and has the memory fetched for those after it, each step early
/// enough for the next (measured): where a vertex' spokes begin, these, and what they end at.
/// Waiting for it would take a third of the time on large meshes. (Not a solver's member: GCC 12
/// leaves out calls of a member function that does nothing but fetch.)
/// `vertex_of` tells the vertex of what is in the queue.
template <class Queue, class Spoke, class Vertex, class GetVertex = std::identity>
[[nodiscard]] Index pop_and_prefetch(Queue& queue, const Array<Index>& begin,
                                     const Array<Spoke>& spokes, const Array<Vertex>& vertices,
                                     GetVertex vertex_of = {}) {
  constexpr unsigned long_before = 8, before = 4, just_before = 1;
  constexpr std::size_t typical_spokes = 7;
  const Index v = queue.pop().first;
  if (const Index w = queue.next_or(-1, long_before); w >= 0) {
    prefetch(begin.data() + vertex_of(w), sizeof(Index));
    prefetch(vertices.data() + w, sizeof(Vertex));
  }
  if (const Index w = queue.next_or(-1, before); w >= 0) {
    prefetch(spokes.data() + begin[vertex_of(w)], typical_spokes * sizeof(Spoke));
  }
  if (const Index w = queue.next_or(-1, just_before); w >= 0) {
    const Index owner = vertex_of(w);
    for (Index s = begin[owner]; s < begin[owner + 1]; ++s) {
      prefetch(vertices.data() + spokes[s].end, sizeof(Vertex));
    }
  }
  return v;
}

}  // namespace gelight::detail
