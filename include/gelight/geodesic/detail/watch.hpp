#pragma once

#include <algorithm>
#include <cstdint>

#include "gelight/core/progress.hpp"

namespace gelight::detail {

/// Asks a hook once in a while (some milliseconds) as vertices have their turn.
class Watch {
 public:
  /// `steps` is how many are expected; where there are more, the share done stays at 1.
  Watch(const CancelHook& hook, std::int64_t steps, const char* what)
      : hook_(hook), share_(1.0 / static_cast<double>(std::max<std::int64_t>(1, steps))),
        what_(what) {}

  void step() {
    if (++done_ % between == 0 && hook_) {
      hook_.check(std::min(1.0, static_cast<double>(done_) * share_), what_);
    }
  }

 private:
  static constexpr std::int64_t between = 8192;

  const CancelHook& hook_;
  double share_;
  const char* what_;
  std::int64_t done_ = 0;
};

}  // namespace gelight::detail
