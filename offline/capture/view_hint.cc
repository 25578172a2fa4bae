#include "capture/view_hint.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/board_view.h"

namespace raygrid {
namespace {

// A motion component; its size is 1 at the threshold for a hint.
struct MotionComponent {
  double size = 0;
  std::string direction_text;
};

// Returns the rotation of a board relative to the line of sight to its centre.
Eigen::Matrix3d ComputeBoardRotation(const Board& board, const Pose& pose) {
  const Eigen::Vector3d line_of_sight = pose * ComputeBoardCenter(board);
  return Eigen::Quaterniond::FromTwoVectors(line_of_sight,
                                            Eigen::Vector3d::UnitZ())
             .toRotationMatrix() *
         pose.rotation.toRotationMatrix();
}

// Returns the tilt in radians towards image right and down, i.e. which side is
// farther away.
Eigen::Vector2d ComputeTilt(const Eigen::Matrix3d& facing) {
  const Eigen::Vector3d behind = facing.col(2);  // away from the camera
  const double across = behind.head<2>().norm();
  if (across < 1e-9) return Eigen::Vector2d::Zero();
  // If the back of a board points to the left, its right side is farther away.
  return -std::atan2(across, std::abs(behind.z())) * behind.head<2>() / across;
}

double ComputeRotation(const Eigen::Matrix3d& facing) {
  return std::atan2(facing(1, 0), facing(0, 0));
}

MotionComponent MakeTiltComponent(double change_rad, const char* plus,
                                  const char* minus) {
  constexpr double kMinTiltRad = 0.2;
  return {std::abs(change_rad) / kMinTiltRad,
          std::string("tilt the ") + (change_rad > 0 ? plus : minus) + " away"};
}

// Returns the motion components between two poses, largest first.
std::vector<MotionComponent> ComputeMotionComponents(const CameraModel& camera,
                                                     const Board& board,
                                                     const Pose& from,
                                                     const Pose& to) {
  const Eigen::Vector3d center = ComputeBoardCenter(board);
  std::vector<MotionComponent> moves;
  const auto seen = camera.Project(from * center);
  const auto wanted = camera.Project(to * center);
  if (seen && wanted) {
    constexpr double kMinShift = 0.08;  // relative to the image width
    const Eigen::Vector2d shift =
        (*wanted - *seen) / (kMinShift * camera.image_size().width);
    moves.push_back({std::abs(shift.x()), shift.x() > 0 ? "right" : "left"});
    moves.push_back({std::abs(shift.y()), shift.y() > 0 ? "down" : "up"});
  }
  const double distance_ratio = (from * center).norm() / (to * center).norm();
  constexpr double kMinDistanceRatio = 1.2;
  moves.push_back(
      {std::abs(std::log(distance_ratio)) / std::log(kMinDistanceRatio),
       distance_ratio > 1 ? "closer" : "farther"});
  const Eigen::Matrix3d current = ComputeBoardRotation(board, from);
  const Eigen::Matrix3d required = ComputeBoardRotation(board, to);
  const Eigen::Vector2d tilt = ComputeTilt(required) - ComputeTilt(current);
  moves.push_back(MakeTiltComponent(tilt.x(), "right", "left"));
  moves.push_back(MakeTiltComponent(tilt.y(), "bottom", "top"));
  // Rotations by 180 degrees are ignored, since boards look the same after
  // them.
  constexpr double kMinRotationRad = 0.5;
  const double turn = std::remainder(
      ComputeRotation(required) - ComputeRotation(current), M_PI);
  moves.push_back({std::abs(turn) / kMinRotationRad,
                   turn > 0 ? "rotate clockwise" : "rotate anticlockwise"});
  std::stable_sort(moves.begin(), moves.end(),
                   [](const MotionComponent& a, const MotionComponent& b) {
                     return a.size > b.size;
                   });
  return moves;
}

}  // namespace

std::string DescribeMove(const CameraModel& camera, const Board& board,
                         const Pose& from, const Pose& to) {
  const std::vector<MotionComponent> moves =
      ComputeMotionComponents(camera, board, from, to);
  std::string text;
  constexpr size_t kMaxMoves = 3;
  for (size_t k = 0; k < kMaxMoves && moves[k].size >= 1; ++k)
    text += (k == 0 ? "" : ", ") + moves[k].direction_text;
  return text.empty() ? "hold still" : text;
}

bool HasReachedView(const CameraModel& camera, const Board& board,
                    const Pose& from, const Pose& to) {
  return ComputeMotionComponents(camera, board, from, to).front().size < 1;
}

}  // namespace raygrid
