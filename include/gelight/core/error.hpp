#pragma once

#include <cmath>
#include <concepts>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

namespace gelight {

/// What every function throws on input it cannot use; the text names the value and where it was
/// found. Thrown before anything is written.
class InvalidInput : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

namespace detail {

/// A piece of a message: words or a number.
class Part {
 public:
  Part(std::string_view words) : words_(words) {}
  Part(const std::string& words) : words_(words) {}
  Part(const char* words) : words_(words) {}
  Part(char letter) : kind_(Kind::letter), letter_(letter) {}
  Part(std::signed_integral auto number) : kind_(Kind::whole), whole_(number) {}
  Part(std::unsigned_integral auto number) : kind_(Kind::natural), natural_(number) {}
  Part(float number) : kind_(Kind::single), real_(double{number}) {}
  Part(std::floating_point auto number) : kind_(Kind::real), real_(static_cast<double>(number)) {}

  void append_to(std::string& text) const {
    if (kind_ == Kind::words) text += words_;
    if (kind_ == Kind::letter) text += letter_;
    if (kind_ == Kind::whole) text += std::to_string(whole_);
    if (kind_ == Kind::natural) text += std::to_string(natural_);
    if (kind_ == Kind::real) text += shortest(real_);
    if (kind_ == Kind::single) text += shortest(static_cast<float>(real_));
  }

 private:
  // As few digits as give the number back: 0.1, not 0.10000000000000001.
  template <std::floating_point T>
  static std::string shortest(T number) {
    using Limits = std::numeric_limits<T>;
    char digits[32];
    for (int count = Limits::digits10; count <= Limits::max_digits10; ++count) {
      std::snprintf(digits, sizeof digits, "%.*g", count, static_cast<double>(number));
      if (static_cast<T>(value_of(digits)) == std::abs(number)) break;
    }
    return digits;
  }
  // Exact for 15 digits, but for the sign: a whole number and a power of ten that doubles hold, and
  // one operation; else NaN. (strtod adds 14 kB to a WebAssembly program.)
  static double value_of(const char* text) {
    double whole = 0, power = 1;
    int exponent = 0;
    for (bool is_fraction = false; *text != 0 && *text != 'e'; ++text) {
      const bool is_digit = '0' <= *text && *text <= '9';
      if (is_digit) {
        whole = 10 * whole + (*text - '0');
        if (is_fraction) --exponent;
      } else if (*text != '-') {
        is_fraction = true;  // by the point or comma of the locale
      }
    }
    if (*text == 'e') exponent += std::atoi(text + 1);
    if (whole > 0x1p53 || std::abs(exponent) > 22) return std::numeric_limits<double>::quiet_NaN();
    for (int k = std::abs(exponent); k > 0; --k) power *= 10;
    return exponent < 0 ? whole / power : whole * power;
  }

  enum class Kind : char { words, letter, whole, natural, real, single };
  Kind kind_ = Kind::words;
  std::string_view words_;
  union {
    char letter_;
    long long whole_;
    unsigned long long natural_;
    double real_;
  };
};

// Compiled once, out of the way of whatever asks: a message costs a caller no stream.
[[nodiscard]] inline std::string joined_text(std::initializer_list<Part> parts) {
  std::string text;
  for (const Part& part : parts) part.append_to(text);
  return text;
}
[[noreturn]] inline void refuse(std::initializer_list<Part> parts) {
  throw InvalidInput(joined_text(parts));
}

/// Words and numbers, one after the other.
template <class... Parts>
[[nodiscard]] std::string joined(const Parts&... parts) {
  return joined_text({Part(parts)...});
}

/// A number as people read it, in two digits.
[[nodiscard]] inline std::string two_digits(double number) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.2g", number);
  return digits;
}

/// Throws InvalidInput unless `valid`; the parts of the message are joined only on failure.
template <class... Parts>
void require(bool valid, const Parts&... parts) {
  if (valid) [[likely]] {
    return;
  }
  refuse({Part(parts)...});
}

}  // namespace detail
}  // namespace gelight
