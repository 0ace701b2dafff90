#pragma once

// What only one thread may use at a time, though Python's threads run while the library works.

#include <algorithm>
#include <string>
#include <vector>

#include "gelight/core/error.hpp"

/// An object's use by one thread, from here to the end of the scope. Throws InvalidInput where
/// another uses it. Made and ended by who holds the interpreter; nothing, for no object.
class OneAtATime {
 public:
  OneAtATime(const void* object, const char* what) : object_(object) {
    if (object_ == nullptr) return;
    gelight::detail::require(std::find(used().begin(), used().end(), object_) == used().end(), what,
                             " is in use by another thread");
    used().push_back(object_);
  }
  OneAtATime(const OneAtATime&) = delete;
  OneAtATime& operator=(const OneAtATime&) = delete;
  ~OneAtATime() {
    if (object_ != nullptr) std::erase(used(), object_);
  }

 private:
  static std::vector<const void*>& used() {
    static std::vector<const void*> objects;
    return objects;
  }

  const void* object_;
};
