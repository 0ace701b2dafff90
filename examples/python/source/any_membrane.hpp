#pragma once

// Any membrane model as one type, so that a renderer is compiled once for all of them.

#include <memory>
#include <utility>

#include "gelight/concepts/membrane.hpp"
#include "gelight/image/camera.hpp"

class AnyMembrane {
 public:
  template <gelight::MembraneModel<float> M>
  explicit AnyMembrane(M model) : model_(std::make_shared<const Of<M>>(std::move(model))) {}

  using Workspace = std::shared_ptr<void>;
  [[nodiscard]] gelight::Index reach() const { return model_->reach(); }
  [[nodiscard]] Workspace make_workspace(gelight::Index width, gelight::Index height) const {
    return model_->make_workspace(width, height);
  }
  void press_into(gelight::ImageView<float> surface, const gelight::Press<float>& press,
                  Workspace& work) const {
    model_->press_into(surface, press, work.get());
  }
  void require_fits(const gelight::Camera<float>& camera) const { model_->require_fits(camera); }

 private:
  struct Model {
    virtual ~Model() = default;
    [[nodiscard]] virtual gelight::Index reach() const = 0;
    [[nodiscard]] virtual Workspace make_workspace(gelight::Index, gelight::Index) const = 0;
    virtual void press_into(gelight::ImageView<float>, const gelight::Press<float>&,
                            void*) const = 0;
    virtual void require_fits(const gelight::Camera<float>&) const = 0;
  };
  template <class M>
  struct Of : Model {
    explicit Of(M of) : model(std::move(of)) {}
    [[nodiscard]] gelight::Index reach() const override { return model.reach(); }
    [[nodiscard]] Workspace make_workspace(gelight::Index width,
                                           gelight::Index height) const override {
      using Work = decltype(model.make_workspace(width, height));
      return std::make_shared<Work>(model.make_workspace(width, height));
    }
    void press_into(gelight::ImageView<float> surface, const gelight::Press<float>& press,
                    void* work) const override {
      using Work = decltype(model.make_workspace(0, 0));
      model.press_into(surface, press, *static_cast<Work*>(work));
    }
    void require_fits(const gelight::Camera<float>& camera) const override {
      if constexpr (requires { model.require_fits(camera); }) model.require_fits(camera);
    }
    M model;
  };

  std::shared_ptr<const Model> model_;
};

static_assert(gelight::MembraneModel<AnyMembrane, float>);

/// One model as a class of its own in Python.
template <class M>
struct MembraneOf : AnyMembrane {
  explicit MembraneOf(M model) : AnyMembrane(std::move(model)) {}
};
