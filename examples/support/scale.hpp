#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "figure.hpp"

/// A colour between dark blue (0) and pale yellow (1), lighter with every step.
inline Colour band_colour(double share) {
  static constexpr std::array<Colour, 5> stops{{{0.15, 0.18, 0.45},
                                                {0.13, 0.45, 0.55},
                                                {0.25, 0.68, 0.50},
                                                {0.68, 0.84, 0.40},
                                                {0.99, 0.96, 0.72}}};
  const double at = std::clamp(share, 0.0, 1.0) * (stops.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), stops.size() - 2);
  const double t = at - static_cast<double>(low);
  const Colour &a = stops[low], &b = stops[low + 1];
  return {a.red + t * (b.red - a.red), a.green + t * (b.green - a.green),
          a.blue + t * (b.blue - a.blue)};
}
