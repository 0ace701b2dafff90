#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

// A room of light/traced.hpp.

namespace gelight::detail {

/// Four words of 32 random bits for a counter and a key: the same for the same, whoever asks and in
/// whatever order (Philox4x32-10: Salmon, Moraes, Dror, Shaw 2011, doi:10.1145/2063384.2063405).
[[nodiscard]] inline std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                                         std::array<std::uint32_t, 2> key) {
  const auto high = [](std::uint64_t product) { return static_cast<std::uint32_t>(product >> 32); };
  const auto low = [](std::uint64_t product) { return static_cast<std::uint32_t>(product); };
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53} * counter[0];
    const std::uint64_t b = std::uint64_t{0xCD9E8D57} * counter[2];
    counter = {high(b) ^ counter[1] ^ key[0], low(b), high(a) ^ counter[3] ^ key[1], low(a)};
    key[0] += 0x9E3779B9;
    key[1] += 0xBB67AE85;
  }
  return counter;
}

/// Four random numbers within (0, 1), neither end among them, for a step of a path.
[[nodiscard]] inline std::array<double, 4> uniforms(std::uint64_t seed, std::uint64_t path,
                                                    std::uint32_t step) {
  const auto bits =
      philox({static_cast<std::uint32_t>(path), static_cast<std::uint32_t>(path >> 32), step, 0},
             {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
  std::array<double, 4> numbers{};
  for (std::size_t i = 0; i < 4; ++i) numbers[i] = (bits[i] + 0.5) * 0x1p-32;
  return numbers;
}

}  // namespace gelight::detail
