#pragma once

// A benchmark's main, which writes down how the numbers came about.

#include <benchmark/benchmark.h>

#include <fstream>
#include <string>

#include "../../examples/support/plain_words.hpp"

namespace gelight::bench {

inline std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

inline std::string compiler() {
#ifdef __clang__
  return "clang++ " __clang_version__;
#else
  return "g++ " __VERSION__;
#endif
}

/// Runs what is registered; the commit is passed in as --benchmark_context=commit=...
inline int run(int argc, char** argv) {
  benchmark::AddCustomContext("compiler", compiler());
  benchmark::AddCustomContext("flags", GELIGHT_FLAGS);
  benchmark::AddCustomContext("cpu", processor());
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

}  // namespace gelight::bench
