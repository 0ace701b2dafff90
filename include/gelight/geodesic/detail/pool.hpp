#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace gelight::detail {

/// Memory of earlier queries, to be used again: one piece for each that ever ran at the same time.
template <class Workspace>
class Pool {
 public:
  /// A workspace as its last user left it, for as long as this lives.
  class Borrowed {
   public:
    explicit Borrowed(Pool& pool) : pool_(pool), workspace_(pool.take()) {}
    ~Borrowed() { pool_.give_back(std::move(workspace_)); }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;
    Workspace& operator*() const { return *workspace_; }

   private:
    Pool& pool_;
    std::unique_ptr<Workspace> workspace_;
  };

 private:
  std::unique_ptr<Workspace> take() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return std::make_unique<Workspace>();
    auto workspace = std::move(idle_.back());
    idle_.pop_back();
    return workspace;
  }
  void give_back(std::unique_ptr<Workspace> workspace) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(workspace));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> idle_;
};

}  // namespace gelight::detail
