#pragma once

#include <concepts>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "gelight/core/error.hpp"
#include "gelight/core/types.hpp"
#include "gelight/views/image_view.hpp"

namespace gelight {

/// What std::mdspan offers, and what others have of the same make.
template <class M>
concept MdspanLike = requires(const M& m) {
  requires M::rank()
  == 2;
  { m.extent(0) } -> std::integral;
  { m.stride(0) } -> std::integral;
  { *m.data_handle() } -> std::same_as<typename M::reference>;
};

/// The elements of a two-dimensional mdspan as pixels: the first index is the row. No copy is made.
/// Throws InvalidInput for more rows or columns than Index counts.
template <MdspanLike M>
[[nodiscard]] auto mdspan_image(const M& array) {
  detail::require(std::in_range<Index>(array.extent(0)) && std::in_range<Index>(array.extent(1)),
                  "an array of ", array.extent(0), " x ", array.extent(1),
                  " is too large for an image");
  using P = std::remove_reference_t<typename M::reference>;
  return ImageView<P>(
      array.data_handle(), static_cast<Index>(array.extent(1)), static_cast<Index>(array.extent(0)),
      static_cast<std::ptrdiff_t>(array.stride(0)), static_cast<std::ptrdiff_t>(array.stride(1)));
}

}  // namespace gelight
