#ifndef RAYGRID_LIBCAMERA_BOUNDED_QUEUE_H
#define RAYGRID_LIBCAMERA_BOUNDED_QUEUE_H

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <vector>

namespace raygrid {

/// A bounded queue between threads; memory is allocated at construction. A
/// closed queue returns its remaining items and rejects new ones.
template <typename T>
class BoundedQueue {
 public:
  explicit BoundedQueue(size_t capacity) : items_(capacity) {}

  /// Returns the item that was dropped: the oldest one if the queue was full,
  /// the new one if it is closed; otherwise nullopt.
  std::optional<T> Push(T item) {
    std::optional<T> dropped;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (is_closed_) return item;
      if (size_ == items_.size()) dropped = PopOldest();
      items_[(first_ + size_++) % items_.size()] = item;
    }
    changed_.notify_one();
    return dropped;
  }

  /// Removes and returns the oldest item; nullopt on timeout, or if the queue
  /// is closed and empty.
  std::optional<T> Pop(std::chrono::milliseconds timeout) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait_for(lock, timeout,
                      [this] { return size_ > 0 || is_closed_; });
    if (size_ == 0) return std::nullopt;
    return PopOldest();
  }

  void Close() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_closed_ = true;
    }
    changed_.notify_all();
  }

  /// Whether the queue is closed and empty.
  bool is_finished() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return is_closed_ && size_ == 0;
  }

 private:
  T PopOldest() {
    const T item = items_[first_];
    first_ = (first_ + 1) % items_.size();
    --size_;
    return item;
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<T> items_;
  size_t first_ = 0, size_ = 0;
  bool is_closed_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_BOUNDED_QUEUE_H
