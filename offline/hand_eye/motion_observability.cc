#include "hand_eye/motion_observability.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "hand_eye/hand_eye_diagnosis.h"
#include "hand_eye/linear_hand_eye.h"

namespace raygrid {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// (Ad_A - I) of a motion, with the second three rows in units of the lever.
Matrix6d MotionJacobian(const Pose& motion, double lever_m) {
  const Eigen::Matrix3d R = motion.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = motion.translation;
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  const Eigen::Matrix3d change = R - Eigen::Matrix3d::Identity();
  Matrix6d jacobian;
  jacobian << change, Eigen::Matrix3d::Zero(), cross * R / lever_m, change;
  return jacobian;
}

// Square roots of the eigenvalues, and the axes.
void Decompose(const Eigen::Matrix3d& information, Eigen::Vector3d* roots,
               Eigen::Matrix3d* axes) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(information);
  *roots = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  *axes = solver.eigenvectors();
}

// Marginalizes the orientation over the position; directions in which the
// position is undetermined do not count.
Eigen::Matrix3d OrientationInformation(const Matrix6d& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> position(
      information.bottomRightCorner<3, 3>());
  Eigen::Matrix3d marginal = information.topLeftCorner<3, 3>();
  for (int k = 0; k < 3; ++k) {
    const double value = position.eigenvalues()[k];
    if (value < kMinRotationRad * kMinRotationRad) continue;
    const Eigen::Vector3d mixed =
        information.topRightCorner<3, 3>() * position.eigenvectors().col(k);
    marginal -= mixed * mixed.transpose() / value;
  }
  return marginal;
}

}  // namespace

bool MotionObservability::IsDetermined() const {
  return position_rad[0] >= kMinRotationRad &&
         orientation_rad[0] >= kMinRotationRad;
}

MotionObservability MeasureObservability(
    const std::vector<Pose>& body_from_world, double lever_m) {
  constexpr size_t kMaxPartners = 60;
  const size_t n = body_from_world.size();
  Matrix6d sum = Matrix6d::Zero();
  int num_pairs = 0;
  for (size_t i = 0; i < n; ++i)
    for (size_t j = i + 1; j < n; j += n / kMaxPartners + 1) {
      const Matrix6d jacobian = MotionJacobian(
          body_from_world[i] * body_from_world[j].Inverse(), lever_m);
      sum += jacobian.transpose() * jacobian;
      ++num_pairs;
    }
  sum /= std::max(num_pairs, 1);
  MotionObservability result;
  Decompose(sum.bottomRightCorner<3, 3>(), &result.position_rad,
            &result.position_axes);
  Decompose(OrientationInformation(sum), &result.orientation_rad,
            &result.orientation_axes);
  return result;
}

std::string DescribeMissingMotion(const MotionObservability& observability,
                                  const MotionNames& names) {
  if (observability.IsDetermined()) return "";
  const auto count_open = [](const Eigen::Vector3d& angles) {
    return std::count_if(angles.data(), angles.data() + 3,
                         [](double angle) { return angle < kMinRotationRad; });
  };
  const auto num_orientations = count_open(observability.orientation_rad);
  const std::string axis = FormatAxis(observability.position_axes.col(0));
  if (count_open(observability.position_rad) == 1)
    return fmt::format(
        "{} rotates about one axis only, {} in the frame of {}, so the "
        "position of {} along it{} not determined; add frames tilted by 20° "
        "or more about another axis",
        names.body, axis, names.frame, names.sensor,
        num_orientations > 0 ? " and its orientation about it are" : " is");
  const std::string orientation =
      num_orientations == 0 ? " is"
      : num_orientations == 1
          ? fmt::format(" and its orientation about the axis {} are",
                        FormatAxis(observability.orientation_axes.col(0)))
          : " and its orientation are";
  return fmt::format(
      "{} does not rotate (RMS {:.2g}°), so the position of {} relative to {} "
      "(in all directions){} not determined; add frames with rotations of "
      "20° or more about two axes",
      names.body, observability.position_rad[2] * 180 / M_PI, names.sensor,
      names.frame, orientation);
}

}  // namespace raygrid
