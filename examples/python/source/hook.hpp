#pragma once

// How long work in C++ is ended from Python.

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "gelight/core/progress.hpp"

/// The end that several threads' work has in common: once one has thrown, the hooks of all that are
/// in `part` answer true, so that nobody waits for what is of no use any more.
class CommonEnd {
 public:
  /// Does a part of the work, on the calling thread.
  template <class Work>
  auto part(const Work& work) {
    const Here here(*this);
    try {
      return work();
    } catch (...) {
      end(std::current_exception());
      throw;
    }
  }
  /// Ends the work, for this reason if there is none yet: those that follow only say that it ended.
  void end(std::exception_ptr why) {
    const std::lock_guard lock(ending_);
    if (!why_) why_ = std::move(why);
    is_over_ = true;
  }
  [[nodiscard]] bool is_over() const { return is_over_; }
  /// Throws the reason. For when all threads have ended.
  void rethrow() const {
    if (why_) std::rethrow_exception(why_);
  }
  /// Whether the work that the calling thread does a part of is over.
  [[nodiscard]] static bool is_over_here() {
    const Here* here = Here::innermost;
    while (here != nullptr && !here->end->is_over_) here = here->before;
    return here != nullptr;
  }

 private:
  // A part that a thread does, within another where a callable of the caller's began this work.
  struct Here {
    explicit Here(const CommonEnd& common) : end(&common), before(innermost) { innermost = this; }
    Here(const Here&) = delete;
    Here& operator=(const Here&) = delete;
    ~Here() { innermost = before; }

    inline static thread_local const Here* innermost = nullptr;
    const CommonEnd* end;
    const Here* before;
  };

  std::mutex ending_;
  std::exception_ptr why_;
  std::atomic<bool> is_over_ = false;
};

/// Asks the interpreter for Ctrl-C some ten times a second, and a callable of the caller's, if
/// there is one, each time: `cancelled(done: float) -> bool`. What either raises ends the work, and
/// so does the common end of several threads' work.
class PythonHook {
 public:
  /// For Ctrl-C alone. Needs no interpreter.
  PythonHook() = default;
  explicit PythonHook(pybind11::object asks) {
    if (asks.is_none()) return;
    if (PyCallable_Check(asks.ptr()) == 0) {
      throw pybind11::type_error("cancelled is " + pybind11::repr(asks).cast<std::string>() +
                                 ", which cannot be called");
    }
    // Copies of a hook come and go while the interpreter is not ours.
    asks_ = std::shared_ptr<pybind11::object>(new pybind11::object(std::move(asks)),
                                              [](pybind11::object* held) {
                                                const pybind11::gil_scoped_acquire acquire;
                                                delete held;
                                              });
  }

  bool operator()(double done) const {
    if (CommonEnd::is_over_here()) return true;
    if (!asks_ && !is_due()) return false;
    const pybind11::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
    return asks_ && static_cast<bool>(pybind11::bool_((*asks_)(done)));
  }

 private:
  static bool is_due() {
    using Clock = std::chrono::steady_clock;
    thread_local Clock::time_point next;
    const auto now = Clock::now();
    if (now < next) return false;
    next = now + std::chrono::milliseconds(100);
    return true;
  }

  std::shared_ptr<pybind11::object> asks_;
};

inline gelight::CancelHook hook_of(pybind11::object asks) { return PythonHook(std::move(asks)); }
