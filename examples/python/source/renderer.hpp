#pragma once

// A tactile renderer of any membrane and reflectance, as one type.

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include "gelight/sensor/tactile_renderer.hpp"
#include "images.hpp"

using Frame = gelight::TactileFrame<float>;

class AnyRenderer {
 public:
  virtual ~AnyRenderer() = default;
  [[nodiscard]] virtual const Camera& camera() const = 0;
  [[nodiscard]] virtual const Image<Rgb8>& rest_image() const = 0;
  virtual void render_into(ImageView<Rgb8> out, const ImageView<const float>& depth) const = 0;
  [[nodiscard]] virtual Frame rest_frame() const = 0;
  virtual void render_next_into(Frame& frame, const ImageView<const float>& depth) const = 0;

  /// No other renderer has had it, nor will.
  [[nodiscard]] std::uint64_t number() const { return number_; }

 private:
  static inline std::atomic<std::uint64_t> made_ = 0;
  const std::uint64_t number_ = made_++;
};

template <class Renderer>
class RendererOf : public AnyRenderer {
 public:
  template <class... Parts>
  explicit RendererOf(Parts&&... parts) : renderer_(std::forward<Parts>(parts)...) {}

  [[nodiscard]] const Camera& camera() const override { return renderer_.camera(); }
  [[nodiscard]] const Image<Rgb8>& rest_image() const override { return renderer_.rest_image(); }
  void render_into(ImageView<Rgb8> out, const ImageView<const float>& depth) const override {
    renderer_.render_into(out, depth);
  }
  [[nodiscard]] Frame rest_frame() const override { return renderer_.rest_frame(); }
  void render_next_into(Frame& frame, const ImageView<const float>& depth) const override {
    renderer_.render_next_into(frame, depth);
  }

 private:
  Renderer renderer_;
};
