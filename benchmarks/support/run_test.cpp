#include "run.hpp"

// What a benchmark's program returns for a row that is right, left out, or wrong: a test each.

namespace {

void right(benchmark::State& state) {
  for (auto _ : state) benchmark::ClobberMemory();
}
void left_out(benchmark::State& state) { gelight::bench::leave_out(state, "there is no data"); }
void wrong(benchmark::State& state) { state.SkipWithError("the answer is wrong"); }

BENCHMARK(right)->Iterations(1);
BENCHMARK(left_out);
BENCHMARK(wrong);

}  // namespace

int main(int argc, char** argv) { return gelight::bench::run(argc, argv); }
