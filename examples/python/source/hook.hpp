#pragma once

// How long work in C++ is ended from Python.

#include <pybind11/pybind11.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "gelight/core/progress.hpp"

/// Asks the interpreter for Ctrl-C some ten times a second, and a callable of the caller's, if
/// there is one, each time: `cancelled(done: float) -> bool`. What either raises ends the work.
class PythonHook {
 public:
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
