#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/geodesic/path.hpp"
#include "gelight/mesh/surface.hpp"
#include "gelight/mesh/surface_point.hpp"

namespace gelight {
template <std::floating_point T>
struct Isoline;
}  // namespace gelight

namespace gelight::detail {

template <std::floating_point T>
class IsolineTracer {
 public:
  IsolineTracer(const Surface<T>& surface, std::span<const T> values, T level)
      : surface_(surface), values_(values), level_(level) {
    require(values.size() == static_cast<std::size_t>(surface.vertex_count()), "there are ",
            values.size(), " values, the mesh has ", surface.vertex_count(), " vertices");
    require(std::isfinite(level), "the level ", level, " is not finite");
    for (std::size_t v = 0; v < values.size(); ++v) {
      require(!std::isnan(values[v]), "the value of vertex ", v, " is not a number");
    }
  }

  [[nodiscard]] std::vector<Isoline<T>> lines() {
    is_done_.assign(static_cast<std::size_t>(surface_.face_count()), 0);
    std::vector<Isoline<T>> out;
    // Those with ends first, from where they begin; what is left goes round.
    for (const bool is_closed : {false, true}) {
      for (Index f = 0; f < surface_.face_count(); ++f) {
        if (is_done_[f]) continue;
        const Index entry = entry_of(f);
        if (entry >= 0 && (is_closed || before(entry) < 0)) out.push_back(follow(entry));
      }
    }
    return out;
  }

  [[nodiscard]] T area_below() const {
    Real sum = 0;
    for (Index f = 0; f < surface_.face_count(); ++f) sum += area_below(f);
    require(static_cast<double>(sum) <= largest_number<T>, "the area is ", sum,
            ", more than its type can hold");
    return static_cast<T>(sum);
  }

 private:
  using Mesh = Surface<T>;
  using Real = std::common_type_t<T, double>;  // of areas: float holds few products of lengths

  [[nodiscard]] T value(Index v) const { return values_[static_cast<std::size_t>(v)]; }
  [[nodiscard]] bool is_low(Index v) const { return value(v) < level_; }
  [[nodiscard]] bool is_finite(Index f) const {
    const auto v = surface_.face(f);
    return std::all_of(v.begin(), v.end(), [&](Index u) { return std::isfinite(value(u)); });
  }

  // Low values lie to the left: a line enters a face where they are at the beginning of a
  // half-edge, and leaves it where they are at the end of one.
  [[nodiscard]] Index entry_of(Index f) const { return crossing(f, true); }
  [[nodiscard]] Index exit_of(Index f) const { return crossing(f, false); }
  [[nodiscard]] Index crossing(Index f, bool from_low) const {
    if (!is_finite(f)) return -1;
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      if (is_low(surface_.origin(h)) == from_low && is_low(surface_.tip(h)) != from_low) return h;
    }
    return -1;
  }

  // The face across a half-edge in which the line goes on, or -1.
  [[nodiscard]] Index across(Index h) const {
    const Index t = surface_.twin(h);
    const bool goes_on = t != h && surface_.twin(t) == h &&
                         surface_.origin(t) != surface_.origin(h) && is_finite(Mesh::face_of(t));
    return goes_on ? Mesh::face_of(t) : -1;
  }
  [[nodiscard]] Index before(Index entry) const { return across(entry); }

  // How far along the way from one vertex to another the level lies. Halves of large values differ
  // by no more than T can hold; those of small ones would lose their last bits.
  [[nodiscard]] T share(Index from, Index to) const {
    const T a = value(from), b = value(to);
    const T scale = std::max(std::fabs(a), std::fabs(b)) > 1 ? T(0.5) : T(1);
    return (scale * level_ - scale * a) / (scale * b - scale * a);
  }

  [[nodiscard]] SurfacePoint<T> place(Index h) const {
    // From the lower vertex to the higher, so that both faces have the same point.
    const auto [a, b] = std::minmax({surface_.origin(h), surface_.tip(h)});
    const T t = share(a, b);
    if (t <= 0) return vertex_point<T>(a);
    if (t >= 1) return vertex_point<T>(b);
    return edge_point(a, b, t);
  }

  [[nodiscard]] Isoline<T> follow(Index entry) {
    Isoline<T> line;
    line.points.push_back(place(entry));
    Index f = Mesh::face_of(entry);
    while (f >= 0 && !is_done_[f]) {
      is_done_[f] = 1;
      const Index exit = exit_of(f);
      const SurfacePoint<T> next = place(exit);
      if (!(line.points.back() == next)) line.points.push_back(next);
      f = across(exit);
    }
    line.is_closed = f >= 0;
    return line;
  }

  [[nodiscard]] Vec3<Real> side(Index from, Index to) const {
    return cast<Real>(surface_.position(to)) - cast<Real>(surface_.position(from));
  }
  [[nodiscard]] Real area_below(Index f) const {
    const auto v = surface_.face(f);
    if (!is_finite(f)) return 0;
    const Real whole = stable_norm(cross<Real>(side(v[0], v[1]), side(v[0], v[2]))) / 2;
    const auto low = std::count_if(v.begin(), v.end(), [&](Index u) { return is_low(u); });
    if (low == 0 || low == 3) return low == 3 ? whole : Real(0);
    // The corner that is cut off.
    std::size_t k = 0;
    while (is_low(v[k]) != (low == 1)) ++k;
    const Real cut = whole * share(v[k], v[(k + 1) % 3]) * share(v[k], v[(k + 2) % 3]);
    return low == 1 ? cut : whole - cut;
  }

  const Surface<T>& surface_;
  std::span<const T> values_;
  T level_;
  Array<char> is_done_;  // of each face: whether its line was followed
};

}  // namespace gelight::detail
