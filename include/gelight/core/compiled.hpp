#pragma once

// What is compiled once, for float and double, where GELIGHT_COMPILED is defined: programs that
// define it compile in a fraction of the time, and link gelight.cpp (CMake's target
// gelight::compiled does both). The same code as without, so the same results. Each door declares
// below its bodies what is, so that nobody pays for doors that he does not open.

/// In front of explicit instantiations: `extern` where they are declared, nothing in gelight.cpp,
/// where they are made.
#if !defined(GELIGHT_ONCE)
#define GELIGHT_ONCE extern
#endif
