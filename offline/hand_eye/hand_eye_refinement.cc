#include "hand_eye/hand_eye_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

// The linearized observations of a subset with their weights W_i = V_i^-1.
struct WeightedHandEye {
  std::vector<LinearizedHandEye> linear;
  std::vector<PoseCovariance> weights;
  Matrix12d information = Matrix12d::Zero();  // J^T W J
  Vector12d gradient = Vector12d::Zero();     // J^T W error
};

WeightedHandEye BuildNormalEquations(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset, const HandEye& hand_eye,
    const RobotNoise& noise) {
  WeightedHandEye weighted;
  for (const int i : subset) {
    const LinearizedHandEye linear =
        LinearizeHandEye(hand_eye, mounting, observations[i]);
    const PoseCovariance covariance =
        ErrorCovariance(linear, observations[i].covariance, noise);
    const PoseCovariance weight =
        covariance.ldlt().solve(PoseCovariance::Identity());
    const auto& J = linear.J_hand_eye;
    weighted.information += J.transpose() * weight * J;
    weighted.gradient += J.transpose() * weight * linear.error;
    weighted.linear.push_back(linear);
    weighted.weights.push_back(weight);
  }
  return weighted;
}

HandEye ApplyStep(const HandEye& hand_eye, const Vector12d& step) {
  return {UpdatedPose(hand_eye.camera_from_mount, step.head<6>()),
          UpdatedPose(hand_eye.anchor_from_target, step.tail<6>())};
}

// Factor by which a component of the robot's variance changes: the squares of
// the weighted errors over their expectation, at which both are equal.
double VarianceFactor(
    const WeightedHandEye& weighted, const Matrix12d& covariance,
    const Eigen::Matrix<double, 6, 3> LinearizedHandEye::*component) {
  double squares = 0, expected = 0;
  Matrix12d estimated = Matrix12d::Zero();
  for (size_t k = 0; k < weighted.linear.size(); ++k) {
    const LinearizedHandEye& linear = weighted.linear[k];
    const Eigen::Matrix<double, 6, 3> WJ =
        weighted.weights[k] * (linear.*component);
    squares += (WJ.transpose() * linear.error).squaredNorm();
    expected += ((linear.*component).transpose() * WJ).trace();
    const Eigen::Matrix<double, 12, 3> projected =
        linear.J_hand_eye.transpose() * WJ;
    estimated += projected * projected.transpose();
  }
  expected -= (covariance * estimated).trace();
  constexpr double kMaxFactor = 10;
  if (!(expected > 0)) return 1;
  return std::clamp(squares / expected, 1 / kMaxFactor, kMaxFactor);
}

// Updates the variances that are not stated; returns the largest relative
// change.
double UpdateNoise(const WeightedHandEye& weighted, const Matrix12d& covariance,
                   const StatedRobotNoise& stated, RobotNoise* noise) {
  double change = 0;
  const auto update = [&](const auto component, double least, double* value) {
    const double factor =
        std::sqrt(VarianceFactor(weighted, covariance, component));
    const double updated = std::max(*value * factor, least);
    change = std::max(change, std::abs(updated / *value - 1));
    *value = updated;
  };
  if (!stated.rotation_rad)
    update(&LinearizedHandEye::J_rotation, kMinRobotNoise.rotation_rad,
           &noise->rotation_rad);
  if (!stated.translation_m)
    update(&LinearizedHandEye::J_translation, kMinRobotNoise.translation_m,
           &noise->translation_m);
  return change;
}

void UseStatedNoise(const StatedRobotNoise& stated, RobotNoise* noise) {
  if (stated.rotation_rad)
    noise->rotation_rad =
        std::max(*stated.rotation_rad, kMinRobotNoise.rotation_rad);
  if (stated.translation_m)
    noise->translation_m =
        std::max(*stated.translation_m, kMinRobotNoise.translation_m);
}

}  // namespace

std::optional<Eigen::MatrixXd> InvertScaled(const Eigen::MatrixXd& matrix) {
  constexpr double kMinEigenvalueRatio = 1e-13;
  const Eigen::VectorXd scale =
      matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      scale.asDiagonal() * matrix * scale.asDiagonal());
  if (!(solver.eigenvalues()[0] > kMinEigenvalueRatio)) return std::nullopt;
  const Eigen::MatrixXd vectors = scale.asDiagonal() * solver.eigenvectors();
  return Eigen::MatrixXd(vectors *
                         solver.eigenvalues().cwiseInverse().asDiagonal() *
                         vectors.transpose());
}

std::optional<HandEyeFit> RefineHandEye(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset, const HandEyeFit& start,
    const StatedRobotNoise& stated) {
  constexpr int kMaxIterations = 200;
  constexpr double kSmallStep = 1e-8;    // squared, in standard deviations
  constexpr double kSmallChange = 1e-4;  // of the noise, relative
  HandEyeFit fit = start;
  UseStatedNoise(stated, &fit.noise);
  fit.converged = false;
  for (int k = 0; k < kMaxIterations && !fit.converged; ++k) {
    const WeightedHandEye weighted = BuildNormalEquations(
        observations, mounting, subset, fit.hand_eye, fit.noise);
    const auto covariance = InvertScaled(weighted.information);
    if (!covariance) return std::nullopt;
    fit.covariance = *covariance;
    const Vector12d step = fit.covariance * weighted.gradient;
    const bool is_near = step.dot(weighted.gradient) < kSmallStep;
    // The variances follow from the residuals of the solution.
    const double change =
        step.dot(weighted.gradient) < 1
            ? UpdateNoise(weighted, fit.covariance, stated, &fit.noise)
            : INFINITY;
    fit.hand_eye = ApplyStep(fit.hand_eye, step);
    fit.converged = is_near && change < kSmallChange;
  }
  return fit;
}

HandEyeDistance MeasureDistance(const HandEyeFit& fit, Mounting mounting,
                                const HandEyeObservation& observation,
                                bool is_used) {
  const LinearizedHandEye linear =
      LinearizeHandEye(fit.hand_eye, mounting, observation);
  const PoseCovariance estimated =
      linear.J_hand_eye * fit.covariance * linear.J_hand_eye.transpose();
  HandEyeDistance distance;
  distance.error = linear.error;
  distance.covariance =
      ErrorCovariance(linear, observation.covariance, fit.noise);
  if (is_used)
    distance.covariance -= estimated;
  else
    distance.covariance += estimated;
  const auto inverse = InvertScaled(distance.covariance);
  if (inverse) distance.squared = distance.error.dot(*inverse * distance.error);
  return distance;
}

std::optional<ScaleError> EstimateScale(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset, const HandEyeFit& fit) {
  const WeightedHandEye weighted = BuildNormalEquations(
      observations, mounting, subset, fit.hand_eye, fit.noise);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(13, 13);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(13);
  for (size_t k = 0; k < weighted.linear.size(); ++k) {
    const LinearizedHandEye& linear = weighted.linear[k];
    Eigen::Matrix<double, 6, 13> J;
    J << linear.J_hand_eye, linear.J_scale;
    information += J.transpose() * weighted.weights[k] * J;
    gradient += J.transpose() * weighted.weights[k] * linear.error;
  }
  const auto covariance = InvertScaled(information);
  if (!covariance) return std::nullopt;
  // The target is the reference: a robot's lengths are multiplied by
  // 1 / (1 + value) to match it.
  return ScaleError{-(*covariance * gradient)[12],
                    std::sqrt((*covariance)(12, 12))};
}

}  // namespace raygrid
