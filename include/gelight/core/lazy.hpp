#pragma once

#include <atomic>
#include <mutex>

namespace gelight::detail {

/// A value that is made when it is first asked for, by one of the threads that ask. (Less to
/// compile than std::call_once and std::optional, of which there would be one a kind of value.)
template <class T>
class Lazy {
 public:
  Lazy() = default;
  Lazy(const Lazy&) = delete;
  Lazy& operator=(const Lazy&) = delete;
  ~Lazy() { delete value_.load(std::memory_order_relaxed); }

  /// Where `make()` throws, the next to ask makes it.
  [[nodiscard]] const T& get(const auto& make) const {
    if (const T* const made = value_.load(std::memory_order_acquire)) return *made;
    const std::lock_guard lock(mutex_);
    if (const T* const made = value_.load(std::memory_order_relaxed)) return *made;
    const T* const made = new T(make());
    value_.store(made, std::memory_order_release);
    return *made;
  }

 private:
  mutable std::atomic<const T*> value_ = nullptr;
  mutable std::mutex mutex_;
};

}  // namespace gelight::detail
