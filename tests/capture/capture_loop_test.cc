#include "capture_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <thread>

#include "camera_error.h"
#include "capture/board_view.h"
#include "simulation/board_surface.h"
#include "simulation/image_rendering.h"
#include "simulation/simulated_camera.h"
#include "target/board_spec.h"
#include "temporary_folder.h"

namespace raygrid {
namespace {

// A camera that tells its lens's position and can be locked.
class LockableSource : public FrameSource {
 public:
  explicit LockableSource(bool can_lock)
      : can_lock_(can_lock),
        format_(MakeStreamFormat(*FindPixelFormat("R8"), 640, 480, 0)) {}
  const StreamFormat& format() const override { return format_; }
  void Start() override {}
  std::optional<CapturedFrame> Next(std::chrono::milliseconds) override {
    return std::nullopt;
  }
  void Release(const CapturedFrame&) override {}
  bool is_finished() const override { return !fault_.empty(); }
  std::string fault() const override { return fault_; }
  SourceCounts counts() const override { return {}; }
  StateLock LockState() override {
    ++num_locks;
    StateLock lock;
    (can_lock_ ? lock.locked : lock.open).push_back("focus at 2 dioptres");
    return lock;
  }
  void FocusAt(const LensFocus& wanted) override { focus = wanted; }
  void Stop() override {}
  void Fail(const std::string& fault) { fault_ = fault; }

  int num_locks = 0;
  LensFocus focus;

 private:
  const bool can_lock_;
  std::string fault_;
  const StreamFormat format_;
};

// Frames that tests make, one after the other.
class MadeFrames : public LiveFrames {
 public:
  explicit MadeFrames(bool can_lock) : camera_source(can_lock) {}
  std::optional<LiveFrame> Next() override {
    if (frames.empty()) return std::nullopt;
    if (frames.front().pause.count() > 0)
      std::this_thread::sleep_for(frames.front().pause);
    LiveFrame frame = std::move(frames.front().frame);
    frame.arrived = Clock::now();
    frames.erase(frames.begin());
    return frame;
  }
  bool is_finished() const override { return frames.empty(); }
  bool is_live() const override { return true; }
  FrameSource* source() override { return &camera_source; }

  struct Made {
    LiveFrame frame;
    std::chrono::milliseconds pause{0};  // before it
  };
  std::vector<Made> frames;
  LockableSource camera_source;
};

class CaptureLoopTest : public testing::Test {
 protected:
  LiveFrame Render(const Pose& camera_from_board) const {
    const BoardSurface surface(pattern_.boards.front());
    LiveFrame frame;
    frame.image =
        AddNoiseAndQuantize(RenderImage(PixelRays(camera_, 2),
                                        {{&surface, camera_from_board}}, {}, 2),
                            {});
    frame.grey = MakeGreyImage(frame.image);
    return frame;
  }
  Pose PoseOfView(int index) const {
    return *ComputePose(FirstView(index, {640, 480}), pattern_.boards.front(),
                        camera_);
  }

  // Frames of the first views, each twice, since only the second is still.
  void AddView(int index, double lens_position,
               std::chrono::milliseconds pause = {}) {
    LiveFrame frame = Render(PoseOfView(index));
    frame.info.lens_position = static_cast<float>(lens_position);
    for (int k = 0; k < 2; ++k) {
      frame.time_s = time_s_ += 0.033;
      frames_->frames.push_back({frame, k == 0 ? pause : pause * 0});
    }
  }

  // The words of the frames that were still and new.
  std::vector<std::string> Run(bool resume = false) {
    std::vector<CameraStream> cameras(1);
    cameras[0].frames = std::move(frames_);
    PairedFrames frames(std::move(cameras), 0);
    SessionFolder session(folder_ / "session", pattern_, frames.names(),
                          resume);
    CaptureRequests wishes;
    std::vector<std::string> words;
    CaptureViewers viewers;
    viewers.show = [&](const CaptureState& state) {
      const std::string& word = state.word;
      const bool is_end = state.hint == "finished";
      if (!is_end && word != "moving" && word != "known" && word != "busy")
        words.push_back(word);
      remarks_ = state.warnings;
    };
    CaptureLoop(CaptureLoopOptions{}, pattern_, &frames, &session, viewers,
                &wishes)
        .Run();
    session_ = session.cameras().front();
    const auto* const source = static_cast<LockableSource*>(frames.source(0));
    num_locks_ = source->num_locks;
    focus_ = source->focus;
    return words;
  }

  void Begin(bool can_lock) {
    frames_ = std::make_unique<MadeFrames>(can_lock);
  }

  const SimulatedCamera camera_ = ExampleSimulatedCamera();
  const PixelRays rays_{camera_, 2};
  const Pattern pattern_ = ReadPatternOrSpec("chessboard:9x6:25mm");
  const TemporaryFolder folder_;
  std::unique_ptr<MadeFrames> frames_;
  Session session_;
  std::vector<std::string> remarks_;
  double time_s_ = 0;
  int num_locks_ = 0;
  LensFocus focus_;
};

using Words = std::vector<std::string>;

// Frames that came while it settled may show another position of the lens.
TEST_F(CaptureLoopTest, KeepsFramesOnceTheCameraIsLocked) {
  Begin(true);
  AddView(0, 1.5);
  AddView(1, 2);
  AddView(2, 2, std::chrono::milliseconds(1300));
  EXPECT_EQ(Run(), (Words{"locking", "locking", "locking", "kept"}));
  EXPECT_EQ(num_locks_, 1);
  ASSERT_EQ(session_.frames.size(), 1u);
  EXPECT_EQ(session_.frames[0].lens_position, 2);
  EXPECT_EQ(session_.locked, Words{"focus at 2 dioptres"});
  EXPECT_EQ(remarks_, Words{"locked: focus at 2 dioptres"});
  EXPECT_EQ(GetCaptureSettings(session_).lens_position, 2);
}

TEST_F(CaptureLoopTest, ASessionThatGoesOnHasTheFocusOfItsFirstFrame) {
  Begin(true);
  AddView(0, 2);
  AddView(1, 2, std::chrono::milliseconds(1300));
  Run();
  EXPECT_FALSE(focus_.lens_position);
  Begin(true);
  AddView(2, 3);
  Run(true);
  EXPECT_EQ(focus_.lens_position, 2.0f);
}

TEST(SourceFrames, AnUnpluggedCameraIsNoEndInOrder) {
  auto source = std::make_unique<LockableSource>(true);
  source->Fail("camera: disconnected");
  const auto frames = MakeSourceFrames(std::move(source), true);
  EXPECT_FALSE(frames->is_finished());
  EXPECT_THROW(frames->Next(), CameraError);
}

TEST_F(CaptureLoopTest, SaysWhatCannotBeLockedAndGoesOn) {
  Begin(false);
  AddView(0, 2);
  EXPECT_EQ(Run(), Words{"kept"});
  EXPECT_EQ(session_.not_locked, Words{"focus at 2 dioptres"});
  EXPECT_EQ(remarks_, Words{"not locked: focus at 2 dioptres"});
}

TEST_F(CaptureLoopTest, KeepsNoFrameOfAnotherLensPosition) {
  Begin(false);
  AddView(0, 2);
  AddView(1, 2.5);
  AddView(2, 2.05);
  const Words words = Run();
  ASSERT_GE(words.size(), 2u);
  EXPECT_EQ(words[0], "kept");
  EXPECT_EQ(words[1], "refocused");
  EXPECT_EQ(std::count(words.begin(), words.end(), "refocused"), 1);
}

// Two cameras, 0.1 m apart, before a board that stands still for two frames.
class RigLoopTest : public CaptureLoopTest {
 protected:
  void AddFrame(int index, bool is_seen_by_second, uint64_t apart_ns) {
    const Pose first = PoseOfView(index);
    const Eigen::Quaterniond upright = Eigen::Quaterniond::Identity();
    const Pose aside{upright, {-0.1, 0, 0}};
    LiveFrame frames[] = {Render(first), Render(aside * first)};
    if (!is_seen_by_second) frames[1] = Render({upright, {0, 0, -1}});
    for (int k = 0; k < 2; ++k) {
      time_ns_ += 33000000;
      for (int c = 0; c < 2; ++c) {
        frames[c].info.timestamp_ns = time_ns_ + (c == 1 ? apart_ns : 0);
        frames[c].time_s = static_cast<double>(time_ns_) * 1e-9;
        cameras_[c]->frames.push_back({frames[c]});
      }
    }
  }

  void Run() {
    std::vector<CameraStream> cameras;
    cameras.push_back({"left", std::move(cameras_[0])});
    cameras.push_back({"right", std::move(cameras_[1])});
    PairedFrames frames(std::move(cameras), 5e-3);
    SessionFolder session(folder_ / "session", pattern_, frames.names(), false);
    CaptureViewers viewers;
    viewers.show = [&](const CaptureState& state) {
      states_.push_back(state);
      if (state.kept.size() == 3 && !is_undone_) wishes_.Undo();
      is_undone_ |= state.kept.size() == 3;
    };
    viewers.add_kept = [&](const std::string& name,
                           const std::vector<const GreyImage*>& greys) {
      num_frames_[name] = greys.size();
    };
    CaptureLoop(CaptureLoopOptions{}, pattern_, &frames, &session, viewers,
                &wishes_)
        .Run();
    sessions_ = session.cameras();
  }
  std::vector<std::string> Kept(size_t camera) const {
    std::vector<std::string> names;
    for (const SessionFrame& frame : sessions_[camera].frames)
      names.push_back(frame.image);
    return names;
  }

  std::unique_ptr<MadeFrames> cameras_[2] = {
      std::make_unique<MadeFrames>(false), std::make_unique<MadeFrames>(false)};
  CaptureRequests wishes_;
  std::vector<CaptureState> states_;
  std::map<std::string, size_t> num_frames_;
  std::vector<Session> sessions_;
  uint64_t time_ns_ = 0;
  bool is_undone_ = false;
};

TEST_F(RigLoopTest, KeepsTheFramesOfAnInstantTogether) {
  AddFrame(0, true, 0);
  AddFrame(1, false, 4000000);
  AddFrame(2, true, 4000000);  // undone
  AddFrame(3, true, 0);
  Run();
  EXPECT_EQ(Kept(0),
            (Words{"frame-0001.png", "frame-0002.png", "frame-0004.png"}));
  EXPECT_EQ(Kept(1), (Words{"frame-0001.png", "frame-0004.png"}));
  EXPECT_EQ(num_frames_["frame-0001.png"], 2u);
  EXPECT_EQ(num_frames_["frame-0002.png"], 1u);
  EXPECT_EQ(num_frames_["frame-0003.png"], 2u);
  EXPECT_EQ(sessions_[1].not_locked, Words{"focus at 2 dioptres"});
  const CaptureState& last = states_.back();
  ASSERT_EQ(last.cameras.size(), 2u);
  EXPECT_EQ(last.cameras[1].name, "right");
  EXPECT_EQ(last.warnings.front(), "left: not locked: focus at 2 dioptres");
  for (const CaptureState& state : states_)
    EXPECT_EQ(state.camera, "left");  // the first one that is not known
}

}  // namespace
}  // namespace raygrid
