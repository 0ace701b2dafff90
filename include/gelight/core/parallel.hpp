#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "gelight/core/types.hpp"

namespace gelight {

namespace detail {

/// Threads that are waited for when this ends: std::jthread, which Emscripten's library has not.
class Threads {
 public:
  Threads() = default;
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;
  ~Threads() { join(); }

  /// Whether there is one thread more, which does this work: some machines have none, or no more.
  template <class Work>
  bool start([[maybe_unused]] const Work& work) {
#if defined(__EMSCRIPTEN__) && !defined(__EMSCRIPTEN_PTHREADS__)
    return false;  // where exceptions are switched off, too
#else
    try {
      threads_.emplace_back(work);
      return true;
    } catch (const std::system_error&) {
      return false;
    }
#endif
  }
  void join() {
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

 private:
  std::vector<std::thread> threads_;
};

}  // namespace detail

/// Calls `work(i)` for every i in [0, count), in any order, on up to `threads` threads at once, the
/// caller's among them (0: as many as the machine has), on fewer where the machine gives no more.
/// Returns when all is done. An exception ends the calls not yet begun and is thrown again here, of
/// several the first. Starting a thread takes some 20 us.
template <class Work>
void parallel_for(Index count, unsigned threads, const Work& work) {
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  std::atomic<Index> next = 0;
  std::exception_ptr failure;
  std::mutex failing;
  const auto run = [&] {
    try {
      for (Index i = next++; i < count; i = next++) work(i);
    } catch (...) {
      const std::lock_guard lock(failing);
      if (!failure) failure = std::current_exception();
      next = count;
    }
  };
  detail::Threads others;
  const auto useful = static_cast<unsigned>(std::max(Index{1}, count));
  for (unsigned t = 1; t < std::min(threads, useful) && others.start(run); ++t) continue;
  run();
  others.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace gelight
