#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "gelight/core/progress.hpp"

namespace gelight::detail {

/// Asks a hook once in a while (some milliseconds) as vertices or faces have their turn.
class PeriodicCheck {
 public:
  /// `steps` is how many are expected; where there are more, the share done stays at 1.
  PeriodicCheck(const CancelHook& hook, std::int64_t steps, const char* what)
      : hook_(hook),
        share_(1.0 / static_cast<double>(std::max<std::int64_t>(1, steps))),
        what_(what) {}

  void step() {
    if (--left_ == 0) ask();
  }

 private:
  static constexpr std::int64_t between = 8192, never = std::numeric_limits<std::int64_t>::max();

  [[gnu::noinline]] void ask() {
    done_ += between;
    left_ = between;
    hook_.check(std::min(1.0, static_cast<double>(done_) * share_), what_);
  }

  const CancelHook& hook_;
  double share_;
  const char* what_;
  std::int64_t left_ = hook_ ? between : never;
  std::int64_t done_ = 0;
};

}  // namespace gelight::detail
