#include "python/background.h"

#include <exception>
#include <thread>

namespace raygrid {

namespace py = pybind11;

void Task::Report(const std::string& stage, double done) {
  const std::lock_guard<std::mutex> lock(mutex_);
  has_news_ = has_news_ || stage != stage_ || done != done_;
  stage_ = stage;
  done_ = done;
}

void Task::Finish() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_done_ = true;
  changed_.notify_all();
}

bool Task::IsDone() {
  constexpr std::chrono::milliseconds kPollInterval(50);
  std::unique_lock<std::mutex> lock(mutex_);
  return changed_.wait_for(lock, kPollInterval, [this] { return is_done_; });
}

void Task::Notify(const py::object& progress) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  std::string stage;
  double done = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!has_news_ || progress.is_none()) return;
    has_news_ = false;
    stage = stage_;
    done = done_;
  }
  const double elapsed =
      std::chrono::duration<double>(Clock::now() - start_).count();
  py::object left = py::none();
  if (done > 0.02) left = py::float_(elapsed * (1 - done) / done);
  progress(stage, done, left);
}

void RunInBackground(const py::object& progress,
                     const std::function<void(Task*)>& work) {
  Task task;
  std::exception_ptr work_exception, python_exception;
  std::thread thread([&] {
    try {
      work(&task);
    } catch (...) {
      work_exception = std::current_exception();
    }
    task.Finish();
  });
  {
    const py::gil_scoped_release released;
    while (!task.IsDone()) {
      const py::gil_scoped_acquire acquired;
      try {
        task.Notify(progress);
      } catch (...) {
        python_exception = std::current_exception();
        task.should_stop_ = true;
        break;
      }
    }
    thread.join();
  }
  if (!python_exception) task.Notify(progress);
  if (python_exception) std::rethrow_exception(python_exception);
  if (work_exception) std::rethrow_exception(work_exception);
}

}  // namespace raygrid
