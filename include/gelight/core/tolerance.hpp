#pragma once

#include <limits>

// Every tolerance of the library that more than one place uses, each with the reason for its size.

namespace gelight::detail {

// --- lengths ---------------------------------------------------------------------------------

/// Within these a product of four lengths neither overflows nor vanishes: coordinates beyond the
/// one are refused, and lengths below the other count as none.
inline constexpr double largest_coordinate = 1e75, shortest_length = 1e-75;

// --- points ----------------------------------------------------------------------------------

/// The shares of a surface point sum to 1 within this; so far off its place may be, as a share of
/// the edges there, and what is given of it with a smaller share is not known to be its own. A
/// share of no more than this counts as none, and moves the point by no more than distances over
/// those edges are rounded by.
template <class T>
inline constexpr T share_rounding = 16 * std::numeric_limits<T>::epsilon();

/// A point nearer to a vertex than this share of the edges there, or a vertex at the end of such a
/// short edge, is next to it: in what direction it lies from there is known to epsilon by the
/// share, once it is given in the frames of those edges. A way that turns by as much at the vertex
/// is longer by half the square of that times the share, less than rounding while the share is more
/// than 1e-8.
inline constexpr double next_to_vertex = 1e-6;

}  // namespace gelight::detail
