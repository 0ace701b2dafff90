#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>

#include "gelight/core/array.hpp"

namespace gelight::detail {

/// Objects that calls borrow one at a time, made when none is free. A copy of a store starts empty.
template <class Item>
class Store {
 public:
  Store() = default;
  Store(const Store&) {}
  Store& operator=(const Store&) { return *this; }

  /// Gives `work` an item that no other call has meanwhile.
  template <class Make, class Work>
  void lend(const Make& make, const Work& work) {
    std::unique_ptr<Item> item = take();
    if (item == nullptr) {
      item = std::make_unique<Item>(make());
      make_room();
    }
    work(*item);
    const std::lock_guard lock(mutex_);
    items_.push_back(std::move(item));
  }

 private:
  // For all items there are, so that none is lost for want of memory when the work is done.
  void make_room() {
    const std::lock_guard lock(mutex_);
    items_.reserve(++made_);
  }

  [[nodiscard]] std::unique_ptr<Item> take() {
    const std::lock_guard lock(mutex_);
    if (items_.empty()) return nullptr;
    auto item = std::move(items_.back());
    items_.pop_back();
    return item;
  }

  std::mutex mutex_;
  std::size_t made_ = 0;
  Array<std::unique_ptr<Item>> items_;
};

}  // namespace gelight::detail
