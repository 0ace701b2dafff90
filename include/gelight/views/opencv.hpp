#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <type_traits>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {
namespace detail {

/// OpenCV's number for pixels of type P: CV_32FC1 for float, CV_8UC3 for Rgb8, and so on.
template <class P>
constexpr int opencv_type() {
  if constexpr (std::is_arithmetic_v<P>) {
    return CV_MAKETYPE(cv::DataType<P>::depth, 1);
  } else {
    using Channel = typename P::value_type;
    return CV_MAKETYPE(cv::DataType<Channel>::depth, static_cast<int>(sizeof(P) / sizeof(Channel)));
  }
}

inline void require_opencv_type(const cv::Mat& image, int type) {
  require(image.dims <= 2, "the matrix has ", image.dims, " dimensions, not 2");
  require(image.empty() || image.type() == type, "the matrix is of OpenCV's type ", image.type(),
          ", not ", type);
}

}  // namespace detail

/// The pixels of a two-dimensional cv::Mat, which keeps them; it may be a region of another. P is
/// what a pixel is: float for CV_32FC1, Rgb8 for CV_8UC3 (whose colours stay in the order they
/// have). Throws InvalidInput for a matrix of more dimensions or of another type.
template <class P>
[[nodiscard]] ImageView<P> opencv_image(cv::Mat& image) {
  detail::require_opencv_type(image, detail::opencv_type<P>());
  return ImageView<P>::from_bytes(reinterpret_cast<P*>(image.data), image.cols, image.rows,
                                  static_cast<std::ptrdiff_t>(image.step[0]));
}
/// The same of a matrix that may not be written to.
template <class P>
[[nodiscard]] ImageView<const P> opencv_image(const cv::Mat& image) {
  detail::require_opencv_type(image, detail::opencv_type<P>());
  return ImageView<const P>::from_bytes(reinterpret_cast<const P*>(image.data), image.cols,
                                        image.rows, static_cast<std::ptrdiff_t>(image.step[0]));
}

}  // namespace gelight
