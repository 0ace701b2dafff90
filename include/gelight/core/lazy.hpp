#pragma once

#include <mutex>
#include <optional>

namespace gelight::detail {

/// A value that is made when it is first asked for, by one of the threads that ask.
template <class T>
class Lazy {
 public:
  [[nodiscard]] const T& get(const auto& make) const {
    std::call_once(once_, [&] { value_.emplace(make()); });
    return *value_;
  }

 private:
  mutable std::once_flag once_;
  mutable std::optional<T> value_;
};

}  // namespace gelight::detail
