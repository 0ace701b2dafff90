#pragma once

// Every tolerance of the library that more than one place uses, each with the reason for its size.

namespace gelight::detail {

// --- lengths ---------------------------------------------------------------------------------

/// Within these a product of four lengths neither overflows nor vanishes: coordinates beyond the
/// one are refused, and lengths below the other count as none.
inline constexpr double largest_coordinate = 1e75, shortest_length = 1e-75;

// --- light -----------------------------------------------------------------------------------

/// By how much a share of full light and the length of a direction may be more than 1: unit vectors
/// and white that went through 8 bits, four digits of text or a resized image, but no number in
/// another unit.
inline constexpr double beyond_full_light = 5e-3;

// --- directions ------------------------------------------------------------------------------

/// The square of a vector's length that inverse_sqrt has made 1 is within this of it in float: the
/// root is within 8e-7 of its size, three products and two sums round. Where it is farther off, a
/// square has left the range of numbers.
inline constexpr double unit_by_inverse_sqrt = 4e-6;

}  // namespace gelight::detail
