#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "gelight/concepts/image.hpp"
#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"

namespace gelight {

/// Red, green and blue of a pixel.
using Rgb8 = std::array<std::uint8_t, 3>;

namespace detail {

/// A pixel of zeros; Eigen's vectors have no value unless they are given one.
template <class P>
[[nodiscard]] P zero_pixel() {
  if constexpr (requires { P::Zero(); }) {
    return P::Zero();
  } else {
    return P{};
  }
}

}  // namespace detail

/// Pixels that someone else owns, at any distance from one another: packed, padded, one plane of an
/// interleaved image, transposed or mirrored. Copying a view copies no pixels.
template <class P>
class ImageView {
 public:
  ImageView() = default;

  /// Packed rows. Throws InvalidInput for a negative size, or no data for a size that is not zero.
  ImageView(P* data, Index width, Index height) : ImageView(data, width, height, width) {}

  /// Strides count pixels and may be negative; `data` is where (0, 0) is.
  ImageView(P* data, Index width, Index height, std::ptrdiff_t row_stride,
            std::ptrdiff_t pixel_stride = 1)
      : ImageView(
            from_bytes(data, width, height, row_stride * pixel_size, pixel_stride * pixel_size)) {}

  /// Strides count bytes, as the pitch or step of other libraries does.
  [[nodiscard]] static ImageView from_bytes(P* data, Index width, Index height,
                                            std::ptrdiff_t row_bytes,
                                            std::ptrdiff_t pixel_bytes = pixel_size) {
    detail::require(width >= 0 && height >= 0, "image size ", width, " x ", height, " is negative");
    detail::require(data != nullptr || width == 0 || height == 0, "image of size ", width, " x ",
                    height, " has no data");
    ImageView view;
    view.data_ = data;
    view.width_ = width;
    view.height_ = height;
    view.row_bytes_ = row_bytes;
    view.pixel_bytes_ = pixel_bytes;
    return view;
  }

  /// Size in pixels, where pixel (0, 0) is, and the bytes from a row or a pixel to the next.
  ///@{
  [[nodiscard]] Index width() const { return width_; }
  [[nodiscard]] Index height() const { return height_; }
  [[nodiscard]] P* data() const { return data_; }
  [[nodiscard]] std::ptrdiff_t row_bytes() const { return row_bytes_; }
  [[nodiscard]] std::ptrdiff_t pixel_bytes() const { return pixel_bytes_; }
  ///@}

  /// Whether the pixels of a row lie side by side, so that `row(y)[x]` is pixel (x, y).
  [[nodiscard]] bool rows_are_packed() const { return pixel_bytes_ == pixel_size || width_ <= 1; }

  /// Pixel (0, y).
  [[nodiscard]] P* row(Index y) const { return address(0, y); }

  /// Pixel (x, y); not checked.
  [[nodiscard]] P& operator()(Index x, Index y) const { return *address(x, y); }

  /// The same pixels with x and y exchanged.
  [[nodiscard]] ImageView transposed() const {
    return from_bytes(data_, height_, width_, pixel_bytes_, row_bytes_);
  }

  /// The same pixels, to be read only.
  operator ImageView<const P>() const requires(!std::is_const_v<P>) {
    return ImageView<const P>::from_bytes(data_, width_, height_, row_bytes_, pixel_bytes_);
  }

 private:
  using Byte = std::conditional_t<std::is_const_v<P>, const std::byte, std::byte>;
  static constexpr std::ptrdiff_t pixel_size = sizeof(P);

  [[nodiscard]] P* address(Index x, Index y) const {
    return reinterpret_cast<P*>(reinterpret_cast<Byte*>(data_) + y * row_bytes_ + x * pixel_bytes_);
  }

  P* data_ = nullptr;
  Index width_ = 0, height_ = 0;
  std::ptrdiff_t row_bytes_ = 0, pixel_bytes_ = pixel_size;
};

namespace detail {

/// Throws InvalidInput unless two images have one size; the names are those of the images.
template <ImageLike A, ImageLike B>
void require_same_size(const A& a, const B& b, const char* a_name, const char* b_name) {
  const auto width = ImageTraits<A>::width(a), height = ImageTraits<A>::height(a);
  const auto other_width = ImageTraits<B>::width(b), other_height = ImageTraits<B>::height(b);
  require(std::cmp_equal(width, other_width) && std::cmp_equal(height, other_height), a_name,
          " is ", width, " x ", height, " pixels, ", b_name, ' ', other_width, " x ", other_height);
}

/// The first byte of a view's pixels, and one past the last; as numbers, which compare wherever
/// they point.
template <class P>
[[nodiscard]] std::pair<std::uintptr_t, std::uintptr_t> byte_range(const ImageView<P>& view) {
  if (view.width() == 0 || view.height() == 0) return {0, 0};
  const std::ptrdiff_t across = (view.width() - 1) * view.pixel_bytes();
  const std::ptrdiff_t down = (view.height() - 1) * view.row_bytes();
  const auto start = reinterpret_cast<std::uintptr_t>(view.data());
  const auto at = [&](std::ptrdiff_t offset) {
    return start + static_cast<std::uintptr_t>(offset);
  };
  const std::ptrdiff_t zero = 0;
  return {at(std::min(across, zero) + std::min(down, zero)),
          at(std::max(across, zero) + std::max(down, zero)) + sizeof(P)};
}

}  // namespace detail

/// An image that owns its pixels, packed row after row from the top left.
template <class P>
class Image {
  static_assert(!std::is_same_v<P, bool>, "std::vector<bool> has no pixels to point to");

 public:
  Image() = default;

  /// Throws InvalidInput for a negative size.
  Image(Index width, Index height, const P& fill = detail::zero_pixel<P>())
      : width_(width), height_(height), pixels_(count(width, height), fill) {}

  /// Size in pixels.
  ///@{
  [[nodiscard]] Index width() const { return width_; }
  [[nodiscard]] Index height() const { return height_; }
  ///@}

  /// Pixel (0, 0), and pixel (0, y).
  ///@{
  [[nodiscard]] P* data() { return pixels_.data(); }
  [[nodiscard]] const P* data() const { return pixels_.data(); }
  [[nodiscard]] P* row(Index y) { return data() + std::ptrdiff_t{y} * width_; }
  [[nodiscard]] const P* row(Index y) const { return data() + std::ptrdiff_t{y} * width_; }
  ///@}

  /// Pixel (x, y); not checked.
  ///@{
  [[nodiscard]] P& operator()(Index x, Index y) { return row(y)[x]; }
  [[nodiscard]] const P& operator()(Index x, Index y) const { return row(y)[x]; }
  ///@}

  /// All pixels, row after row.
  ///@{
  [[nodiscard]] std::vector<P>& pixels() & { return pixels_; }
  [[nodiscard]] const std::vector<P>& pixels() const& { return pixels_; }
  [[nodiscard]] std::vector<P> pixels() && { return std::move(pixels_); }
  ///@}

  /// A view of all pixels, which the image must outlive: of a temporary it is good to the end of
  /// the expression.
  ///@{
  [[nodiscard]] ImageView<P> view() { return {data(), width_, height_}; }
  [[nodiscard]] ImageView<const P> view() const { return {data(), width_, height_}; }
  operator ImageView<P>() { return view(); }
  operator ImageView<const P>() const { return view(); }
  ///@}

  /// Whether size and all pixels are equal.
  friend bool operator==(const Image&, const Image&) = default;

 private:
  static std::size_t count(Index width, Index height) {
    detail::require(width >= 0 && height >= 0, "image size ", width, " x ", height, " is negative");
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }

  Index width_ = 0, height_ = 0;
  std::vector<P> pixels_;
};

}  // namespace gelight
