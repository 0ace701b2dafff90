#pragma once

// Every tolerance of the library that more than one place uses, each with the reason for its size.

namespace gelight::detail {

// --- lengths ---------------------------------------------------------------------------------

/// Within these a product of four lengths neither overflows nor vanishes: coordinates beyond the
/// one are refused, and lengths below the other count as none.
inline constexpr double largest_coordinate = 1e75, shortest_length = 1e-75;

}  // namespace gelight::detail
