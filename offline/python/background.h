/// Long computations that Python can interrupt.
#ifndef RAYGRID_PYTHON_BACKGROUND_H
#define RAYGRID_PYTHON_BACKGROUND_H

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>

namespace raygrid {

/// Thrown by interrupted work that has no result.
struct Interruption {};

/// Work in a separate thread, and its communication with the waiting thread.
class Task {
 public:
  /// Called by the work with the stage and the overall fraction done, 0 to 1.
  void Report(const std::string& stage, double done);
  /// Polled by the work.
  bool ShouldStop() const { return should_stop_; }
  /// Throws Interruption if the work should stop.
  void ThrowIfInterrupted() const {
    if (should_stop_) throw Interruption();
  }

 private:
  friend void RunInBackground(const pybind11::object& progress,
                              const std::function<void(Task*)>& work);
  using Clock = std::chrono::steady_clock;

  void Finish();
  // Waits briefly; returns whether the work is done.
  bool IsDone();
  // Handles Python's signals, and calls progress if it has changed.
  void Notify(const pybind11::object& progress);

  std::atomic<bool> should_stop_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_done_ = false, has_news_ = false;
  std::string stage_;
  double done_ = 0;
  Clock::time_point start_ = Clock::now();
};

/// Runs work in a thread, without the GIL. The calling thread handles signals
/// and calls progress(stage, done, seconds_left or None). If one of them raises
/// an exception, stops the work and rethrows the exception.
void RunInBackground(const pybind11::object& progress,
                     const std::function<void(Task*)>& work);

}  // namespace raygrid

#endif  // RAYGRID_PYTHON_BACKGROUND_H
