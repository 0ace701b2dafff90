#include "gelight/core/array.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "gelight/core/array.hpp"
#include "gelight/core/types.hpp"

using gelight::detail::Array;

namespace {

// What std::vector does is the truth, for values of any kind.
template <class T, class Make>
void compare(const Make& make) {
  std::mt19937 random(7);
  Array<T> ours;
  std::vector<T> theirs;
  for (int step = 0; step < 4000; ++step) {
    const auto count = static_cast<std::size_t>(random() % 40);
    const T value = make(static_cast<int>(random() % 1000));
    switch (random() % 9) {
      case 0:
        ours.resize(count), theirs.resize(count);
        break;
      case 1:
        ours.resize(count, value), theirs.resize(count, value);
        break;
      case 2:
        ours.assign(count, value), theirs.assign(count, value);
        break;
      case 3:
        ours.reserve(count), theirs.reserve(count);
        break;
      case 4:
        if (!theirs.empty()) ours.pop_back(), theirs.pop_back();
        break;
      case 5: {
        Array<T> copy(ours), other(theirs.begin(), theirs.end());
        CHECK(copy == other);
        ours = std::move(copy);
        break;
      }
      case 6: {
        Array<T> copy;
        copy = ours;
        copy.emplace_back(value);
        CHECK(!(copy == ours));
        ours.swap(copy);
        theirs.push_back(value);
        break;
      }
      default:
        ours.push_back(value), theirs.push_back(value);
        break;
    }
    REQUIRE(ours.size() == theirs.size());
    REQUIRE(ours.capacity() >= ours.size());
    REQUIRE(std::ranges::equal(ours, theirs));
    REQUIRE(std::vector<T>(ours) == theirs);
  }
}

struct alignas(64) Wide {
  double value = 0;
  bool operator==(const Wide&) const = default;
};

// Throws when it is copied often, and counts how many there are.
struct Throwing {
  static inline int alive = 0, copies_left = 0;
  Throwing() { ++alive; }
  Throwing(const Throwing&) {
    if (copies_left-- == 0) throw std::runtime_error("enough");
    ++alive;
  }
  Throwing(Throwing&&) noexcept { ++alive; }
  Throwing& operator=(const Throwing&) = default;
  ~Throwing() { --alive; }
};

}  // namespace

TEST_CASE("an array is what a vector is") {
  compare<int>([](int i) { return i; });
  compare<double>([](int i) { return i / 3.0; });
  compare<char>([](int i) { return static_cast<char>(i % 100); });
  compare<std::array<float, 3>>([](int i) {
    return std::array{1.0f, static_cast<float>(i), 2.0f};
  });
  compare<std::string>([](int i) { return std::string(static_cast<std::size_t>(i % 60), 'x'); });
  compare<Wide>([](int i) { return Wide{i / 7.0}; });
}

TEST_CASE("an array of many pages keeps what it has as it grows") {
  constexpr int count = 300'000;  // 2.4 MB, so that large pages have room
  Array<double> values;
  for (int i = 0; i < 10; ++i) values.push_back(i);
  values.resize(count, 7.0);
  values.reserve_for_all(3 * count);
  CHECK(values.capacity() == std::size_t{3} * count);
  values.resize(std::size_t{2} * count);
  for (int i = 0; i < 2 * count; ++i) {
    if (values[i] != (i < 10 ? i : i < count ? 7 : 0)) FAIL("element " << i << ": " << values[i]);
  }
  values.resize_for_writes(std::size_t{4} * count);
  CHECK(values.size() == std::size_t{4} * count);
  values.resize_for_writes(15);
  CHECK(values == Array<double>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 7, 7, 7, 7, 7});
}

TEST_CASE("an array takes its own elements") {
  Array<std::string> words{"one word that is too long for its place", "two"};
  for (int i = 0; i < 100; ++i) {
    words.push_back(words[i]);
    words.emplace_back(words.front());
  }
  for (const auto& word : words) CHECK((word == words[0] || word == "two"));
  words.resize(1000, words[0]);
  CHECK(words.back() == words.front());
  words.assign(3, words[1]);
  CHECK(words == Array<std::string>{"two", "two", "two"});
  const auto& same = words;
  words = same;
  CHECK(words.size() == 3);
}

TEST_CASE("elements that cannot be copied move, and lie as they must") {
  Array<std::unique_ptr<int>> numbers;
  for (int i = 0; i < 100; ++i) numbers.push_back(std::make_unique<int>(i));
  for (int i = 0; i < 100; ++i) CHECK(*numbers[i] == i);
  Array<Wide> wide(3);
  for (const Wide& w : wide) CHECK(reinterpret_cast<std::uintptr_t>(&w) % 64 == 0);
}

TEST_CASE("nothing is lost where a copy throws, and no size is too large to be refused") {
  {
    Array<Throwing> five(5);
    for (int allowed = 0; allowed < 5; ++allowed) {
      Throwing::copies_left = allowed;
      CHECK_THROWS_AS(Array<Throwing>{five}, std::runtime_error);
      Throwing::copies_left = allowed;
      CHECK_THROWS_AS(Array<Throwing>(five.begin(), five.end()), std::runtime_error);
      Throwing::copies_left = allowed;
      CHECK_THROWS_AS(Array<Throwing>(9, five[0]), std::runtime_error);
      CHECK(Throwing::alive == 5);
    }
  }
  CHECK(Throwing::alive == 0);
  Array<double> none;
  CHECK_THROWS_AS(none.resize(static_cast<std::size_t>(-1)), std::bad_alloc);
  CHECK_THROWS_AS(none.reserve(static_cast<std::size_t>(-1) / 8), std::bad_alloc);
  CHECK(none.empty());
}
