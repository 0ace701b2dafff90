#pragma once

#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "gelight/views/mesh_view.hpp"
#include "stress/stress.hpp"

namespace gelight::stress {

template <std::floating_point T>
[[nodiscard]] Mesh<T> cast(const Mesh<double>& mesh) {
  Mesh<T> out{{}, mesh.faces};
  for (const auto& [x, y, z] : mesh.positions) {
    out.positions.push_back({static_cast<T>(x), static_cast<T>(y), static_cast<T>(z)});
  }
  return out;
}

template <class Solver, std::floating_point T>
class QueryOf : public Query {
 public:
  template <class... Options>
  explicit QueryOf(const Mesh<double>& mesh, const Options&... options)
      : solver_(cast<T>(mesh), options...) {}

  [[nodiscard]] std::vector<double> distance(const Sources& sources) const override {
    const auto own = solver_.distance(std::span<const Source<T>>(converted(sources)));
    return {own.begin(), own.end()};
  }

  void distance_into(std::vector<double>& out, const Sources& sources) const override {
    std::vector<T> own;
    for (const double x : out) own.push_back(static_cast<T>(x));
    const auto copy_back = [&] {
      for (std::size_t i = 0; i < out.size(); ++i) out[i] = double{own[i]};
    };
    try {
      solver_.distance_into(own, std::span<const Source<T>>(converted(sources)));
    } catch (...) {
      copy_back();
      throw;
    }
    copy_back();
  }

 private:
  [[nodiscard]] static std::vector<Source<T>> converted(const Sources& sources) {
    std::vector<Source<T>> out;
    for (const auto& source : sources) {
      out.push_back({source.point.template cast<T>(), static_cast<T>(source.distance)});
    }
    return out;
  }

  Solver solver_;
};

/// Makes a query with `Solver<float>` or `Solver<double>`.
template <template <class> class Solver, class... Options>
[[nodiscard]] auto maker(const Options&... options) {
  return [=](const Mesh<double>& mesh, Precision precision) -> std::unique_ptr<Query> {
    if (precision == Precision::in_float) {
      return std::make_unique<QueryOf<Solver<float>, float>>(mesh, options...);
    }
    return std::make_unique<QueryOf<Solver<double>, double>>(mesh, options...);
  };
}

}  // namespace gelight::stress
