#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <variant>

#include "gelight/concepts/membrane.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/progress.hpp"
#include "gelight/core/types.hpp"
#include "gelight/image/camera.hpp"
#include "gelight/image/mask.hpp"
#include "gelight/membrane/bulge.hpp"
#include "gelight/membrane/gaussian.hpp"
#include "gelight/membrane/layer.hpp"
#include "gelight/membrane/layer_membrane.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// The membrane models that a planner chooses among, the cheapest first. Others are left out: the
/// chart of membranes shows Taxim's pyramid and the flat GelSight's blur both farther from the
/// elastic layer and dearer than one of these, in every gel, and springs are pressed by a force,
/// which no depth image tells.
enum class PlannedMembrane : std::uint8_t {
  gaussian,  ///< GaussianMembrane, of the preset's or the gel's sigma, or following the object
  bulging,   ///< BulgingMembrane
  layer      ///< LayerMembrane, of the preset's `gel`
};

/// A membrane model that a planner has chosen, whichever that is: for a renderer whose type does
/// not depend on it. Looks once a frame which one it is. A model of the concept MembraneModel.
template <std::floating_point T>
class AnyPlannedMembrane {
 public:
  /// What it may be, in the order of PlannedMembrane.
  using Model = std::variant<GaussianMembrane<T>, BulgingMembrane<T>, LayerMembrane<T>>;

  explicit AnyPlannedMembrane(Model model) : model_(std::move(model)) {}

  /// What it is.
  [[nodiscard]] const Model& model() const { return model_; }

  /// The memory that `press_into` works in: the model's own.
  using Workspace =
      std::variant<typename GaussianMembrane<T>::Workspace, typename BulgingMembrane<T>::Workspace,
                   typename LayerMembrane<T>::Workspace>;

  /// What the concept MembraneModel asks for.
  ///@{
  [[nodiscard]] Index reach() const {
    return std::visit([](const auto& model) { return model.reach(); }, model_);
  }
  [[nodiscard]] Workspace make_workspace(Index width, Index height) const {
    return std::visit(
        [&](const auto& model) -> Workspace { return model.make_workspace(width, height); },
        model_);
  }
  void press_into(ImageView<T> surface, const Press<T>& press, Workspace& work) const {
    const auto press_by = [&]<class M>(const M& model) {
      model.press_into(surface, press, std::get<typename M::Workspace>(work));
    };
    std::visit(press_by, model_);
  }
  /// As the model's; models that do not tell are not pulled by what lies deeper.
  [[nodiscard]] bool clips_to_rest() const {
    const auto clips = [](const auto& model) {
      if constexpr (requires { model.clips_to_rest(); }) return model.clips_to_rest();
      return true;
    };
    return std::visit(clips, model_);
  }
  /// Throws InvalidInput as the model does.
  void require_fits(const Camera<T>& camera) const {
    const auto fit = [&](const auto& model) {
      if constexpr (requires { model.require_fits(camera); }) model.require_fits(camera);
    };
    std::visit(fit, model_);
  }
  ///@}

 private:
  Model model_;
};

static_assert(MembraneModel<AnyPlannedMembrane<float>, float>);

namespace detail {

[[nodiscard]] inline const char* name_of(PlannedMembrane membrane) {
  constexpr std::array<const char*, 3> names{"Gaussian", "bulging membrane", "elastic layer"};
  return names[static_cast<std::size_t>(membrane)];
}

/// The mean of the depths that are known.
[[nodiscard]] inline double mean_rest(const Image<double>& rest) {
  double sum = 0;
  std::size_t known = 0;
  for (const double z : rest.pixels()) {
    if (!is_known(z) || !std::isfinite(z)) continue;
    sum += z;
    ++known;
  }
  require(known > 0, "the camera does not see the membrane");
  return sum / static_cast<double>(known);
}

/// A gel as a membrane that is no Gaussian.
template <std::floating_point T>
[[nodiscard]] AnyPlannedMembrane<T> gel_membrane(PlannedMembrane membrane,
                                                 const Camera<double>& camera, const Image<T>& rest,
                                                 double mean_rest, const Gel& gel,
                                                 const CancelHook& cancelled) {
  const Camera<T> eye = camera.template cast<T>();
  if (membrane == PlannedMembrane::bulging) {
    return AnyPlannedMembrane<T>(BulgingMembrane<T>(eye, static_cast<T>(mean_rest), gel));
  }
  const LayerOptions options{.sideways = false, .cancelled = cancelled};
  return AnyPlannedMembrane<T>(LayerMembrane<T>(ElasticLayer<T>(eye, rest, gel, options)));
}

}  // namespace detail
}  // namespace gelight
