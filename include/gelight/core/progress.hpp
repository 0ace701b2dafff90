#pragma once

#include <algorithm>
#include <concepts>
#include <functional>
#include <stdexcept>
#include <utility>

#include "gelight/core/error.hpp"

namespace gelight {

/// What long work throws when its caller's hook ends it; nothing has been written then.
class Cancelled : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What work throws that would take more memory than its options allow; nothing has been written
/// then, and what it took is given back.
class MemoryLimit : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The one hook of all long work: asked now and then while it lasts, some milliseconds apart, it
/// answers true to have the work end with Cancelled. Steps of a solver's set-up that are linear in
/// the mesh, of a microsecond a vertex at most, may be one step each.
///
/// Made from any callable `() -> bool`, or `(double done) -> bool` that is also told how much of
/// the work is done: a share from 0 to 1 that never decreases, an estimate where the work is not
/// known beforehand. It is called by the thread that called the library. An exception that it
/// throws passes through as Cancelled would.
class CancelHook {
 public:
  CancelHook() = default;
  /// Asks a callable; an empty std::function is no hook.
  template <class F>
  requires(!std::same_as<F, CancelHook> && !std::predicate<F&, double>) &&
      std::predicate<F&> CancelHook(F asks) {
    if (is_there(asks))
      ask_ = [asks = std::move(asks)](double) mutable { return static_cast<bool>(asks()); };
  }
  /// Tells a callable how much is done, and asks it; also one that need not be told.
  template <class F>
  requires(!std::same_as<F, CancelHook>) && std::predicate<F&, double> CancelHook(F asks) {
    if (is_there(asks))
      ask_ = [asks = std::move(asks)](double done) mutable {
        return static_cast<bool>(asks(done));
      };
  }

  /// Whether there is anyone to ask.
  explicit operator bool() const { return static_cast<bool>(ask_); }

  /// Throws Cancelled where the answer is yes. `what` was under way, in words.
  void check(double done, const char* what) const {
    if (ask_ && ask_(of_whole(std::clamp(done, 0.0, 1.0))))
      throw Cancelled(detail::joined_text({what, " was cancelled"}));
  }

  /// The hook for a part of the work, from one share of the whole to another.
  [[nodiscard]] CancelHook part(double from, double to) const {
    CancelHook of_part = *this;
    of_part.from_ = of_whole(from);
    of_part.to_ = of_whole(to);
    return of_part;
  }

 private:
  template <class F>
  static bool is_there(const F& asks) {
    if constexpr (requires { static_cast<bool>(asks); }) return static_cast<bool>(asks);
    return true;
  }

  // A part ends at just the share where the next one begins, and exceeds it nowhere.
  [[nodiscard]] double of_whole(double done) const {
    return done == 1 ? to_ : std::min(to_, from_ + done * (to_ - from_));
  }

  std::function<bool(double)> ask_;
  double from_ = 0, to_ = 1;  // of the whole work
};

}  // namespace gelight
