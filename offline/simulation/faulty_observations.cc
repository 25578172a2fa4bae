#include "simulation/faulty_observations.h"

#include <algorithm>
#include <cmath>

#include "simulation/board_deformation.h"

namespace raygrid {
namespace {

Eigen::Vector3d NormalVector(Random* random) {
  const double x = random->Normal(), y = random->Normal();
  return {x, y, random->Normal()};
}

// Applies a fault to the board, the motion of a view or the image.
class FaultyView {
 public:
  FaultyView(SimulatedFault fault, const CameraModel& camera,
             const Board& board, double strength_px, Random* random)
      : fault_(fault),
        camera_(camera),
        strength_px_(strength_px),
        board_(fault == SimulatedFault::kDeformation
                   ? DeformBoard(board, 3 * MetresPerPixel(board), random)
                   : board) {
    if (fault == SimulatedFault::kInPlane) StretchImage(random);
    rotation_ = NormalVector(random);
    translation_ = NormalVector(random);
    scale_ = random->Normal();
    shift_ = {random->Normal(), random->Normal()};
  }

  // Returns the displaced feature; unchanged if it would be outside the image.
  Eigen::Vector2d ProjectFeature(const Pose& pose,
                                 const Feature& feature) const {
    const Eigen::Vector3d point =
        pose * board_.points[board_.PointIndex(feature.column, feature.row)];
    Eigen::Vector3d moved = point;
    if (fault_ == SimulatedFault::kRollingShutter) {
      const double per_px = point.norm() / camera_.image_size().width;
      const double time = feature.pixel.y() / camera_.image_size().height - 0.5;
      moved += 6 * strength_px_ * time * per_px *
               (translation_ + rotation_.cross(point.normalized()));
    }
    const auto pixel = camera_.Project(moved, &feature.pixel, 8);
    return pixel ? MapToPoints(*pixel) : feature.pixel;
  }

 private:
  // Assumes that the board fills the image width.
  double MetresPerPixel(const Board& board) const {
    return strength_px_ * board.columns * board.square_m /
           camera_.image_size().width;
  }

  void StretchImage(Random* random) {
    const Eigen::Vector3d center =
        (board_.points.front() + board_.points.back()) / 2;
    const double part =
        8 * strength_px_ / static_cast<double>(camera_.image_size().width);
    const double along = part * random->Normal(),
                 shear = part * random->Normal();
    for (Eigen::Vector3d& point : board_.points) {
      const Eigen::Vector3d from = point - center;
      point.x() += along * from.x() + shear * from.y();
      point.y() += shear * from.x() - along * from.y();
    }
  }

  Eigen::Vector2d MapToPoints(const Eigen::Vector2d& pixel) const {
    const ImageSize& size = camera_.image_size();
    if (fault_ == SimulatedFault::kImagePosition) {
      const double wave = 2 * M_PI * 7 / size.width;
      return pixel + strength_px_ * Eigen::Vector2d(std::sin(wave * pixel.y()),
                                                    std::cos(wave * pixel.x()));
    }
    if (fault_ == SimulatedFault::kImageAffine) {
      const Eigen::Vector2d center(size.width / 2.0, size.height / 2.0);
      const double scale = 20 * strength_px_ * scale_ / size.width;
      return pixel + scale * (pixel - center) + 20 * strength_px_ * shift_;
    }
    return pixel;
  }

  SimulatedFault fault_;
  const CameraModel& camera_;
  double strength_px_;
  Board board_;
  Eigen::Vector3d rotation_, translation_;
  double scale_ = 0;
  Eigen::Vector2d shift_;
};

void MovePoints(double strength_px, const ImageSize& size, Random* random,
                Board* board) {
  const double deviation_m =
      strength_px * board->columns * board->square_m / size.width;
  for (Eigen::Vector3d& point : board->points)
    point.head<2>() += deviation_m * NormalVector(random).head<2>();
}

}  // namespace

const char* ToString(SimulatedFault fault) {
  constexpr const char* kNames[kNumFaults] = {"none",
                                              "lens model",
                                              "target geometry",
                                              "per-view deformation",
                                              "in-plane deformation",
                                              "image shift/scale",
                                              "rolling shutter"};
  return kNames[static_cast<size_t>(fault)];
}

Dataset SimulateFaultyObservations(const CameraModel& camera,
                                   const Pattern& pattern,
                                   const SimulationOptions& options,
                                   SimulatedFault fault, double strength_px) {
  SimulationOptions exact = options;
  exact.noise_px = exact.shared_noise_px = 0;
  exact.num_shots = 1;
  SimulatedObservations seen = SimulateObservations(camera, pattern, exact);
  Random random(options.seed + 7919);
  Board board = seen.true_pattern.boards.front();
  if (fault == SimulatedFault::kBoardPosition)
    MovePoints(strength_px, camera.image_size(), &random, &board);
  for (size_t i = 0; i < seen.dataset.images.size(); ++i) {
    std::vector<Feature>& features = seen.dataset.images[i].features;
    const FaultyView view(fault, camera, board, strength_px, &random);
    for (Feature& feature : features)
      feature.pixel =
          view.ProjectFeature(seen.poses[i].camera_from_board, feature);
    AddNoise(options, &random, &features);
  }
  return seen.dataset;
}

}  // namespace raygrid
