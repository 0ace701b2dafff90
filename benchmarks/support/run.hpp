#pragma once

// A benchmark's main, which writes down how the numbers came about.

#include <benchmark/benchmark.h>

#include <fstream>
#include <string>
#include <vector>

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

/// Leaves a row out for something that is not there, which is no failure.
inline void leave_out(benchmark::State& state, const std::string& why) {
  state.SkipWithError(("skipped: " + why).c_str());
}

/// Whether a row is wrong, rather than measured or left out. (Google Benchmark has renamed these.)
template <class Run>
bool is_wrong(const Run& run) {
  const auto& words = [&]() -> const std::string& {
    if constexpr (requires { run.skip_message; }) {
      return run.skip_message;
    } else {
      return run.error_message;
    }
  }();
  return !words.empty() && !words.starts_with("skipped: ");
}

/// Shows rows as --benchmark_format asks, and keeps in mind whether one is wrong.
class Watcher : public benchmark::BenchmarkReporter {
 public:
  [[nodiscard]] bool saw_wrong() const { return saw_wrong_; }

  bool ReportContext(const Context& context) override { return shown_->ReportContext(context); }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) saw_wrong_ = saw_wrong_ || is_wrong(run);
    shown_->ReportRuns(runs);
  }
  void Finalize() override { shown_->Finalize(); }

 private:
  benchmark::BenchmarkReporter* shown_ =
      benchmark::CreateDefaultDisplayReporter();  // its library's
  bool saw_wrong_ = false;
};

/// What run returns if a row is wrong; all others are measured all the same.
constexpr int wrong_row = 3;

/// Runs what is registered; `wrong_row` if one is. The commit is passed in as
/// --benchmark_context=commit=...
inline int run(int argc, char** argv) {
  benchmark::AddCustomContext("compiler", compiler());
  benchmark::AddCustomContext("flags", GELIGHT_FLAGS);
  benchmark::AddCustomContext("cpu", processor());
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  Watcher watcher;
  benchmark::RunSpecifiedBenchmarks(&watcher);
  benchmark::Shutdown();
  return watcher.saw_wrong() ? wrong_row : 0;
}

}  // namespace gelight::bench
