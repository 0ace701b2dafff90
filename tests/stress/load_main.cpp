#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <new>
#include <string>
#include <vector>

#include "gelight/geodesic/exact.hpp"
#include "gelight/mesh/shapes.hpp"
#include "stress/stress.hpp"
#include "support/hard_meshes.hpp"

// stress_load           a short run: 10,201 vertices, 500 solves (CTest)
// stress_load long      to 2,563,201 vertices, 10,000 solves; many minutes and some GB
// stress_load cells N   the solvers alone, on sheets of (N / 2 + 1)^2 and (N + 1)^2 vertices
// Prints seconds and peak memory of every solver, and those a vertex; fails where memory grows from
// solve to solve or cancelling takes more than 50 ms.

namespace {

std::atomic<std::size_t> allocated = 0;  // bytes ever asked for

}  // namespace

[[gnu::noinline]] void* operator new(std::size_t size) {
  allocated += size;
  if (void* const memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  allocated += size;
  return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

using namespace gelight;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

int failures = 0;
void expect(bool holds, const std::string& what) {
  if (holds) return;
  std::printf("FAILED: %s\n", what.c_str());
  ++failures;
}

bool within(const std::vector<double>& distance, double most) {
  return std::all_of(distance.begin(), distance.end(),
                     [most](double d) { return d >= 0 && d < most; });
}

struct Cost {
  double set_up = 0, query = 0;  // processor seconds
  double megabytes = 0;          // the peak beyond the mesh
  bool is_sound = false;
};

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// In a process of its own, so that its peak of memory is, too.
Cost cost_of(const stress::Method& method, const Mesh<double>& mesh, double farthest) {
  void* const shared =
      mmap(nullptr, sizeof(Cost), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) throw std::bad_alloc();
  Cost& cost = *new (shared) Cost;
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    const double before = peak_megabytes(), begin = processor_seconds();
    const auto query = method.make(mesh, stress::Precision::in_double);
    const double made = processor_seconds();
    const auto distance = query->distance(stress::from(0));
    cost = {made - begin, processor_seconds() - made, peak_megabytes() - before,
            within(distance, farthest)};
    _exit(0);
  }
  if (child > 0) waitpid(child, nullptr, 0);
  const Cost result = cost;
  munmap(shared, sizeof(Cost));
  return result;
}

// Jittered sheets, each of four times as many vertices as the last. What grows with more than the
// 1.1th power of the vertices is named.
void time_solvers(const std::vector<Index>& cells) {
  std::vector<Mesh<double>> sheets;
  for (const Index n : cells) {
    test::Random random(1);
    sheets.push_back(test::jittered_grid(n, 0.2, random));
  }
  for (const auto& method : stress::methods()) {
    Cost last;
    double last_count = 0;
    for (std::size_t i = 0; i < sheets.size(); ++i) {
      const auto count = static_cast<double>(sheets[i].positions.size());
      const Cost cost = cost_of(method, sheets[i], 1.5 * 1.5 * cells[i]);
      expect(cost.is_sound, method.name + " gives what is no distance");
      std::printf("%-26s %9.0f vertices: set-up %7.3f s, query %7.3f s, peak %6.0f MB;",
                  method.name.c_str(), count, cost.set_up, cost.query, cost.megabytes);
      std::printf(" a vertex %6.2f us, %6.2f us, %5.0f bytes", 1e6 * cost.set_up / count,
                  1e6 * cost.query / count, 0x1p20 * cost.megabytes / count);
      const auto name_growth = [&](const char* what, double before, double now) {
        if (i == 0 || !(before > 0)) return;
        const double power = std::log(now / before) / std::log(count / last_count);
        if (power > 1.1) std::printf("; %s grew with the power %.2f", what, power);
      };
      name_growth("set-up", last.set_up, cost.set_up);
      name_growth("query", last.query, cost.query);
      name_growth("memory", last.megabytes, cost.megabytes);
      std::printf("\n");
      last = cost;
      last_count = count;
    }
  }
}

void no_growth(int solves) {
  const auto mesh = icosphere<double>(4);
  const ExactSolver solver(mesh);
  const auto count = static_cast<Index>(mesh.positions.size());
  const auto solve = [&](int k) { (void)solver.distance(static_cast<Index>(k) * 7 % count); };
  for (int k = 0; k < 50; ++k) solve(k);
  const double before = peak_megabytes();
  const std::size_t asked_before = allocated;
  for (int k = 50; k < 50 + solves; ++k) solve(k);
  const double bytes = static_cast<double>(allocated - asked_before) / solves;
  std::printf("%d exact solves: memory grew by %.1f MB, %.0f bytes asked for in each\n", solves,
              peak_megabytes() - before, bytes);
  expect(peak_megabytes() - before < 4, "memory grows from solve to solve");
  // Its result, twice (as doubles and as asked for), and the list of sources.
  expect(bytes < 17.0 * count + 1000, "a used solver asks for more than its result");
}

// The same disc of faces on meshes of one and four times as many vertices. What a query costs
// beyond the disc is clearing a few numbers per vertex and half-edge.
void bounded(int level) {
  for (const int k : {level, level + 1}) {
    const auto mesh = icosphere<double>(k);
    const ExactSolver solver(mesh, {.max_distance = 20 * std::ldexp(1.1, -k)});
    std::size_t reached = 0;
    for (const double d : solver.distance(Index{12})) reached += d < unreachable<double>;
    const auto begin = Clock::now();
    for (int again = 0; again < 20; ++again) (void)solver.distance(Index{12});
    std::printf("max_distance: %zu of %zu vertices reached, %.3f ms a query\n", reached,
                mesh.positions.size(), 1e3 * since(begin) / 20);
  }
}

void cancels(int level) {
  const ExactSolver solver(icosphere<double>(level));
  std::vector<double> lates;
  for (const double after : {0.0, 0.01, 0.1}) {
    const auto begin = Clock::now();
    double asked_at = 0, longest = 0;
    try {
      (void)solver.solve(Index{0}, {.cancelled = [&] {
                           longest = std::max(longest, since(begin) - asked_at);
                           asked_at = since(begin);
                           return asked_at > after;
                         }});
      std::printf("solved before it could be cancelled\n");
    } catch (const Cancelled&) {
      const double late = since(begin) - asked_at + longest;
      std::printf("cancelled after %.0f ms: at most %.1f ms late\n", 1e3 * after, 1e3 * late);
      lates.push_back(late);
    }
  }
  // The median, since others use the machine too, and the first solve has memory to fetch.
  std::sort(lates.begin(), lates.end());
  expect(lates.empty() || lates[lates.size() / 2] < 0.05, "cancelling takes more than 50 ms");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 2 && std::string(argv[1]) == "cells") {
    const Index cells = static_cast<Index>(std::atoi(argv[2]));
    time_solvers({cells / 2, cells});
    return failures > 0 ? 1 : 0;
  }
  const bool is_long = argc > 1 && std::string(argv[1]) == "long";
  // First, while there is no memory left over that processes made of this one could use again.
  time_solvers(is_long ? std::vector<Index>{400, 800, 1600} : std::vector<Index>{50, 100});
  cancels(is_long ? 8 : 6);
  no_growth(is_long ? 10000 : 500);
  bounded(is_long ? 7 : 4);
  return failures > 0 ? 1 : 0;
}
