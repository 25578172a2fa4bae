#include "paired_frames.h"

#include <gtest/gtest.h>

#include <string>

#include "dataset/error.h"

namespace raygrid {
namespace {

// Frames that are all there, with timestamps in milliseconds and names.
class ListedFrames : public LiveFrames {
 public:
  ListedFrames(bool is_live, const std::vector<std::pair<int, std::string>>& of,
               bool is_folder = false)
      : is_live_(is_live), is_folder_(is_folder), frames_(of) {}
  std::optional<LiveFrame> Next() override {
    if (next_ == frames_.size()) return std::nullopt;
    LiveFrame frame;
    frame.info.timestamp_ns =
        1000000u * static_cast<uint64_t>(frames_[next_].first);
    frame.name = frames_[next_++].second;
    return frame;
  }
  // A camera goes on, but no more frame comes.
  bool is_finished() const override {
    return !is_live_ && next_ == frames_.size();
  }
  bool is_live() const override { return is_live_; }
  std::optional<double> done() const override {
    return is_folder_ ? std::optional(0.0) : std::nullopt;
  }

 private:
  const bool is_live_, is_folder_;
  const std::vector<std::pair<int, std::string>> frames_;
  size_t next_ = 0;
};

std::unique_ptr<LiveFrames> Camera(const std::vector<int>& times_ms) {
  std::vector<std::pair<int, std::string>> frames;
  for (const int time_ms : times_ms) frames.emplace_back(time_ms, "");
  return std::make_unique<ListedFrames>(true, frames);
}

std::unique_ptr<LiveFrames> Files(const std::vector<std::string>& names,
                                  bool is_folder = false) {
  std::vector<std::pair<int, std::string>> frames;
  for (const std::string& name : names) frames.emplace_back(0, name);
  return std::make_unique<ListedFrames>(false, frames, is_folder);
}

PairedFrames Pair(std::unique_ptr<LiveFrames> left,
                  std::unique_ptr<LiveFrames> right) {
  std::vector<CameraStream> cameras;
  cameras.push_back({"left", std::move(left)});
  cameras.push_back({"right", std::move(right)});
  return {std::move(cameras), 5e-3};
}

// "0:3 33:36", milliseconds, "-" for none.
std::string TakeTimes(PairedFrames* frames, int num_tries) {
  std::string text;
  for (int k = 0; k < num_tries; ++k) {
    const auto frame_set = frames->Next();
    if (!frame_set) continue;
    const auto time_of = [](const std::optional<LiveFrame>& frame) {
      return frame ? std::to_string(frame->info.timestamp_ns / 1000000) : "-";
    };
    text += (text.empty() ? "" : " ") + time_of((*frame_set)[0]) + ":" +
            time_of((*frame_set)[1]);
  }
  return text;
}

std::string TakeNames(PairedFrames* frames) {
  std::string text;
  while (!frames->is_finished()) {
    const auto frame_set = frames->Next();
    if (!frame_set) continue;
    text += text.empty() ? "" : " ";
    for (const auto& frame : *frame_set)
      text += frame ? "[" + frame->name + "]" : "[-]";
  }
  return text;
}

TEST(PairedFrames, PairsByTime) {
  PairedFrames frames =
      Pair(Camera({0, 33, 67, 100, 133}), Camera({3, 36, 103, 136}));
  EXPECT_EQ(TakeTimes(&frames, 10), "0:3 33:36 100:103 133:136");
  EXPECT_FALSE(frames.is_unpaired());
}

TEST(PairedFrames, CatchesUpWhereACameraIsBehind) {
  PairedFrames frames =
      Pair(Camera({100, 133, 167}), Camera({0, 33, 67, 100, 133, 167}));
  EXPECT_EQ(TakeTimes(&frames, 12), "100:100 133:133 167:167");
}

// Cameras without a trigger may always be apart: their frames come alone then.
TEST(PairedFrames, GivesFramesAloneWhereNonePair) {
  PairedFrames frames = Pair(Camera({0, 33, 67}), Camera({16, 49, 83}));
  EXPECT_EQ(TakeTimes(&frames, 2), "");
  const auto start = Clock::now();
  while (!frames.is_unpaired() &&
         Clock::now() - start < std::chrono::seconds(20))
    frames.Next();
  EXPECT_TRUE(frames.is_unpaired());
  PairedFrames late = Pair(Camera({0, 33, 67}), Camera({}));
  std::string times;
  while (times.empty() && Clock::now() - start < std::chrono::seconds(40))
    times = TakeTimes(&late, 1);
  EXPECT_EQ(times, "0:-");
}

TEST(PairedFrames, PairsPhotographsByName) {
  PairedFrames frames =
      Pair(Files({"a.png", "c.png", "d.png"}), Files({"b.png", "c.png"}));
  EXPECT_EQ(TakeNames(&frames),
            "[a.png][-] [-][b.png] [c.png][c.png] [d.png][-]");
}

TEST(PairedFrames, PairsVideosFrameByFrame) {
  PairedFrames frames = Pair(Files({"", "", ""}), Files({"", ""}));
  EXPECT_EQ(TakeNames(&frames), "[][] [][] [][-]");
}

TEST(PairedFrames, RefusesAMixture) {
  EXPECT_THROW(Pair(Camera({0}), Files({"a.png"})), Error);
  EXPECT_THROW(Pair(Files({"", ""}), Files({"a.png"}, true)), Error);
}

}  // namespace
}  // namespace raygrid
