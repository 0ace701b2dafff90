#include "gelight/core/parallel.hpp"

#include <doctest/doctest.h>

#if defined(__GLIBC__)
#include <pthread.h>
#endif

#include <array>
#include <atomic>
#include <mutex>
#include <set>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

using gelight::Index;
using gelight::parallel_for;

TEST_CASE("every index once, on any number of threads") {
  for (const unsigned threads : {0u, 1u, 2u, 7u}) {
    for (const Index count : {0, 1, 5, 1000}) {
      std::vector<std::atomic<int>> calls(static_cast<std::size_t>(count));
      parallel_for(count, threads, [&](Index i) { ++calls[static_cast<std::size_t>(i)]; });
      for (const auto& n : calls) CHECK(n == 1);
    }
  }
}

TEST_CASE("no more threads than asked for, and the caller's on its own for one") {
  std::set<std::thread::id> seen;
  std::mutex mutex;
  const auto note = [&](Index) {
    const std::lock_guard lock(mutex);
    seen.insert(std::this_thread::get_id());
  };
  parallel_for(100, 1, note);
  CHECK(seen == std::set{std::this_thread::get_id()});
  parallel_for(100, 3, note);
  CHECK(seen.size() <= 3);
}

TEST_CASE("an exception comes out, after every thread has ended") {
  for (const unsigned threads : {1u, 2u}) {
    std::atomic<int> calls = 0;
    CHECK_THROWS_WITH_AS(parallel_for(1000, threads,
                                      [&](Index i) {
                                        ++calls;
                                        if (i == 3) throw std::runtime_error("three");
                                      }),
                         "three", std::runtime_error);
    CHECK(calls < 1000);
  }
}

#if defined(__GLIBC__)
namespace {

// While this is there, no thread starts: none finds room for its stack.
class NoThreads {
 public:
  NoThreads() {
    pthread_getattr_default_np(&before_);
    pthread_attr_t greedy;
    pthread_attr_init(&greedy);
    pthread_attr_setstacksize(&greedy, std::size_t{1} << 60);
    pthread_setattr_default_np(&greedy);
    pthread_attr_destroy(&greedy);
  }
  NoThreads(const NoThreads&) = delete;
  NoThreads& operator=(const NoThreads&) = delete;
  ~NoThreads() {
    pthread_setattr_default_np(&before_);
    pthread_attr_destroy(&before_);
  }

 private:
  pthread_attr_t before_;
};

}  // namespace

TEST_CASE("the caller's thread does all the work where the machine gives no other") {
  const NoThreads none;
  REQUIRE_THROWS_AS(std::thread([] {}).join(), std::system_error);
  for (const unsigned threads : {0u, 2u, 7u}) {
    std::vector<int> calls(1000);
    parallel_for(1000, threads, [&](Index i) { ++calls[static_cast<std::size_t>(i)]; });
    CHECK(calls == std::vector<int>(1000, 1));
    CHECK_THROWS_WITH_AS(parallel_for(3, threads,
                                      [](Index i) {
                                        if (i == 1) throw std::runtime_error("one");
                                      }),
                         "one", std::runtime_error);
  }
}
#endif
