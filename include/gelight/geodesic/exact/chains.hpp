#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

namespace gelight::detail {

/// Numbers of pieces of a line, each followed by the one that begins where it ends.
struct Chain {
  Array<Index> pieces;
  bool is_closed = false;  // whether the first follows on the last
};

/// Joins pieces 0 to `count` - 1 to chains: those with ends first. `after(i, is_taken)` is the
/// piece that follows on piece i, one that is not taken, or -1. Linear beside its calls, one for a
/// piece.
template <class After>
[[nodiscard]] Array<Chain> chains_of(Index count, const After& after) {
  const auto size = static_cast<std::size_t>(count);
  Array<Index> next(size, -1);
  Array<char> has_before(size, 0), is_done(size, 0);
  for (Index i = 0; i < count; ++i) {
    next[i] = after(i, has_before);
    if (next[i] >= 0) has_before[next[i]] = 1;
  }
  Array<Chain> out;
  // Those with ends from where they begin; what is left goes round.
  for (const bool is_closed : {false, true}) {
    for (Index i = 0; i < count; ++i) {
      if (is_done[i] || (!is_closed && has_before[i])) continue;
      Chain chain{{}, is_closed};
      for (Index k = i; k >= 0 && !is_done[k]; k = next[k]) {
        is_done[k] = 1;
        chain.pieces.push_back(k);
      }
      out.push_back(std::move(chain));
    }
  }
  return out;
}

/// Of pieces in order of their faces: the number of each face's first, and one more.
template <class Piece>
[[nodiscard]] Array<Index> first_pieces(const std::vector<Piece>& pieces, Index face_count) {
  Array<Index> first(static_cast<std::size_t>(face_count) + 1, 0);
  for (const Piece& piece : pieces) ++first[piece.face + 1];
  for (Index f = 0; f < face_count; ++f) first[f + 1] += first[f];
  return first;
}

}  // namespace gelight::detail
