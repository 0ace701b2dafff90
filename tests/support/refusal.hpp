#pragma once

#include <string>

#include "gelight/core/error.hpp"

namespace gelight::test {

/// What InvalidInput says where `act` throws it, "accepted" where it does not.
template <class Act>
std::string refusal(const Act& act) {
  try {
    act();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace gelight::test
