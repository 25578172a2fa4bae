#include "hand_eye/hand_eye_input.h"

#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

double GetSumOfSquares(const TargetPose& target) {
  return std::pow(target.rms_px, 2) * target.num_features;
}

double GetDegreesOfFreedom(const TargetPose& target) {
  return std::max(2.0 * target.num_features - 6, 0.0);
}

double PooledFeatureVariance(const std::vector<TargetPose>& targets) {
  double sum = 0, degrees_of_freedom = 0;
  for (const TargetPose& target : targets) {
    sum += GetSumOfSquares(target);
    degrees_of_freedom += GetDegreesOfFreedom(target);
  }
  return degrees_of_freedom > 0 ? sum / degrees_of_freedom : 0;
}

}  // namespace

std::vector<HandEyeObservation> MakeHandEyeObservations(
    const std::vector<TargetPose>& targets,
    const std::map<std::string, Pose>& base_from_gripper) {
  // As LocalizeTargets() combines the variances of a pose and of all poses.
  constexpr double kPooledDegrees = 20;
  const double pooled = PooledFeatureVariance(targets);
  std::vector<HandEyeObservation> observations;
  for (const TargetPose& target : targets) {
    const auto robot = base_from_gripper.find(target.pose.image);
    if (robot == base_from_gripper.end()) continue;
    HandEyeObservation& observation = observations.emplace_back();
    observation.image = target.pose.image;
    observation.camera_from_target = target.pose.camera_from_board;
    observation.covariance = target.covariance;
    observation.base_from_gripper = robot->second;
    observation.feature_variance =
        (kPooledDegrees * pooled + GetSumOfSquares(target)) /
        (kPooledDegrees + GetDegreesOfFreedom(target));
    observation.num_features = target.num_features;
  }
  return observations;
}

}  // namespace raygrid
