#include "simulation/moving_observations.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/error.h"
#include "simulation/board_curvature.h"

namespace raygrid {
namespace {

// A smooth random function of time, in about [-1, 1]: a sum of waves with the
// frequencies of walking and hand tremor.
class SmoothRandomFunction {
 public:
  explicit SmoothRandomFunction(Random* random) {
    constexpr double kHz[kWaves] = {0.11, 0.23, 0.41, 2};
    constexpr double kSizes[kWaves] = {0.7, 0.4, 0.25, 0.015};
    for (int k = 0; k < kWaves; ++k) {
      hz_[k] = kHz[k] * random->Uniform(0.8, 1.2);
      size_[k] = kSizes[k];
      phase_[k] = random->Uniform(0, 2 * M_PI);
    }
  }
  double At(double time) const {
    double value = 0;
    for (int k = 0; k < kWaves; ++k)
      value += size_[k] * std::sin(2 * M_PI * hz_[k] * time + phase_[k]);
    return value;
  }

 private:
  static constexpr int kWaves = 4;
  double hz_[kWaves], size_[kWaves], phase_[kWaves];
};

class HandPath {
 public:
  HandPath(const CameraModel& camera, const Board& board, double speed,
           Random* random)
      : speed_(speed),
        center_m_((board.columns - 1) * board.square_m / 2,
                  (board.rows - 1) * board.square_m / 2, 0) {
    const Area area = WholeImage(camera.image_size());
    const auto center = camera.Unproject(area.center());
    const auto side = camera.Unproject({area.x1 - 1, area.center().y()});
    const auto below = camera.Unproject({area.center().x(), area.y1 - 1});
    if (!center || !side || !below)
      throw InputError("the camera is not calibrated up to the image border");
    across_rad_ = std::acos(center->dot(*side));
    down_rad_ = std::acos(center->dot(*below));
    distance_m_ = board.columns * board.square_m / (2 * across_rad_);
    for (int k = 0; k < kNumPoseComponents; ++k)
      pose_components_.emplace_back(random);
  }

  // Returns camera_from_board at a time.
  Pose At(double time) const {
    double at[kNumPoseComponents];
    for (int k = 0; k < kNumPoseComponents; ++k)
      at[k] = pose_components_[k].At(speed_ * time);
    const Eigen::Quaterniond orientation =
        RotationFromVector({-0.5 * down_rad_ * at[0], 0, 0}) *
        RotationFromVector({0, 0.5 * across_rad_ * at[1], 0});
    const double distance_m = distance_m_ * (1.2 + 0.4 * at[2]);
    const Eigen::Quaterniond rotation =
        orientation *
        RotationFromVector({0.6 * at[3], 0.6 * at[4], 1.5 * at[5]});
    return {rotation, orientation * Eigen::Vector3d(0, 0, distance_m) -
                          rotation * center_m_};
  }

 private:
  static constexpr int kNumPoseComponents = 6;
  double speed_;
  Eigen::Vector3d center_m_;
  double across_rad_ = 0, down_rad_ = 0, distance_m_ = 0;
  std::vector<SmoothRandomFunction> pose_components_;
};

// Projects a point with a rolling shutter: the pose at the readout time of a
// row maps the point to this row.
std::optional<Eigen::Vector2d> ProjectRollingShutter(
    const CameraModel& camera, const HandPath& path, double time,
    double line_delay_s, const Eigen::Vector3d& point) {
  const double center = (camera.image_size().height - 1) / 2.0;
  std::optional<Eigen::Vector2d> pixel = camera.Project(path.At(time) * point);
  // Fixed-point iteration; each step reduces the error by a factor of about
  // 100.
  for (int step = 0; pixel && step < 12; ++step) {
    const double then = time + line_delay_s * (pixel->y() - center);
    pixel = camera.Project(path.At(then) * point);
  }
  return pixel;
}

std::vector<Feature> SimulateRollingFeatures(const CameraModel& camera,
                                             const Board& board,
                                             const HandPath& path, double time,
                                             double line_delay_s) {
  std::vector<Feature> features;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) {
      if (!board.HasFeature(column, row)) continue;
      const auto pixel =
          ProjectRollingShutter(camera, path, time, line_delay_s,
                                board.points[board.PointIndex(column, row)]);
      if (pixel && WholeImage(camera.image_size()).Contains(*pixel) &&
          camera.IsInImageCircle(*pixel))
        features.push_back({board.id, column, row, *pixel});
    }
  return features;
}

}  // namespace

MovingObservations SimulateMovingObservations(const CameraModel& camera,
                                              const Pattern& pattern,
                                              const SimulationOptions& options,
                                              const HandMotion& motion) {
  Random random(options.seed);
  MovingObservations result;
  SimulatedObservations& seen = result.seen;
  seen.dataset.image_size = camera.image_size();
  seen.true_pattern = pattern;
  Board& board = seen.true_pattern.boards.front();
  board = CurveBoard(board, options.board_sagitta_m);
  const HandPath path(camera, board, motion.speed, &random);
  for (int i = 0; i < options.num_images; ++i) {
    const double time = i * motion.frame_interval_s;
    std::vector<Feature> features =
        SimulateRollingFeatures(camera, board, path, time, motion.line_delay_s);
    SubsampleFeatures(options.features_per_image, &random, &features);
    if (static_cast<int>(features.size()) < options.features_per_image)
      continue;
    AddNoise(options, &random, &features);
    const std::string name = fmt::format("sim{:04d}.png", i);
    seen.dataset.images.push_back({name, std::move(features)});
    seen.poses.push_back({name, board.id, path.At(time)});
    result.times_s.push_back(time);
  }
  if (seen.dataset.images.empty())
    throw Error(
        ExitCode::kInsufficientData,
        fmt::format(
            "none of {} frames shows {} features; reduce --features-per-image",
            options.num_images, options.features_per_image));
  return result;
}

}  // namespace raygrid
