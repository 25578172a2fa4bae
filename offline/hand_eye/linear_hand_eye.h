#ifndef RAYGRID_HAND_EYE_LINEAR_HAND_EYE_H
#define RAYGRID_HAND_EYE_LINEAR_HAND_EYE_H

#include <optional>
#include <vector>

#include "hand_eye/hand_eye_model.h"

namespace raygrid {

/// Relative rotations between all pairs of poses of the mount. The eigenvalues
/// are the mean squares of twice the vector parts of their quaternions about
/// the axes (rad^2 for small angles), in descending order; the axes are in the
/// mount's frame.
struct RotationSpread {
  Eigen::Vector3d mean_squares = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();

  /// Returns the RMS rotation about an axis (rad).
  double Rms(int axis) const;
};
RotationSpread MeasureRotations(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset);

/// Rotation below which motions about an axis do not determine the translation.
constexpr double kMinRotationRad = 1 * M_PI / 180;

/// Solves for both transformations linearly, in the subset's observations:
/// first the rotations, by quaternions (Chou and Kamel, "Finding the Position
/// and Orientation of a Sensor on a Robot Manipulator Using Quaternions", 1991)
/// and as mean, then the translations. nullopt if rotations are parallel.
std::optional<HandEye> SolveLinearHandEye(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset);

/// Differences of observed and predicted poses as lengths (m): the distance
/// plus the rotation times the given lever.
std::vector<double> MeasureDifferences(
    const HandEye& hand_eye,
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    double lever_m);

/// A robust initial value: the linear solution of the observations that agree
/// best (least trimmed squares, Rousseeuw and Van Driessen, 2006).
struct RobustStart {
  HandEye hand_eye;
  std::vector<int> subset;  ///< observations it is based on, more than half
  /// Largest differences in the better half of the observations.
  double rotation_rad = 0, translation_m = 0;
};
std::optional<RobustStart> FindRobustStart(
    const std::vector<HandEyeObservation>& observations, Mounting mounting);

/// Returns the median distance of the target from the camera (m).
double MedianDistance(const std::vector<HandEyeObservation>& observations);

}  // namespace raygrid

#endif  // RAYGRID_HAND_EYE_LINEAR_HAND_EYE_H
