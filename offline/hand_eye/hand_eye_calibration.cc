#include "hand_eye/hand_eye_calibration.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "dataset/error.h"
#include "hand_eye/hand_eye_diagnosis.h"

namespace raygrid {
namespace {

constexpr double kDegrees = 180 / M_PI;

using Observations = std::vector<HandEyeObservation>;

// ---- Poses that do not fit -------------------------------------------------

// Limit of the squared Mahalanobis distance: 1e-4 of the chi-squared
// distribution with six degrees of freedom, wider if few poses determine the
// variances.
double DistanceLimit(size_t num_used) {
  constexpr double kChiSquared = 27.86;
  const double degrees_of_freedom = 6.0 * static_cast<double>(num_used) - 12;
  return kChiSquared * (1 + 12 / degrees_of_freedom);
}

bool Contains(const std::vector<int>& subset, int index) {
  return std::binary_search(subset.begin(), subset.end(), index);
}

// Poses within six standard deviations of a robust start, whose largest
// differences in the better half are nearly medians.
std::vector<int> NearStart(const Observations& observations, Mounting mounting,
                           const RobustStart& start) {
  constexpr double kFactor = 4;
  std::vector<int> near;
  for (size_t i = 0; i < observations.size(); ++i) {
    const Vector6d difference =
        PoseDifference(PredictTargetPose(start.hand_eye, mounting,
                                         observations[i].base_from_gripper),
                       observations[i].camera_from_target);
    if (difference.head<3>().norm() <= kFactor * start.rotation_rad &&
        difference.tail<3>().norm() <= kFactor * start.translation_m)
      near.push_back(static_cast<int>(i));
  }
  return near;
}

std::vector<int> WithinLimit(const Observations& observations,
                             Mounting mounting, const HandEyeFit& fit,
                             const std::vector<int>& used) {
  std::vector<int> within;
  for (int i = 0; i < static_cast<int>(observations.size()); ++i)
    if (MeasureDistance(fit, mounting, observations[i], Contains(used, i))
            .squared < DistanceLimit(used.size()))
      within.push_back(i);
  return within;
}

[[noreturn]] void ThrowUndetermined() {
  throw Error(ExitCode::kInitializationFailed,
              "the poses do not determine the hand-eye transformation; add "
              "poses with rotations of 20° or more about different axes");
}

struct FitOfSubset {
  HandEyeFit fit;
  std::vector<int> used;
};

HandEyeFit RefineOrThrow(const Observations& observations, Mounting mounting,
                         const std::vector<int>& used, const HandEyeFit& start,
                         const StatedRobotNoise& stated) {
  const auto fit = RefineHandEye(observations, mounting, used, start, stated);
  if (!fit) ThrowUndetermined();
  return *fit;
}

// Refines, and selects the poses that fit, until the selection is stable. The
// selection follows estimated noise, since stated noise may be wrong.
FitOfSubset FitWithoutOutliers(const Observations& observations,
                               Mounting mounting, const RobustStart& start,
                               const StatedRobotNoise& stated) {
  constexpr int kMaxRounds = 10;
  // The median distance of three coordinates is 1.5 standard deviations.
  constexpr double kStdDevsOfMedian = 1.54;
  const size_t min_used =
      std::max<size_t>(observations.size() / 2 + 1, kMinHandEyePoses);
  HandEyeFit initial;
  initial.hand_eye = start.hand_eye;
  initial.noise = {std::max(start.rotation_rad / kStdDevsOfMedian, 1e-6),
                   std::max(start.translation_m / kStdDevsOfMedian, 1e-6)};
  FitOfSubset result = {initial, NearStart(observations, mounting, start)};
  for (int round = 0; round < kMaxRounds; ++round) {
    result.fit =
        RefineOrThrow(observations, mounting, result.used, initial, {});
    std::vector<int> within =
        WithinLimit(observations, mounting, result.fit, result.used);
    if (within == result.used) break;
    if (within.size() < min_used)
      throw Error(
          ExitCode::kInitializationFailed,
          fmt::format("only {} of {} poses agree with each other; check that "
                      "robot poses and images belong together",
                      within.size(), observations.size()));
    result.used = std::move(within);
  }
  result.fit =
      RefineOrThrow(observations, mounting, result.used, result.fit, stated);
  return result;
}

// Returns the observation whose robot pose fits the camera's pose of another
// one, or -1.
int FindFittingRobotPose(const Observations& observations, Mounting mounting,
                         const FitOfSubset& fitted, int index) {
  int best = -1;
  double least = DistanceLimit(fitted.used.size());
  for (int k = 0; k < static_cast<int>(observations.size()); ++k) {
    if (k == index) continue;
    HandEyeObservation mixed = observations[index];
    mixed.base_from_gripper = observations[k].base_from_gripper;
    const double squared =
        MeasureDistance(fitted.fit, mounting, mixed, false).squared;
    if (squared < least) {
      least = squared;
      best = k;
    }
  }
  return best;
}

std::string ExplainOutlier(const Observations& observations, Mounting mounting,
                           const FitOfSubset& fitted, int index,
                           const HandEyeError& error) {
  std::string reason =
      fmt::format("does not fit the other poses by {:.3g} mm and {:.3g}°",
                  1000 * error.translation_m, error.rotation_rad * kDegrees);
  const int other = FindFittingRobotPose(observations, mounting, fitted, index);
  if (other < 0) return reason;
  const bool is_swapped =
      FindFittingRobotPose(observations, mounting, fitted, other) == index;
  return reason +
         (is_swapped ? "; its robot pose is swapped with that of "
                     : "; the robot pose that fits is that of ") +
         observations[other].image;
}

// ---- Errors ----------------------------------------------------------------

// The reprojection error follows from the covariance, which is the inverse of
// the second derivatives of the squared reprojection errors.
HandEyeError ComputeError(const HandEyeFit& fit, Mounting mounting,
                          const HandEyeObservation& observation) {
  const Vector6d difference = PoseDifference(
      PredictTargetPose(fit.hand_eye, mounting, observation.base_from_gripper),
      observation.camera_from_target);
  HandEyeError error;
  error.rotation_rad = difference.head<3>().norm();
  error.translation_m = difference.tail<3>().norm();
  const auto inverse = InvertScaled(observation.covariance);
  if (inverse && observation.num_features > 0) {
    const double features = observation.num_features;
    error.rms_px = std::sqrt(observation.feature_variance *
                             (difference.dot(*inverse * difference) / features +
                              2 * std::max(1 - 3 / features, 0.0)));
  }
  return error;
}

void AddSquares(const HandEyeError& error, HandEyeErrorMetrics* metrics) {
  metrics->rms.rotation_rad += std::pow(error.rotation_rad, 2);
  metrics->rms.translation_m += std::pow(error.translation_m, 2);
  metrics->rms.rms_px += std::pow(error.rms_px, 2);
  ++metrics->count;
}

void TakeRoots(HandEyeErrorMetrics* metrics) {
  const double count = std::max(metrics->count, 1);
  for (double* value : {&metrics->rms.rotation_rad, &metrics->rms.translation_m,
                        &metrics->rms.rms_px})
    *value = std::sqrt(*value / count);
}

// Predicts each pose from the others, or large sets in folds.
void CrossValidate(const Observations& observations, Mounting mounting,
                   const FitOfSubset& fitted, HandEyeResult* result) {
  constexpr size_t kMaxFolds = 30;
  const size_t num_folds = std::min(fitted.used.size(), kMaxFolds);
  const StatedRobotNoise noise = {fitted.fit.noise.rotation_rad,
                                  fitted.fit.noise.translation_m};
  for (size_t fold = 0; fold < num_folds; ++fold) {
    std::vector<int> others;
    for (size_t k = 0; k < fitted.used.size(); ++k)
      if (k % num_folds != fold) others.push_back(fitted.used[k]);
    if (MeasureRotations(observations, mounting, others).Rms(1) <
        kMinRotationRad)
      continue;
    const auto fit =
        RefineHandEye(observations, mounting, others, fitted.fit, noise);
    if (!fit) continue;
    for (size_t k = fold; k < fitted.used.size(); k += num_folds) {
      const int i = fitted.used[k];
      result->poses[i].held_out = ComputeError(*fit, mounting, observations[i]);
      AddSquares(*result->poses[i].held_out, &result->held_out);
    }
  }
  TakeRoots(&result->held_out);
}

void FillPoses(const Observations& observations, Mounting mounting,
               const FitOfSubset& fitted, HandEyeResult* result) {
  for (int i = 0; i < static_cast<int>(observations.size()); ++i) {
    HandEyePoseResult& pose = result->poses.emplace_back();
    pose.residual = ComputeError(fitted.fit, mounting, observations[i]);
    pose.is_used = Contains(fitted.used, i);
    if (pose.is_used)
      AddSquares(pose.residual, &result->residual);
    else
      pose.reason =
          ExplainOutlier(observations, mounting, fitted, i, pose.residual);
  }
  TakeRoots(&result->residual);
}

// ---- Statistics ------------------------------------------------------------

double VarianceRatio(const Observations& observations, Mounting mounting,
                     const FitOfSubset& fitted) {
  double sum = 0;
  for (const int i : fitted.used) {
    const LinearizedHandEye linear =
        LinearizeHandEye(fitted.fit.hand_eye, mounting, observations[i]);
    const auto inverse = InvertScaled(
        ErrorCovariance(linear, observations[i].covariance, fitted.fit.noise));
    if (inverse) sum += linear.error.dot(*inverse * linear.error);
  }
  return sum / (6.0 * static_cast<double>(fitted.used.size()) - 12);
}

Vector12d InformationEigenvalues(const HandEyeFit& fit, double unit_m) {
  Vector12d scale = Vector12d::Ones();
  scale.segment<3>(3).setConstant(1 / unit_m);
  scale.segment<3>(9).setConstant(1 / unit_m);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      scale.asDiagonal() * fit.covariance * scale.asDiagonal());
  return solver.eigenvalues().reverse().cwiseInverse();
}

void AddWarnings(const StatedRobotNoise& stated, HandEyeResult* result) {
  const int used = result->NumUsed();
  const double degrees_of_freedom = 6 * used - 12;
  constexpr double kStdDevs = 4;
  if (stated.rotation_rad && stated.translation_m &&
      result->variance_ratio > 1 + kStdDevs * std::sqrt(2 / degrees_of_freedom))
    result->warnings.push_back(fmt::format(
        "the poses differ {:.2g} times as much as the stated robot accuracy "
        "explains, so standard deviations are too small; omit "
        "--robot-sigma-mm and --robot-sigma-deg to estimate it",
        std::sqrt(result->variance_ratio)));
  constexpr double kMinScaleError = 2e-3;
  if (result->scale && std::abs(result->scale->value) > kMinScaleError &&
      std::abs(result->scale->value) > kStdDevs * result->scale->stddev)
    result->warnings.push_back(fmt::format(
        "lengths of the robot are {:+.2g} % (sd {:.1g} %) of those of the "
        "target; measure the target's squares",
        100 * result->scale->value, 100 * result->scale->stddev));
  constexpr int kFewPoses = 8;
  if (used < kFewPoses && !(stated.rotation_rad && stated.translation_m))
    result->warnings.push_back(fmt::format(
        "{} poses determine the robot's accuracy poorly, so standard "
        "deviations may be too small; use 10 or more poses",
        used));
  if (!result->fit.converged)
    result->warnings.push_back(
        "the robot's accuracy did not converge; state it with "
        "--robot-sigma-mm and --robot-sigma-deg");
}

}  // namespace

int HandEyeResult::NumUsed() const {
  return static_cast<int>(std::count_if(
      poses.begin(), poses.end(),
      [](const HandEyePoseResult& pose) { return pose.is_used; }));
}

HandEyeResult CalibrateHandEye(const Observations& observations,
                               Mounting mounting,
                               const StatedRobotNoise& stated) {
  if (static_cast<int>(observations.size()) < kMinHandEyePoses)
    throw Error(ExitCode::kInsufficientData,
                fmt::format("{} of at least {} poses with images; use 10 or "
                            "more, rotated about different axes",
                            observations.size(), kMinHandEyePoses));
  std::vector<int> all(observations.size());
  std::iota(all.begin(), all.end(), 0);
  RequireRotations(MeasureRotations(observations, mounting, all), mounting);
  const auto start = FindRobustStart(observations, mounting);
  if (!start) ThrowUndetermined();
  RequireFit(observations, mounting, *start);
  const FitOfSubset fitted =
      FitWithoutOutliers(observations, mounting, *start, stated);

  HandEyeResult result;
  result.fit = fitted.fit;
  result.rotations = MeasureRotations(observations, mounting, fitted.used);
  RequireRotations(result.rotations, mounting);
  FillPoses(observations, mounting, fitted, &result);
  CrossValidate(observations, mounting, fitted, &result);
  result.variance_ratio = VarianceRatio(observations, mounting, fitted);
  result.information =
      InformationEigenvalues(fitted.fit, MedianDistance(observations));
  result.scale = EstimateScale(observations, mounting, fitted.used, fitted.fit);
  result.suggestion =
      SuggestRobotPose(observations, mounting, fitted.used, fitted.fit);
  AddWarnings(stated, &result);
  return result;
}

}  // namespace raygrid
