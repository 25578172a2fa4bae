/// Timings of a stream's steps, for --benchmark.
#ifndef RAYGRID_CAMERA_BENCHMARK_H
#define RAYGRID_CAMERA_BENCHMARK_H

#include <memory>
#include <string>
#include <vector>

#include "frame_source.h"
#include "undistorter.h"

namespace raygrid {

/// Skips 30 frames, in which cameras settle, and times undistortion and output
/// of the next 30. For 30 more it times reading them from their memory.
class Benchmark {
 public:
  static constexpr uint64_t kNumFrames = 90;

  /// source  must outlive this object
  Benchmark(FrameSource* source, unsigned num_threads);
  ~Benchmark();

  /// Returns the source to undistort from, which times reading.
  FrameSource* source();
  /// Counts a frame after its output.
  void Count(const UndistortedFrame& frame, Clock::duration output);
  /// Whether all frames were counted.
  bool is_complete() const { return num_counted_ >= kNumFrames; }
  uint64_t num_counted() const { return num_counted_; }
  /// Formats the timings, one per line. Also benchmarks memory copies.
  std::string Describe() const;

 private:
  class TimedSource;

  const std::unique_ptr<TimedSource> source_;
  const unsigned num_threads_;
  uint64_t num_counted_ = 0;
  Clock::time_point first_, last_;
  std::vector<double> remap_ms_, output_ms_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_BENCHMARK_H
