#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
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

  /// What it says; numbers are written to `digits`, which it is part of then.
  [[nodiscard, gnu::cold]] std::string_view text(char (&digits)[32]) const {
    if (kind_ == Kind::words) return words_;
    if (kind_ == Kind::letter) std::snprintf(digits, sizeof digits, "%c", letter_);
    if (kind_ == Kind::whole) std::snprintf(digits, sizeof digits, "%lld", whole_);
    if (kind_ == Kind::natural) std::snprintf(digits, sizeof digits, "%llu", natural_);
    if (kind_ == Kind::real || kind_ == Kind::single) write_shortest(digits);
    return digits;
  }

 private:
  // As few digits as give the number back: 0.1, not 0.10000000000000001.
  [[gnu::cold]] void write_shortest(char (&digits)[32]) const {
    const bool is_single = kind_ == Kind::single;
    const int most = is_single ? std::numeric_limits<float>::max_digits10
                               : std::numeric_limits<double>::max_digits10;
    const double size = std::abs(real_);
    for (int count = is_single ? std::numeric_limits<float>::digits10
                               : std::numeric_limits<double>::digits10;
         count <= most; ++count) {
      std::snprintf(digits, sizeof digits, "%.*g", count, real_);
      const double read = value_of(digits);
      if ((is_single ? double{static_cast<float>(read)} : read) == size) break;
    }
  }
  // Exact for 15 digits, but for the sign: a whole number and a power of ten that doubles hold, and
  // one operation; else NaN. (strtod adds 14 kB to a WebAssembly program.)
  [[gnu::cold]] static double value_of(const char* text) {
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

// Compiled once, out of the way of whatever asks: a message costs a caller no stream, nor a string
// that grows, which each program would compile.
[[nodiscard, gnu::cold]] inline std::string joined_text(std::initializer_list<Part> parts) {
  char digits[32];
  std::size_t size = 0;
  for (const Part& part : parts) size += part.text(digits).size();
  std::string text(size, ' ');
  char* to = text.data();
  for (const Part& part : parts) {
    for (const char c : part.text(digits)) *to++ = c;
  }
  return text;
}
[[noreturn, gnu::cold]] inline void refuse(std::initializer_list<Part> parts) {
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

// Out of the way of whatever asks.
template <class... Parts>
[[noreturn, gnu::cold, gnu::noinline]] void refuse_parts(Parts... parts) {
  refuse({Part(parts)...});
}

/// Throws InvalidInput unless `valid`; the parts of the message are joined only on failure. (Parts
/// by value, so that this is the same for words of all lengths.)
template <class... Parts>
void require(bool valid, Parts... parts) {
  if (valid) [[likely]] {
    return;
  }
  refuse_parts(parts...);
}

}  // namespace detail
}  // namespace gelight
