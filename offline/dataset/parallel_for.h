#ifndef RAYGRID_DATASET_PARALLEL_FOR_H
#define RAYGRID_DATASET_PARALLEL_FOR_H

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace raygrid {

/// 0 means all cores.
inline int NumThreads(int requested) {
  if (requested > 0) return requested;
  return std::max(1u, std::thread::hardware_concurrency());
}

/// Calls body(i) once for each i in [0, count), on several threads.
/// Deterministic for any number of threads if calls write to separate memory.
/// Uses fewer threads if no more can be created. Rethrows the first exception.
template <typename Body>
void ParallelFor(int count, int num_threads, const Body& body) {
  num_threads = std::min(num_threads, count);
  if (num_threads <= 1) {
    for (int i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<int> next{0};
  std::exception_ptr error;
  std::mutex error_mutex;
  const auto work = [&] {
    for (int i; (i = next++) < count;) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(error_mutex);
        if (!error) error = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::thread> threads;
  try {
    for (int t = 1; t < num_threads; ++t) threads.emplace_back(work);
  } catch (const std::exception&) {  // continue with the existing threads
  }
  work();
  for (std::thread& thread : threads) thread.join();
  if (error) std::rethrow_exception(error);
}

}  // namespace raygrid

#endif  // RAYGRID_DATASET_PARALLEL_FOR_H
