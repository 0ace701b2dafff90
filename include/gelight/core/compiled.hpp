#pragma once

// What is compiled once, for float and double, where GELIGHT_COMPILED is defined: programs that
// define it compile in a fraction of the time, and link gelight.cpp (CMake's target
// gelight::compiled does both). The same code as without, so the same results.
//
// A door x.hpp declares; what it declares is done in x/body.hpp. That is read with the door where
// the headers are all there is, and in gelight.cpp, for which each body says what it makes
// (GELIGHT_MAKES_COMPILED); other programs that define GELIGHT_COMPILED never read it. Where
// declaration and body stand together, the door says below them what is compiled once.

#if !defined(GELIGHT_COMPILED) || defined(GELIGHT_MAKES_COMPILED)
#define GELIGHT_BODIES
#endif

/// In front of functions that are no templates and have their body elsewhere.
#if defined(GELIGHT_COMPILED)
#define GELIGHT_INLINE
#else
#define GELIGHT_INLINE inline
#endif

/// In front of explicit instantiations in doors: `extern` where they are declared, nothing in
/// gelight.cpp, where they are made.
#if defined(GELIGHT_MAKES_COMPILED)
#define GELIGHT_ONCE
#else
#define GELIGHT_ONCE extern
#endif
