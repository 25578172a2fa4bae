/// Long work while Python goes on.
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

/// Thrown by work that was told to stop, where it has nothing to return.
struct Interruption {};

/// Long work in a thread of its own, and who waits for it.
class Task {
 public:
  /// Told by the work: the stage, and how much of the whole is done, 0 to 1.
  void Report(const std::string& stage, double done);
  /// Asked by the work.
  bool ShouldStop() const { return should_stop_; }
  /// Throws Interruption if the work is to stop.
  void GoOn() const {
    if (should_stop_) throw Interruption();
  }

 private:
  friend void RunInBackground(const pybind11::object& progress,
                              const std::function<void(Task*)>& work);
  using Clock = std::chrono::steady_clock;

  void Finish();
  // Whether the work is done, or is so after a moment.
  bool IsDone();
  // Lets Python see signals, and calls progress if there is news.
  void Tell(const pybind11::object& progress);

  std::atomic<bool> should_stop_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_done_ = false, has_news_ = false;
  std::string stage_;
  double done_ = 0;
  Clock::time_point start_ = Clock::now();
};

/// Runs work without Python's lock. Python's signals and progress(stage, done,
/// seconds_left or None) are served meanwhile, by the thread that calls. If one
/// of them raises, the work is told to stop, and that exception leaves here.
void RunInBackground(const pybind11::object& progress,
                     const std::function<void(Task*)>& work);

}  // namespace raygrid

#endif  // RAYGRID_PYTHON_BACKGROUND_H
