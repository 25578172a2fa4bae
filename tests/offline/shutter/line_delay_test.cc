#include "shutter/line_delay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include "camera/area.h"
#include "simulation/moving_observations.h"
#include "support.h"

namespace raygrid {
namespace {

struct Clip {
  double line_delay_us = 20, noise_px = 0.1, speed = 1;
  int num_frames = 120;
  double frames_per_second = 30;
  ImageSize size = {640, 480};
  const char* lens = "pinhole";
};

struct Recording {
  std::shared_ptr<const CameraModel> camera;
  SimulatedObservations seen;
  ImageTimes times;

  MovingViews Views() const {
    return {camera.get(), &seen.true_pattern, &seen.dataset, seen.poses, &times,
            true};
  }
};

Recording Record(const Clip& clip, uint64_t seed) {
  Recording recording;
  recording.camera = MakeSimulatedCamera(clip.lens, clip.size);
  SimulationOptions options;
  options.num_images = clip.num_frames;
  options.features_per_image = 60;
  options.noise_px = clip.noise_px;
  options.seed = seed;
  HandMotion motion;
  motion.line_delay_s = clip.line_delay_us * 1e-6;
  motion.frame_interval_s = 1 / clip.frames_per_second;
  motion.speed = clip.speed;
  MovingObservations moving = SimulateMovingObservations(
      *recording.camera, ChessboardPattern(12, 9, 0.03), options, motion);
  for (size_t i = 0; i < moving.times_s.size(); ++i)
    recording.times[moving.seen.dataset.images[i].image] = moving.times_s[i];
  recording.seen = std::move(moving.seen);
  return recording;
}

// The largest error in percent, and the RMS of errors in stated deviations.
struct Errors {
  double largest_s = 0, rms_z = 0;
};

Errors ErrorsOf(const Clip& clip, int num_seeds) {
  Errors errors;
  for (int seed = 1; seed <= num_seeds; ++seed) {
    const LineDelayEstimate found =
        EstimateLineDelay(Record(clip, seed).Views());
    EXPECT_EQ(found.unobservable_reason, "") << "seed " << seed;
    const double error_s = found.value.seconds - clip.line_delay_us * 1e-6;
    errors.largest_s = std::max(errors.largest_s, std::abs(error_s));
    errors.rms_z += std::pow(error_s / found.value.stddev_s, 2) / num_seeds;
  }
  errors.rms_z = std::sqrt(errors.rms_z);
  return errors;
}

TEST(LineDelay, IsFoundToThreePercentWithHonestDeviations) {
  constexpr int kSeeds = 12;
  for (const Clip& clip : {Clip{20, 0.1}, Clip{20, 0.02}, Clip{-20, 0.1},
                           Clip{20, 0.1, 1, 120, 30, {1920, 1080}, "wide"},
                           Clip{8, 0.1, 1, 120, 30, {1920, 1080}, "fisheye"}}) {
    SCOPED_TRACE(fmt::format("{} us, {} px, {}", clip.line_delay_us,
                             clip.noise_px, clip.lens));
    const Errors errors = ErrorsOf(clip, kSeeds);
    EXPECT_LT(errors.largest_s, 0.03 * std::abs(clip.line_delay_us) * 1e-6);
    EXPECT_GT(errors.rms_z, 0.5);
    EXPECT_LT(errors.rms_z, 1.6);
  }
}

TEST(LineDelay, OfAGlobalShutterIsZeroWithinTwoDeviations) {
  int num_beyond = 0;
  constexpr int kSeeds = 12;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const LineDelayEstimate found =
        EstimateLineDelay(Record(Clip{0, 0.1}, seed).Views());
    ASSERT_TRUE(found.IsDetermined()) << found.unobservable_reason;
    if (!found.value.IsPossiblyGlobalShutter()) ++num_beyond;
  }
  EXPECT_LE(num_beyond, 2);  // chance has 0.6 of 12
}

TEST(LineDelay, OfAStillCameraCannotBeTold) {
  for (const double noise_px : {0.02, 0.1})
    for (const int num_frames : {40, 300}) {
      const LineDelayEstimate found = EstimateLineDelay(
          Record(Clip{20, noise_px, 0, num_frames}, 1).Views());
      EXPECT_NE(found.unobservable_reason.find("too little motion"),
                std::string::npos)
          << found.unobservable_reason;
    }
}

TEST(LineDelay, OfAFewPixelsOfMotionIsToldOrNotButNeverWrong) {
  for (const double speed : {0.01, 0.03, 0.1, 0.3})
    for (int seed = 1; seed <= 3; ++seed) {
      const LineDelayEstimate found =
          EstimateLineDelay(Record(Clip{20, 0.1, speed}, seed).Views());
      if (!found.IsDetermined()) continue;
      EXPECT_LT(std::abs(found.value.seconds - 20e-6), 5 * found.value.stddev_s)
          << speed;
    }
}

TEST(LineDelay, NeedsNeighboursInTime) {
  Recording recording = Record(Clip{}, 1);
  for (auto& [image, time_s] : recording.times) time_s *= 1000;
  const LineDelayEstimate found = EstimateLineDelay(recording.Views());
  EXPECT_EQ(found.num_images, 0);
  EXPECT_NE(found.unobservable_reason.find("0 images have two adjacent"),
            std::string::npos)
      << found.unobservable_reason;
}

// Each fourth frame is missing, or has no time: its neighbours make do.
TEST(LineDelay, IsFoundWhereFramesAreMissing) {
  Recording recording = Record(Clip{20, 0.02}, 3);
  size_t count = 0;
  for (const BoardPose& pose : recording.seen.poses)
    if (count++ % 4 == 1) recording.times.erase(pose.image);
  const LineDelayEstimate found = EstimateLineDelay(recording.Views());
  ASSERT_TRUE(found.IsDetermined()) << found.unobservable_reason;
  EXPECT_NEAR(found.value.seconds, 20e-6, 0.6e-6);
  EXPECT_LT(found.num_images, 100);
}

// A hand that trembles by some 6 Hz, seen ten times a second.
TEST(LineDelay, DeviationCountsMotionsThatAreQuickForTheFrames) {
  for (int seed = 1; seed <= 4; ++seed) {
    const LineDelayEstimate found =
        EstimateLineDelay(Record(Clip{20, 0.02, 3, 150, 10}, seed).Views());
    ASSERT_TRUE(found.IsDetermined()) << found.unobservable_reason;
    EXPECT_GT(found.value.stddev_s, 0.2e-6);
    EXPECT_LT(std::abs(found.value.seconds - 20e-6), 3 * found.value.stddev_s);
  }
}

// Times that scatter by 3 ms pretend motion: the row time is some per cent
// short.
TEST(LineDelay, DeviationCountsTimesThatScatter) {
  for (int seed = 1; seed <= 6; ++seed) {
    Recording recording = Record(Clip{20, 0.1, 1, 200}, seed);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> scatter_s(0, 0.003);
    for (auto& [image, time_s] : recording.times) time_s += scatter_s(random);
    const LineDelayEstimate found = EstimateLineDelay(recording.Views());
    ASSERT_TRUE(found.IsDetermined()) << found.unobservable_reason;
    EXPECT_LT(std::abs(found.value.seconds - 20e-6), 3 * found.value.stddev_s)
        << found.value.seconds << " s, " << found.value.stddev_s;
  }
}

// The times of a recording, in the order of its frames, made wrong.
using MakeWrong = std::function<void(std::mt19937_64*, std::vector<double>*)>;

// How many recordings tell a row time with times that are made wrong. Those
// that do are right within five deviations: some of them are too slow to
// suffer.
int CountTold(const Clip& clip, int num_seeds, double dropped_part,
              const MakeWrong& make_wrong) {
  int num_reported = 0;
  for (int seed = 1; seed <= num_seeds; ++seed) {
    Recording recording = Record(clip, 100 + seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::vector<std::string> images;
    std::vector<double> times_s;
    for (const ImageFeatures& image : recording.seen.dataset.images)
      if (uniform(random) >= dropped_part) {
        images.push_back(image.image);
        times_s.push_back(recording.times.at(image.image));
      }
    make_wrong(&random, &times_s);
    recording.times.clear();
    for (size_t i = 0; i < images.size(); ++i)
      recording.times[images[i]] = times_s[i];
    const LineDelayEstimate found = EstimateLineDelay(recording.Views());
    if (!found.IsDetermined()) continue;
    ++num_reported;
    EXPECT_LT(std::abs(found.value.seconds - clip.line_delay_us * 1e-6),
              5 * found.value.stddev_s)
        << "seed " << seed << ": " << found.value.seconds << " +- "
        << found.value.stddev_s;
  }
  return num_reported;
}

void CountFrames(std::mt19937_64* /*random*/, std::vector<double>* times_s) {
  for (size_t i = 0; i < times_s->size(); ++i)
    (*times_s)[i] = static_cast<double>(i) / 30;
}

// Bursts of five and more lie too far apart to be neighbours.
TEST(LineDelay, IsNotToldByTimesOfFramesThatArriveInBursts) {
  for (const size_t burst : {2u, 3u, 5u, 9u})
    EXPECT_EQ(CountTold(Clip{burst % 2 == 1 ? -25.0 : 12.0}, 2, 0,
                        [&](std::mt19937_64*, std::vector<double>* times_s) {
                          std::vector<double>& t = *times_s;
                          const std::vector<double> taken = t;
                          for (size_t i = 0; i < t.size(); ++i) {
                            const size_t last = i / burst * burst + burst - 1;
                            t[i] = taken[std::min(last, t.size() - 1)] +
                                   0.002 * static_cast<double>(i % burst);
                          }
                        }),
              0)
        << burst << " frames together";
}

TEST(LineDelay, IsNotToldByCountingFramesOfWhichSomeAreMissing) {
  for (const double part : {0.03, 0.2})
    EXPECT_EQ(CountTold(Clip{20, 0.1, 1, 160}, 2, part, CountFrames), 0)
        << part;
  // A recording may miss none where one in a hundred is missing.
  CountTold(Clip{20, 0.1, 1, 160}, 3, 0.01, CountFrames);
}

TEST(LineDelay, IsNotToldByTimesInAnotherOrder) {
  EXPECT_EQ(CountTold(Clip{20}, 2, 0,
                      [](std::mt19937_64* random, std::vector<double>* t) {
                        std::shuffle(t->begin(), t->end(), *random);
                      }),
            0);
  EXPECT_EQ(CountTold(Clip{20}, 2, 0,
                      [](std::mt19937_64*, std::vector<double>* t) {
                        for (size_t i = 10; i + 1 < t->size(); i += 20)
                          std::swap((*t)[i], (*t)[i + 1]);
                      }),
            0);
}

TEST(LineDelay, TellsWhichTimesDoNotFitTheMotion) {
  Recording recording = Record(Clip{20, 0.05}, 3);
  for (auto& [image, time_s] : recording.times)
    if (image >= "sim0060.png") time_s += 0.05;
  const LineDelayEstimate found = EstimateLineDelay(recording.Views());
  EXPECT_FALSE(found.are_timestamps_consistent);
  for (const char* words : {"sim0059.png to sim0060.png", "83.3 ms", "33."})
    EXPECT_NE(found.unobservable_reason.find(words), std::string::npos)
        << found.unobservable_reason;
}

// One part of a clip is a fifth quicker than its times tell.
TEST(LineDelay, IsNotToldByTimesWhoseRateChanges) {
  Recording recording = Record(Clip{20, 0.05, 1, 300}, 3);
  for (auto& [image, time_s] : recording.times)
    if (image >= "sim0150.png") time_s = 5 + 1.2 * (time_s - 5);
  const LineDelayEstimate found = EstimateLineDelay(recording.Views());
  EXPECT_FALSE(found.are_timestamps_consistent);
  EXPECT_NE(found.unobservable_reason.find("in the later frames"),
            std::string::npos)
      << found.unobservable_reason;
}

TEST(LineDelay, IsToldByGoodTimes) {
  const auto scatter = [](std::mt19937_64* random, std::vector<double>* t) {
    std::normal_distribution<double> scatter_s(0, 3e-4);
    for (double& time_s : *t) time_s += scatter_s(*random);
  };
  for (const Clip& clip : {Clip{30, 0.05, 1, 200}, Clip{20, 0.3},
                           Clip{-20, 0.1, 2}, Clip{20, 0.1, 0.5, 150}})
    EXPECT_EQ(CountTold(clip, 2, 0, scatter), 2)
        << clip.line_delay_us << " us, speed " << clip.speed;
  // Frames that are missing leave the times of the others right.
  EXPECT_EQ(CountTold(Clip{20, 0.1, 1, 160}, 2, 0.1, scatter), 2);
  Recording recording = Record(Clip{20, 0.1, 1, 240}, 4);
  size_t count = 0;
  for (const BoardPose& pose : recording.seen.poses)
    if (count++ % 25 < 9) recording.times.erase(pose.image);
  const LineDelayEstimate found = EstimateLineDelay(recording.Views());
  EXPECT_TRUE(found.IsDetermined()) << found.unobservable_reason;
}

// A camera that is bent as a common motion would bend it tells no other time.
TEST(LineDelay, DoesNotTrustTheCameraToBeExact) {
  const Recording recording = Record(Clip{20, 0.02, 1, 200}, 2);
  MovingViews views = recording.Views();
  Dataset dataset = *views.dataset;
  for (ImageFeatures& image : dataset.images)
    for (Feature& feature : image.features) {
      const double y = (feature.pixel.y() - 240) / 320;
      const double x = (feature.pixel.x() - 320) / 320;
      feature.pixel += Eigen::Vector2d(2 * x * y * y, y * y * y - x * y);
    }
  views.dataset = &dataset;
  const LineDelayEstimate found = EstimateLineDelay(views);
  ASSERT_TRUE(found.IsDetermined()) << found.unobservable_reason;
  EXPECT_NEAR(found.value.seconds, 20e-6, 0.2e-6);
}

TEST(ComputeGlobalShutterFeatures, FeaturesAreWhereTheyWereSeenAtOnce) {
  const Recording moving = Record(Clip{20, 0}, 5),
                  at_once = Record(Clip{0, 0}, 5);
  const Dataset still = ComputeGlobalShutterFeatures(moving.Views(), 20e-6);
  double before_px = 0, after_px = 0;
  size_t count = 0;
  for (size_t i = 2; i + 2 < still.images.size(); ++i)
    for (const Feature& feature : still.images[i].features)
      for (const Feature& other : at_once.seen.dataset.images[i].features) {
        if (feature.column != other.column || feature.row != other.row)
          continue;
        after_px += (feature.pixel - other.pixel).squaredNorm();
        ++count;
      }
  for (size_t i = 2; i + 2 < still.images.size(); ++i)
    for (const Feature& feature : moving.seen.dataset.images[i].features)
      for (const Feature& other : at_once.seen.dataset.images[i].features)
        if (feature.column == other.column && feature.row == other.row)
          before_px += (feature.pixel - other.pixel).squaredNorm();
  ASSERT_GT(count, 1000u);
  EXPECT_GT(std::sqrt(before_px / count), 0.3);
  EXPECT_LT(std::sqrt(after_px / count), 0.02);
}

}  // namespace
}  // namespace raygrid
