#pragma once

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "command_line.hpp"
#include "durable_file.hpp"

// Numbered pieces of work, dealt to whoever is free: threads of this process, and those of other
// ranks where mpirun started several.
//
//     rank 0   main thread: deals, waits          rank 1   main thread: asks for its workers
//              workers: work                               workers: work
//
// Only main threads call MPI. They sleep between looks, for MPI's own waiting keeps a core busy.

/// MPI from construction to destruction where mpirun or srun has started this process; elsewhere
/// one rank without MPI, which need not work there.
class Ranks {
 public:
  Ranks(int& argc, char**& argv) {
    if (!is_started_by_mpi()) return;
    int provided = 0;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    has_mpi_ = true;
  }
  ~Ranks() {
    if (has_mpi_) MPI_Finalize();
  }
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] bool is_first() const { return rank_ == 0; }

  /// The machine's processors for one process; one for each of several.
  [[nodiscard]] int threads_by_default() const {
    return size_ > 1 ? 1 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }

  /// Rank 0's numbers, at every rank.
  void broadcast(std::vector<int>& numbers) const {
    if (size_ == 1) return;
    int count = static_cast<int>(numbers.size());
    MPI_Bcast(&count, 1, MPI_INT, 0, MPI_COMM_WORLD);
    numbers.resize(static_cast<std::size_t>(count));
    MPI_Bcast(numbers.data(), count, MPI_INT, 0, MPI_COMM_WORLD);
  }

  /// The sum (or the largest) over the ranks, at rank 0.
  ///@{
  [[nodiscard]] std::vector<double> sum(const std::vector<double>& values) const {
    return reduced(values, MPI_SUM);
  }
  [[nodiscard]] double largest(double value) const { return reduced({value}, MPI_MAX)[0]; }
  ///@}

  /// Says why and ends the program on all ranks.
  [[noreturn]] void fail(const std::string& program, const std::string& why) const {
    const std::string who = size_ > 1 ? ", rank " + std::to_string(rank_) : "";
    std::fprintf(stderr, "\n%s%s: %s\n", program.c_str(), who.c_str(), why.c_str());
    std::fflush(stderr);
    if (size_ > 1) MPI_Abort(MPI_COMM_WORLD, 1);
    std::_Exit(1);
  }

 private:
  static bool is_started_by_mpi() {
    for (const char* variable : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}) {
      if (std::getenv(variable) != nullptr) return true;
    }
    return false;
  }

  [[nodiscard]] std::vector<double> reduced(const std::vector<double>& values, MPI_Op op) const {
    if (size_ == 1) return values;
    std::vector<double> result(values.size());
    MPI_Reduce(values.data(), result.data(), static_cast<int>(values.size()), MPI_DOUBLE, op, 0,
               MPI_COMM_WORLD);
    return result;
  }

  int rank_ = 0, size_ = 1;
  bool has_mpi_ = false;
};

/// The main function of a program that works on several ranks: reads its options, and `threads` of
/// each rank as one more; runs it, and ends all ranks with the reason where one fails.
inline int run_on_ranks(int argc, char** argv, CommandLine& line, int& threads,
                        const std::function<void(const Ranks&)>& run) {
  outlive_file_limits();
  const Ranks ranks(argc, argv);
  std::optional<int> asked_threads;
  line.add_within("--threads", asked_threads, 1, 4096,
                  "threads of each rank; by default all of the machine, or 1 under mpirun");
  try {
    line.read(argc, argv);
  } catch (const HelpAsked& help) {
    if (ranks.is_first()) std::printf("%s\n", help.words.c_str());
    return 0;
  } catch (const std::exception& wrong) {
    if (ranks.is_first()) std::fprintf(stderr, "%s: %s\n", line.program().c_str(), wrong.what());
    return 1;
  }
  threads = asked_threads.value_or(ranks.threads_by_default());
  try {
    run(ranks);
  } catch (const std::exception& why) {
    ranks.fail(line.program(), why.what());
  }
  return 0;
}

/// This process's workers.
class Team {
 public:
  using Work = std::function<void(int piece, int thread)>;

  Team(int threads, Work work) : work_(std::move(work)), idle_(threads) {
    for (int t = 0; t < threads; ++t) threads_.emplace_back([this, t] { run(t); });
  }
  ~Team() {
    {
      const std::lock_guard guard(lock_);
      is_over_ = true;
      pieces_.clear();
    }
    given_.notify_all();
  }
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  void give(int piece) {
    {
      const std::lock_guard guard(lock_);
      pieces_.push_back(piece);
      --idle_;
    }
    given_.notify_one();
  }

  /// How many pieces are done; throws what a worker threw.
  [[nodiscard]] int done() {
    const std::lock_guard guard(lock_);
    if (failure_) std::rethrow_exception(failure_);
    return done_;
  }
  [[nodiscard]] int idle() {
    const std::lock_guard guard(lock_);
    return idle_;
  }
  /// Until more than this is done, but no longer than so.
  void wait(int done, std::chrono::microseconds most) {
    std::unique_lock guard(lock_);
    idled_.wait_for(guard, most, [&] { return done_ > done; });
  }

 private:
  void run(int thread) {
    std::unique_lock guard(lock_);
    while (true) {
      given_.wait(guard, [&] { return is_over_ || !pieces_.empty(); });
      if (is_over_) return;
      const int piece = pieces_.front();
      pieces_.pop_front();
      guard.unlock();
      std::exception_ptr failure;
      try {
        work_(piece, thread);
      } catch (...) {
        failure = std::current_exception();
      }
      guard.lock();
      if (failure) failure_ = failure;
      ++done_;
      ++idle_;
      idled_.notify_one();
    }
  }

  Work work_;
  std::mutex lock_;
  std::condition_variable given_, idled_;
  std::deque<int> pieces_;
  int idle_, done_ = 0;
  bool is_over_ = false;
  std::exception_ptr failure_;
  std::vector<std::jthread> threads_;  // last: they use all the rest, and end first
};

namespace ranks_detail {

enum Tag { ask = 1, piece_for_you, farewell };
inline constexpr std::chrono::microseconds look{200}, dealing{1000};

/// What rank 0 knows: what is left, and how much the others have done.
class Dealer {
 public:
  Dealer(const Ranks& ranks, std::span<const int> pieces)
      : pieces_(pieces),
        done_(static_cast<std::size_t>(ranks.size())),
        working_(ranks.size() - 1) {}

  [[nodiscard]] int next() { return next_ < pieces_.size() ? pieces_[next_++] : -1; }

  /// Answers whoever has asked.
  void serve() {
    for (int is_there = 1; working_ > 0;) {
      MPI_Status status;
      MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &is_there, &status);
      if (is_there == 0) return;
      const int from = status.MPI_SOURCE;
      MPI_Recv(&done_[static_cast<std::size_t>(from)], 1, MPI_INT, from, status.MPI_TAG,
               MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      if (status.MPI_TAG == farewell) {
        --working_;
      } else {
        const int piece = next();
        MPI_Send(&piece, 1, MPI_INT, from, piece_for_you, MPI_COMM_WORLD);
      }
    }
  }

  [[nodiscard]] bool others_work() const { return working_ > 0; }
  [[nodiscard]] int others_done() const {
    int sum = 0;
    for (const int done : done_) sum += done;
    return sum;
  }

 private:
  std::span<const int> pieces_;
  std::size_t next_ = 0;
  std::vector<int> done_;
  int working_;
};

/// Asks rank 0 for a piece; -1: none is left.
inline int asked(int done) {
  MPI_Send(&done, 1, MPI_INT, 0, ask, MPI_COMM_WORLD);
  for (int is_there = 0; is_there == 0;) {
    MPI_Iprobe(0, piece_for_you, MPI_COMM_WORLD, &is_there, MPI_STATUS_IGNORE);
    if (is_there == 0) std::this_thread::sleep_for(look);
  }
  int piece = 0;
  MPI_Recv(&piece, 1, MPI_INT, 0, piece_for_you, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return piece;
}

}  // namespace ranks_detail

/// Calls `work(piece, thread)` once for each of the pieces, which all ranks name alike, on all
/// threads of all ranks; calls `told(done)` on rank 0 now and then. Throws what work threw here;
/// the others then wait until `Ranks::fail` ends them.
inline void deal(const Ranks& ranks, std::span<const int> pieces, int threads,
                 const Team::Work& work, const std::function<void(int)>& told) {
  using namespace ranks_detail;
  Dealer dealer(ranks, pieces);
  Team team(threads, work);
  for (bool is_more = true; true;) {
    const int done = team.done();
    if (ranks.is_first()) {
      dealer.serve();
      told(done + dealer.others_done());
    }
    while (is_more && team.idle() > 0) {
      const int piece = ranks.is_first() ? dealer.next() : asked(done);
      is_more = piece >= 0;
      if (is_more) team.give(piece);
    }
    if (!is_more && team.idle() == threads && !(ranks.is_first() && dealer.others_work())) break;
    team.wait(done, ranks.size() > 1 && ranks.is_first() ? dealing : 50 * dealing);
  }
  const int done = team.done();
  if (ranks.is_first()) {
    told(done + dealer.others_done());
  } else {
    MPI_Send(&done, 1, MPI_INT, 0, farewell, MPI_COMM_WORLD);
  }
}
