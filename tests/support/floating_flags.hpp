#pragma once

namespace gelight::test {

/// Whether the compiler leaves the processor's flags to what the program computes: Clang computes
/// more than that, and throws it away, where it optimises.
#if defined(__clang__)
inline constexpr bool keeps_floating_flags = false;
#else
inline constexpr bool keeps_floating_flags = true;
#endif

}  // namespace gelight::test
