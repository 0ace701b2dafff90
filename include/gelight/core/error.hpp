#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace gelight {

/// What every function throws on input it cannot use; the text names the value and where it was
/// found. Thrown before anything is written.
class InvalidInput : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

namespace detail {

/// Throws InvalidInput unless `valid`; the parts of the message are joined only on failure.
template <class... Parts>
void require(bool valid, const Parts&... parts) {
  if (valid) [[likely]] {
    return;
  }
  std::ostringstream text;
  text.precision(17);
  (text << ... << parts);
  throw InvalidInput(text.str());
}

}  // namespace detail
}  // namespace gelight
