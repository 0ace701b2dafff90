#pragma once

// A benchmark's main, which writes down how the numbers came about.

#include <benchmark/benchmark.h>

#include <fstream>
#include <string>

namespace gelight::bench {

inline std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

/// Runs what is registered; the commit is passed in as --benchmark_context=commit=...
inline int run(int argc, char** argv) {
#ifdef __clang__
  benchmark::AddCustomContext("compiler", "clang++ " __clang_version__);
#else
  benchmark::AddCustomContext("compiler", "g++ " __VERSION__);
#endif
  benchmark::AddCustomContext("flags", GELIGHT_FLAGS);
  benchmark::AddCustomContext("cpu", processor());
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

}  // namespace gelight::bench
