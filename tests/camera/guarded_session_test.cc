#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "camera_error.h"
#include "camera_session.h"
#include "camera_support.h"
#include "capture_guard_support.h"

namespace raygrid {
namespace {

// Frames of one memory that tell what a script says, at a pace; the last word
// stays.
class ScriptedSource : public FrameSource {
 public:
  ScriptedSource(std::vector<FrameInfo> script, uint64_t num_frames,
                 std::chrono::milliseconds pace)
      : script_(std::move(script)),
        num_frames_(num_frames),
        pace_(pace),
        format_(LensFormat("R8")),
        pixels_(format_.packed_size(), 100) {}

  const StreamFormat& format() const override { return format_; }
  bool reports_crops() const override { return true; }
  void Start() override { next_ = Clock::now(); }
  std::optional<CapturedFrame> Next(
      std::chrono::milliseconds timeout) override {
    if (is_finished()) return std::nullopt;
    if (next_ - Clock::now() > timeout) {
      std::this_thread::sleep_for(timeout);
      return std::nullopt;
    }
    std::this_thread::sleep_until(next_);
    next_ += pace_;
    CapturedFrame frame = {};
    const uint8_t* const planes[3] = {pixels_.data()};
    frame.image = MakeImage(format_, planes);
    frame.info = script_[std::min<size_t>(arrived_, script_.size() - 1)];
    frame.info.sequence = static_cast<uint32_t>(arrived_);
    frame.arrived = Clock::now();
    ++arrived_;
    return frame;
  }
  void Release(const CapturedFrame&) override {}
  bool is_finished() const override { return arrived_ >= num_frames_; }
  std::string fault() const override { return ""; }
  SourceCounts counts() const override { return {arrived_, 0, 0, 0}; }
  void Stop() override {}

 private:
  const std::vector<FrameInfo> script_;
  const uint64_t num_frames_;
  const std::chrono::milliseconds pace_;
  const StreamFormat format_;
  const std::vector<uint8_t> pixels_;
  Clock::time_point next_;
  std::atomic<uint64_t> arrived_{0};
};

struct Ended {
  int code = 0;
  std::string fault, said;
};

Ended RunSession(const CameraArguments& arguments, FrameSource* source) {
  Ended ended;
  testing::internal::CaptureStderr();
  try {
    RunCameraSession(arguments, OpenLens(), Recorded(), source);
  } catch (const CameraError& error) {
    ended.code = static_cast<int>(error.code());
    ended.fault = error.what();
  }
  ended.said = testing::internal::GetCapturedStderr();
  return ended;
}

CameraArguments SessionArguments(bool is_strict) {
  CameraArguments arguments;
  arguments.every_frame = true;
  arguments.is_strict = is_strict;
  arguments.num_threads = 1;
  return arguments;
}

FrameInfo Unfocused() {
  FrameInfo info = AsCalibrated();
  info.lens_position = 5;
  return info;
}

TEST(CaptureSession, SaysOnceAndCountsAtTheEnd) {
  ScriptedSource source({AsCalibrated(), Unfocused()}, 6, kNoTime);
  const Ended ended = RunSession(SessionArguments(false), &source);
  EXPECT_EQ(ended.code, 0) << ended.fault;
  EXPECT_TRUE(Has(ended.said,
                  "raygrid-camera: capture settings differ from calibration: "
                  "lens position is 5 dpt"))
      << ended.said;
  EXPECT_EQ(ended.said.find("lens position is"),
            ended.said.rfind("lens position is"));
  EXPECT_TRUE(Has(ended.said, ", capture settings differ: 5 frames"))
      << ended.said;
  EXPECT_TRUE(Has(ended.said, "6 delivered")) << ended.said;
}

TEST(CaptureSession, StrictEndsWithItsReason) {
  ScriptedSource source({AsCalibrated(), Unfocused()}, 6, kNoTime);
  const Ended ended = RunSession(SessionArguments(true), &source);
  EXPECT_EQ(ended.code, 8);
  EXPECT_TRUE(
      Has(ended.fault,
          "--strict: capture settings differ from calibration: lens position"));
  EXPECT_TRUE(Has(ended.said, "1 delivered")) << ended.said;
  EXPECT_TRUE(Has(ended.said, "capture settings differ: 1 frames"))
      << ended.said;
}

TEST(CaptureSession, StrictEndsWithItsReasonHoweverSlowFramesAre) {
  // Held back: nine frames at 0.3 s, where half a second is waited for one.
  CameraArguments arguments = SessionArguments(true);
  arguments.timeout_s = 0.5;
  ScriptedSource held({Unfocused()}, 100, std::chrono::milliseconds(300));
  Ended ended = RunSession(arguments, &held);
  EXPECT_EQ(ended.code, 8);
  EXPECT_TRUE(Has(ended.fault, "--strict: capture settings differ"))
      << ended.fault;
  EXPECT_TRUE(Has(ended.said, "8 held back")) << ended.said;
  ScriptedSource one({AsCalibrated(), Unfocused()}, 100,
                     std::chrono::milliseconds(450));
  ended = RunSession(arguments, &one);
  EXPECT_TRUE(Has(ended.fault, "--strict: capture settings differ"))
      << ended.fault;
  // A camera that stops still is one that gives no frames.
  ScriptedSource stopped({AsCalibrated()}, 100,
                         std::chrono::milliseconds(1500));
  ended = RunSession(arguments, &stopped);
  EXPECT_EQ(ended.code, 2);
  EXPECT_TRUE(Has(ended.fault, "no frame within")) << ended.fault;
}

TEST(CaptureSession, StrictWritesNoFrameBeforeTheLensIsThere) {
  CameraArguments arguments = SessionArguments(true);
  arguments.num_frames = 2;
  ScriptedSource source({Unfocused(), Unfocused(), AsCalibrated()}, 100,
                        kNoTime);
  const Ended ended = RunSession(arguments, &source);
  EXPECT_EQ(ended.code, 0) << ended.fault;
  EXPECT_TRUE(Has(ended.said, "2 delivered")) << ended.said;
  EXPECT_TRUE(
      Has(ended.said, "capture settings differ: 2 frames (2 held back)"))
      << ended.said;
}

TEST(CaptureSession, QuietSaysFaultsButNoStatistics) {
  CameraArguments arguments = SessionArguments(false);
  arguments.is_quiet = true;
  ScriptedSource source({Unfocused()}, 3, kNoTime);
  const Ended ended = RunSession(arguments, &source);
  EXPECT_EQ(std::count(ended.said.begin(), ended.said.end(), '\n'), 1)
      << ended.said;
  EXPECT_TRUE(Has(ended.said,
                  "capture settings differ from calibration: lens position"))
      << ended.said;
}

TEST(CaptureSession, ACheckTellsTheWordsForPacking) {
  CameraArguments arguments = SessionArguments(false);
  arguments.blob = "front.raygrid";
  arguments.is_check = true;
  ScriptedSource source({AsCalibrated()}, 100, kNoTime);
  testing::internal::CaptureStdout();
  const Ended ended = RunSession(arguments, &source);
  const std::string report = testing::internal::GetCapturedStdout();
  EXPECT_EQ(ended.code, 0);
  EXPECT_EQ(ended.said, "");
  EXPECT_TRUE(
      Has(report,
          "; capture settings: crop=0,0,640,480,lens=2,zoom=1,orientation=1\n"))
      << report;
}

}  // namespace
}  // namespace raygrid
