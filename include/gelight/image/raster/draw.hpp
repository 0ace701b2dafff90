#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/raster/faces.hpp"
#include "gelight/image/raster/held_faces.hpp"
#include "gelight/image/raster/lane_pixels.hpp"
#include "gelight/image/raster/lanes.hpp"
#include "gelight/image/raster/plane.hpp"
#include "gelight/image/raster/small_faces.hpp"
#include "gelight/image/raster/targets.hpp"
#include "gelight/image/raster/triangle.hpp"

namespace gelight::detail {

/// Draws a face pixel by pixel.
template <class T>
void draw_one(const RasterTarget<T>& target, Index width, Index height, const ImagePoint* points,
              const SeenFace& face) {
  const auto& [a, b, c] = face.corners;
  draw_exactly(target, width, height, face.number, points[a], points[b], points[c]);
}

#if defined(__GNUC__)
/// Draws a face row by row, several pixels at a time.
template <class T, Index lanes>
class LargeFaceDrawing {
 public:
  LargeFaceDrawing(const RasterTarget<T>& target, Index width, Index face, ImageTriangle& triangle,
                   const Three& inverse_z)
      : screen_(target, face),
        cover_(none + triangle.doubtful(), none + triangle.least(), none + triangle.most(),
               {none + inverse_z[0], none + inverse_z[1], none + inverse_z[2]}),
        target_(target),
        triangle_(triangle),
        width_(width) {}

  /// Whether that is all of the face: pixels about which rounding leaves a doubt are left out. The
  /// others get the bits that ImageTriangle gives them.
  [[nodiscard]] bool draw(const PixelBox& box) {
    if (box.is_wide()) {
      draw_wide(box);
    } else {
      for (Index v = box.first_row; v <= box.last_row; ++v) {
        draw_row(v, box.first_column, box.last_column);
      }
    }
    screen_.finish();
    return cover_.doubts() == 0;
  }

 private:
  using Doubles = Lanes<double, lanes>;
  using Numbers = Lanes<Index, lanes>;
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr Doubles none{};

  void draw_wide(const PixelBox& box) {
    triangle_.find_slopes();
    std::array<Index, lanes> first, last;
    for (Index v = box.first_row; v <= box.last_row; ++v) {
      const auto n = static_cast<std::size_t>((v - box.first_row) % lanes);
      if (n == 0) find_reach(box, v, first, last);
      draw_row(v, first[n], last[n]);
    }
  }

  /// As ImageTriangle does it, of a row a lane.
  void find_reach(const PixelBox& box, Index top, std::array<Index, lanes>& first,
                  std::array<Index, lanes>& last) const {
    constexpr double more = ImageTriangle::more_reach;
    const Doubles y = LaneNumbers<lanes>::all + static_cast<double>(top);
    Doubles from = none + static_cast<double>(box.first_column);
    Doubles to = none + static_cast<double>(box.last_column);
    const Doubles end = to + 1, before = from - 1;
    for (const ImageTriangle::Side& side : triangle_.sides()) {
      const Doubles x = side.x + (y - side.y) * side.slope;
      const Doubles lower = x - (side.dy < 0 ? more : infinity);
      const Doubles upper = x + (side.dy > 0 ? more : infinity);
      from = from < lower ? lower : from;
      to = upper < to ? upper : to;
    }
    from = end < from ? end : from;
    to = to < before ? before : to;
    round_up<lanes>(from), round_down<lanes>(to);
    store(__builtin_convertvector(from, Numbers), first.data());
    store(__builtin_convertvector(to, Numbers), last.data());
  }

  void draw_row(Index v, Index first, Index last) {
    const Three start = triangle_.areas_at(first, v);
    const auto& [p, q, r] = triangle_.sides();
    for (Index u = first; u <= last; u += lanes) {
      const Index x = std::min(u, width_ - lanes);
      const Doubles steps = LaneNumbers<lanes>::all - static_cast<double>(first - x);
      const Areas<lanes> areas{start[0] - steps * p.dy, start[1] - steps * q.dy,
                               start[2] - steps * r.dy};
      const auto covered = cover_.at(areas);
      screen_.add(target_.depth(x, v), covered.is ? covered.depth : none + infinity,
                  covered.shares);
    }
  }

  LaneScreen<T, lanes> screen_;
  Cover<lanes> cover_;
  const RasterTarget<T>& target_;
  ImageTriangle& triangle_;
  Index width_;
};

/// Draws a face of a batch whose corners are near the image.
template <Index lanes, class T>
void draw_large(const RasterTarget<T>& target, Index width, Index height, const ImagePoint* points,
                const SeenFace& face) {
  const auto& [i, j, k] = face.corners;
  const ImagePoint &a = points[i], &b = points[j], &c = points[k];
  ImageTriangle triangle(a, b, c);
  triangle.set_sides(triangle.rough_area());
  LargeFaceDrawing<T, lanes> drawing(target, width, face.number, triangle,
                                     {a.inverse_z, b.inverse_z, c.inverse_z});
  if (!drawing.draw(triangle.box(width, height))) draw_one(target, width, height, points, face);
}

/// Draws the faces of a batch from one on, but for those that may be held back or wait for others;
/// which is the first that has to be cut before it is drawn. `is_last`: none are left waiting.
template <Index lanes, class T>
[[nodiscard]] std::size_t draw_in_lanes(const RasterTarget<T>& target, Index width, Index height,
                                        const FaceBatch& batch, const FaceMeasures& measures,
                                        std::size_t from, HeldFaces* held, WaitingFaces& waiting,
                                        bool is_last) {
  using Kinds = FaceMeasures;
  const bool is_roomy = std::min(width, height) >= Kinds::most_across;
  SmallFaceDrawing<T, lanes> drawing(target, width, height);
  const auto exactly = [&](const SeenFace& face) {
    draw_one(target, width, height, batch.points, face);
  };
  Index left = is_last ? 0 : Kinds::small_kinds;
  for (std::size_t i = from;;) {
    SmallFaces* full = nullptr;
    while (i < batch.count && full == nullptr) {
      const Index kind = measures.kind[i];
      const SeenFace& face = batch.faces[i];
      if (kind < Kinds::small_kinds && is_roomy) {
        SmallFaces& small = waiting.of(kind);
        small.add(face, kind);
        if (small.is_full()) full = &small;
      } else if (kind == Kinds::back) {
        held->add(face.number, measures.least[i], measures.across[i], measures.down[i]);
      } else if (kind != Kinds::nothing) {
        if (waiting.keep_order() && !waiting.of(0).is_empty()) {
          full = &waiting.of(0);
          break;  // and this one after those
        }
        if (kind == Kinds::large && width >= lanes) {
          draw_large<lanes>(target, width, height, batch.points, face);
        } else {
          if (!batch.is_near(i)) return i;
          exactly(face);
        }
      }
      ++i;
    }
    if (full == nullptr) {  // and all faces of the batch are done
      if (left == Kinds::small_kinds) return i;
      full = &waiting.of(left++);
    }
    drawing.draw(batch.points, *full, exactly);
    full->clear();
  }
}
#endif

/// Draws faces in their order, pixel by pixel.
template <class T>
[[nodiscard]] std::size_t draw_one_by_one(const RasterTarget<T>& target, Index width, Index height,
                                          const FaceBatch& batch, std::size_t from) {
  for (std::size_t i = from; i < batch.count; ++i) {
    if (!batch.is_near(i)) return i;
    draw_one(target, width, height, batch.points, batch.faces[i]);
  }
  return batch.count;
}

template <class T>
[[nodiscard]] std::size_t draw_batch(const RasterTarget<T>& target, Index width, Index height,
                                     const FaceBatch& batch,
                                     [[maybe_unused]] const FaceMeasures& measures,
                                     std::size_t from, [[maybe_unused]] HeldFaces* held,
                                     [[maybe_unused]] WaitingFaces& waiting,
                                     [[maybe_unused]] bool is_last) {
#if defined(__GNUC__)
  if constexpr (sizeof(T) <= sizeof(double)) {  // of longer ones there are no lanes
    if (works_in_lanes()) {
      return vectorised_in_lanes([&](auto lanes) {
        return draw_in_lanes<lanes()>(target, width, height, batch, measures, from, held, waiting,
                                      is_last);
      });
    }
  }
#endif
  return draw_one_by_one(target, width, height, batch, from);
}

}  // namespace gelight::detail
