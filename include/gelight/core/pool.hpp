#pragma once

#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <utility>

#include "gelight/core/array.hpp"

namespace gelight::detail {

/// Memory of earlier queries, to be used again: one piece for each that ever ran at the same time.
template <class Workspace>
class Pool {
 public:
  /// A workspace as its last user left it, for as long as this lives. One whose user ended by an
  /// exception may be half done and is not used again.
  class Borrowed {
   public:
    explicit Borrowed(Pool& pool) : pool_(pool), workspace_(pool.take()) {}
    ~Borrowed() {
      if (std::uncaught_exceptions() == exceptions_) pool_.give_back(std::move(workspace_));
    }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;
    Workspace& operator*() const { return *workspace_; }

   private:
    Pool& pool_;
    std::unique_ptr<Workspace> workspace_;
    int exceptions_ = std::uncaught_exceptions();
  };

 private:
  std::unique_ptr<Workspace> take() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) {
      // Room for all, so that giving back takes no memory and cannot fail.
      idle_.reserve(++made_);
      return std::make_unique<Workspace>();
    }
    auto workspace = std::move(idle_.back());
    idle_.pop_back();
    return workspace;
  }
  void give_back(std::unique_ptr<Workspace> workspace) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(workspace));
  }

  std::mutex mutex_;
  std::size_t made_ = 0;
  Array<std::unique_ptr<Workspace>> idle_;
};

}  // namespace gelight::detail
