#include "benchmark.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace raygrid {
namespace {

constexpr uint64_t kNumSkipped = 30, kNumTimed = 30;
// Exceeds the cache size, so that copies read from memory.
constexpr size_t kOtherBytes = size_t{64} << 20;
// Memory with a larger slowdown is assumed to be uncached.
constexpr double kMaxSlowdown = 4;

double ToMilliseconds(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto median = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), median, values.end());
  return *median;
}

// Returns the time for copying the rows of a frame.
double CopyPlanes_ms(const StreamFormat& format, const rg_image& image,
                     uint8_t* to) {
  const Clock::time_point start = Clock::now();
  for (int i = 0; i < format.num_planes; ++i) {
    const size_t number = format.planes[i].extent();
    std::memcpy(to, image.planes[i].data, number);
    to += number;
  }
  return ToMilliseconds(Clock::now() - start);
}

size_t CopiedBytes(const StreamFormat& format) {
  size_t number = 0;
  for (int i = 0; i < format.num_planes; ++i)
    number += format.planes[i].extent();
  return number;
}

// Returns the time for copying a number of bytes that are not in a cache.
double CopyOther_ms(size_t number) {
  std::vector<uint8_t> to(number, 1);
  const std::vector<uint8_t> from(std::max(kOtherBytes, 2 * number), 1);
  std::vector<double> times_ms;
  size_t place = 0;
  for (uint64_t k = 0; k < kNumTimed; ++k) {
    const Clock::time_point start = Clock::now();
    std::memcpy(to.data(), from.data() + place, number);
    times_ms.push_back(ToMilliseconds(Clock::now() - start));
    place += number;
    if (place + number > from.size()) place = 0;
  }
  return Median(times_ms);
}

}  // namespace

class Benchmark::TimedSource : public FrameSource {
 public:
  explicit TimedSource(FrameSource* source)
      : source_(source), copy_(CopiedBytes(source->format()), 1) {}

  const StreamFormat& format() const override { return source_->format(); }
  bool reports_crops() const override { return source_->reports_crops(); }
  std::string memory() const override { return source_->memory(); }
  void Start() override { source_->Start(); }

  std::optional<CapturedFrame> Next(
      std::chrono::milliseconds timeout) override {
    const auto frame = source_->Next(timeout);
    if (frame && num_frames_++ >= kNumSkipped + kNumTimed)
      reading_ms_.push_back(
          CopyPlanes_ms(format(), frame->image, copy_.data()));
    return frame;
  }

  void Release(const CapturedFrame& frame) override { source_->Release(frame); }
  bool is_finished() const override { return source_->is_finished(); }
  std::string fault() const override { return source_->fault(); }
  SourceCounts counts() const override { return source_->counts(); }
  StateLock LockState() override { return source_->LockState(); }
  void FocusAt(const LensFocus& focus) override { source_->FocusAt(focus); }
  void UnlockState() override { source_->UnlockState(); }
  void Stop() override { source_->Stop(); }

  // Valid after the end of the stream.
  double reading_ms() const { return Median(reading_ms_); }

 private:
  FrameSource* const source_;
  std::vector<uint8_t> copy_;
  uint64_t num_frames_ = 0;
  std::vector<double> reading_ms_;
};

Benchmark::Benchmark(FrameSource* source, unsigned num_threads)
    : source_(std::make_unique<TimedSource>(source)),
      num_threads_(num_threads) {}

Benchmark::~Benchmark() = default;

FrameSource* Benchmark::source() { return source_.get(); }

void Benchmark::Count(const UndistortedFrame& frame, Clock::duration output) {
  ++num_counted_;
  if (num_counted_ == kNumSkipped) first_ = Clock::now();
  if (num_counted_ <= kNumSkipped || num_counted_ > kNumSkipped + kNumTimed)
    return;
  last_ = Clock::now();
  remap_ms_.push_back(ToMilliseconds(frame.remap_time));
  output_ms_.push_back(ToMilliseconds(output));
}

std::string Benchmark::Describe() const {
  const double reading_ms = source_->reading_ms(), remap_ms = Median(remap_ms_);
  const double copying_ms = CopyOther_ms(CopiedBytes(source_->format()));
  const std::string memory = source_->memory();
  char text[1024];
  std::snprintf(text, sizeof(text),
                "frames_per_second: %.2f\nreading_ms: %.3f\nremap_ms: %.3f\n"
                "output_ms: %.3f\ncopying_ms: %.3f\nremap_per_copy: %.2f\n"
                "memory: %s\ncached: %s\nthreads: %u\n",
                1e3 * kNumTimed / ToMilliseconds(last_ - first_), reading_ms,
                remap_ms, Median(output_ms_), copying_ms, remap_ms / copying_ms,
                memory.empty() ? "this program's" : memory.c_str(),
                reading_ms < kMaxSlowdown * copying_ms ? "yes" : "no",
                num_threads_);
  return text;
}

}  // namespace raygrid
