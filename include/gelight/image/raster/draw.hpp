#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "gelight/core/types.hpp"
#include "gelight/core/wide.hpp"
#include "gelight/image/raster/faces.hpp"
#include "gelight/image/raster/held_faces.hpp"
#include "gelight/image/raster/lane_pixels.hpp"
#include "gelight/image/raster/lanes.hpp"
#include "gelight/image/raster/plane.hpp"
#include "gelight/image/raster/targets.hpp"
#include "gelight/image/raster/triangle.hpp"

namespace gelight::detail {

/// Draws a face of a batch pixel by pixel.
template <class T>
void draw_one(const RasterTarget<T>& target, Index width, Index height, const FaceBatch& batch,
              std::size_t i) {
  const auto& [a, b, c] = batch.corners[i];
  draw_exactly(target, width, height, batch.faces[i], batch.points[a], batch.points[b],
               batch.points[c]);
}

#if defined(__GNUC__)
/// Draws faces of a batch, several pixels at a time.
template <class T, Index lanes>
class LaneDrawing {
 public:
  LaneDrawing(const RasterTarget<T>& target, Index width, const FaceBatch& batch,
              const FaceMeasures& measures)
      : target_(target), width_(width), of_(measures), screen_(target, batch, measures) {}

  /// Whether that is all of the face: pixels about which rounding leaves a doubt are left out. The
  /// others get the bits that ImageTriangle gives them.
  [[nodiscard]] bool draw(std::size_t i) {
    Doubles doubts = outside;
    const PixelBox box = of_.box(i);
    if (box.last_column - box.first_column < pixels_at_once) {
      draw_narrow(i, box, doubts);
    } else {
      draw_wide(i, box, doubts);
    }
    return bits_of(doubts >= -of_.doubtful[i]) == 0;
  }

  /// Has all that was drawn seen.
  void finish() { screen_.finish(); }

 private:
  using Doubles = Lanes<double, lanes>;
  using Numbers = LaneNumbers<lanes>;
  static constexpr Index rows_at_once = lanes / pixels_at_once;
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr Doubles none{}, inside = none + infinity, outside = none - infinity;

  /// The areas that pixels span with the sides of a face. Where a pixel is beyond its box, one of
  /// them is negative.
  struct Areas {
    Doubles a, b, c;
  };

  /// A block of pixels after the other, from the top.
  void draw_narrow(std::size_t i, const PixelBox& box, Doubles& doubts) {
    const auto &p = of_.sides[0], &q = of_.sides[1], &r = of_.sides[2];
    const Index x = std::min(box.first_column, width_ - pixels_at_once);
    const Doubles steps = Numbers::column - static_cast<double>(box.first_column - x);
    const Doubles step_p = steps * p.dy[i], step_q = steps * q.dy[i], step_r = steps * r.dy[i];
    const Doubles last_y = static_cast<double>(box.last_row) - none;
    Doubles y = Numbers::row + static_cast<double>(box.first_row);
    T* here = target_.depth(x, box.first_row);
    for (Index rows = box.last_row - box.first_row;; rows -= rows_at_once) {
      y = last_y < y ? last_y : y;  // so that a row that is left over is the last one again
      const Areas areas{(p.dx[i] * (y - p.y[i]) - p.across[i]) - step_p,
                        (q.dx[i] * (y - q.y[i]) - q.across[i]) - step_q,
                        (r.dx[i] * (y - r.y[i]) - r.across[i]) - step_r};
      show(i, here, target_.below(here, std::min(rows_at_once - 1, rows)), areas, doubts);
      if (rows < rows_at_once) return;
      y += static_cast<double>(rows_at_once);
      here = target_.below(here, rows_at_once);
    }
  }

  /// Row by row, from where it can be covered.
  void draw_wide(std::size_t i, const PixelBox& box, Doubles& doubts) {
    std::array<Index, lanes> first, last;
    for (Index v = box.first_row; v <= box.last_row; ++v) {
      const auto n = static_cast<std::size_t>((v - box.first_row) % lanes);
      if (n == 0) find_reach(i, box, v, first, last);
      draw_row(i, v, first[n], last[n], doubts);
    }
  }

  /// As ImageTriangle does it, of a row a lane.
  void find_reach(std::size_t i, const PixelBox& box, Index top, std::array<Index, lanes>& first,
                  std::array<Index, lanes>& last) const {
    constexpr double more = ImageTriangle::more_reach;
    const Doubles y = Numbers::all + static_cast<double>(top);
    Doubles from = static_cast<double>(box.first_column) - none;
    Doubles to = static_cast<double>(box.last_column) - none;
    const Doubles end = to + 1, before = from - 1;
    Four<double> slopes;
    find_slopes(i, slopes);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& side = of_.sides[k];
      const Doubles x = side.x[i] + (y - side.y[i]) * slopes[k];
      const Doubles lower = x - (side.dy[i] < 0 ? more : infinity);
      const Doubles upper = x + (side.dy[i] > 0 ? more : infinity);
      from = from < lower ? lower : from;
      to = upper < to ? upper : to;
    }
    from = end < from ? end : from;
    to = to < before ? before : to;
    using Whole = Lanes<Index, lanes>;
    const Whole down = __builtin_convertvector(from, Whole),
                up = __builtin_convertvector(to, Whole);
    const Doubles floor = __builtin_convertvector(down, Doubles);
    const Doubles ceil = __builtin_convertvector(up, Doubles);
    keep(first, floor < from ? floor + 1 : floor);
    keep(last, ceil > to ? ceil - 1 : ceil);
  }

  void find_slopes(std::size_t i, Four<double>& slopes) const {
    const auto &p = of_.sides[0], &q = of_.sides[1], &r = of_.sides[2];
    const Four<double> dx{p.dx[i], q.dx[i], r.dx[i], 0}, dy{p.dy[i], q.dy[i], r.dy[i], 1};
    const Four<double> nothing{}, by = dy == nothing ? nothing + 1 : dy;
    slopes = dy == nothing ? nothing : dx / by;
  }

  static void keep(std::array<Index, lanes>& into, const Doubles& numbers) {
    const auto whole = __builtin_convertvector(numbers, Lanes<Index, lanes>);
    std::memcpy(into.data(), &whole, sizeof whole);
  }

  void draw_row(std::size_t i, Index v, Index first, Index last, Doubles& doubts) {
    const auto &p = of_.sides[0], &q = of_.sides[1], &r = of_.sides[2];
    const auto area = [&](const FaceMeasures::Sides& s) {
      return s.dx[i] * (v - s.y[i]) - s.dy[i] * (first - s.x[i]);
    };
    const double start_p = area(p), start_q = area(q), start_r = area(r);
    for (Index u = first; u <= last; u += lanes) {
      const Index x = std::min(u, width_ - lanes);
      const Doubles steps = Numbers::all - static_cast<double>(first - x);
      const Areas areas{start_p - steps * p.dy[i], start_q - steps * q.dy[i],
                        start_r - steps * r.dy[i]};
      T* const here = target_.depth(x, v);
      show(i, here, here + (lanes - pixels_at_once), areas, doubts);
    }
  }

  /// Notes the largest of what makes pixels doubtful: the smallest areas of those that are not
  /// shown.
  void show(std::size_t i, T* here, T* there, const Areas& areas, Doubles& doubts) {
    const auto& [a, b, c] = areas;
    const Doubles a_or_b = b < a ? b : a, smallest = c < a_or_b ? c : a_or_b;
    const auto is_covered = smallest > of_.doubtful[i];
    const Doubles doubt = is_covered ? outside : smallest;
    doubts = doubts < doubt ? doubt : doubts;
    const Doubles part_a = a * of_.inverse_z[0][i], part_b = b * of_.inverse_z[1][i],
                  part_c = c * of_.inverse_z[2][i];
    const Doubles sum = part_a + part_b + part_c;
    const Doubles least = of_.least[i] - none, most = of_.most[i] - none;
    const Doubles depth = (a + b + c) / (is_covered ? sum : none + 1);
    const Doubles from_least = depth < least ? least : depth;
    const Doubles exact = most < from_least ? most : from_least;
    screen_.add({i, here, there, is_covered ? exact : inside, a, b, c});
  }

  const RasterTarget<T>& target_;
  Index width_;
  const FaceMeasures& of_;
  LaneScreen<T, lanes> screen_;
};

/// The order in which the faces of a batch are drawn: that of the mesh; or those together that are
/// drawn in as many steps, so that the processor foretells how often loops go round, and depths are
/// not read again at once.
class DrawingOrder {
 public:
  explicit DrawingOrder(bool is_free) : is_free_(is_free) {}

  void add(std::size_t face, const PixelBox& box, Index rows_at_once) {
    const Index steps = (box.last_row - box.first_row) / rows_at_once;
    const bool is_wide = box.last_column - box.first_column >= pixels_at_once;
    const Index kind = is_wide ? kinds - 1 : std::min(steps, kinds - 2);
    auto& faces = faces_[static_cast<std::size_t>(is_free_ ? kind : 0)];
    faces.numbers[faces.count] = static_cast<std::uint8_t>(face);
    ++faces.count;
  }
  template <class Work>
  void each(const Work& work) const {
    for (const Faces& faces : faces_) {
      for (std::size_t n = 0; n < faces.count; ++n) work(std::size_t{faces.numbers[n]});
    }
  }

 private:
  static constexpr Index kinds = 5;
  static_assert(FaceBatch::size <= 256);
  struct Faces {
    std::size_t count = 0;
    std::array<std::uint8_t, FaceBatch::size> numbers;
  };
  bool is_free_;
  std::array<Faces, kinds> faces_;
};

/// Draws the faces of a batch from one on, but for those that may be held back; which is the first
/// that has to be cut before it is drawn, for which those behind it wait.
template <Index lanes, class T>
[[nodiscard]] std::size_t draw_in_lanes(const RasterTarget<T>& target, Index width, Index height,
                                        const FaceBatch& batch, const FaceMeasures& measures,
                                        std::size_t from, HeldFaces* held) {
  const bool is_roomy = width >= lanes;
  DrawingOrder order(batch.are_usual && target.order_is_free());
  std::size_t end = from;
  for (; end < batch.count; ++end) {
    const bool is_exact = measures.areas[end] == 0 || !is_roomy;
    if (is_exact && !batch.is_near(end)) break;
    const PixelBox box = measures.box(end);
    if (box.is_empty()) continue;
    if (measures.areas[end] > 0 && !is_exact && held != nullptr) {
      held->add(batch.faces[end], measures.least[end], box);
    } else {
      order.add(end, box, lanes / pixels_at_once);
    }
  }
  LaneDrawing<T, lanes> drawing(target, width, batch, measures);
  order.each([&](std::size_t i) {
    if (measures.areas[i] != 0 && is_roomy && drawing.draw(i)) return;
    drawing.finish();
    draw_one(target, width, height, batch, i);
  });
  drawing.finish();
  return end;
}
#endif

/// Draws faces in their order, pixel by pixel.
template <class T>
[[nodiscard]] std::size_t draw_one_by_one(const RasterTarget<T>& target, Index width, Index height,
                                          const FaceBatch& batch, std::size_t from) {
  for (std::size_t i = from; i < batch.count; ++i) {
    if (!batch.is_near(i)) return i;
    draw_one(target, width, height, batch, i);
  }
  return batch.count;
}

template <class T>
[[nodiscard]] std::size_t draw_batch(const RasterTarget<T>& target, Index width, Index height,
                                     const FaceBatch& batch,
                                     [[maybe_unused]] const FaceMeasures& measures,
                                     std::size_t from, [[maybe_unused]] HeldFaces* held) {
#if defined(__GNUC__)
  if constexpr (sizeof(T) <= sizeof(double)) {  // of longer ones there are no lanes
    if (works_in_lanes()) {
      return vectorised_in_lanes(
          [&target, width, height, &batch, &measures, from, held](auto lanes) {
            return draw_in_lanes<lanes()>(target, width, height, batch, measures, from, held);
          });
    }
  }
#endif
  return draw_one_by_one(target, width, height, batch, from);
}

}  // namespace gelight::detail
