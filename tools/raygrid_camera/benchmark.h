/// Times of a stream's steps, for --benchmark.
#ifndef RAYGRID_CAMERA_BENCHMARK_H
#define RAYGRID_CAMERA_BENCHMARK_H

#include <memory>
#include <string>
#include <vector>

#include "frame_source.h"
#include "undistorter.h"

namespace raygrid {

/// Skips 30 frames, in which cameras settle, and times undistorting and output
/// of 30. Of 30 more it times how long reading them from their memory takes.
class Benchmark {
 public:
  static constexpr uint64_t kNumFrames = 90;

  /// source  outlives it
  Benchmark(FrameSource* source, unsigned num_threads);
  ~Benchmark();

  /// The source that is to be undistorted, which times reading.
  FrameSource* source();
  /// A frame after its output.
  void Count(const UndistortedFrame& frame, Clock::duration output);
  /// All frames came.
  bool is_complete() const { return num_counted_ >= kNumFrames; }
  uint64_t num_counted() const { return num_counted_; }
  /// The figures, a line each. Takes a moment: it times copies, too.
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
