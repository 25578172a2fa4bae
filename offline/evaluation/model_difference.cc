#include "evaluation/model_difference.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// Observation lines of a pixel in two cameras, compared at infinity or at a
// finite distance.
struct LinePair {
  Eigen::Vector2d pixel;
  ObservationLine first, second;
  double inverse_distance = 0;
  // Jacobian of the first camera's pixel with respect to the direction from the
  // origin of its line.
  Eigen::Matrix<double, 2, 3> J_direction;
};

std::vector<LinePair> SampleLines(const CameraModel& first,
                                  const CameraModel& second, double step_px,
                                  double distance_m) {
  const bool are_central = first.IsCentral() && second.IsCentral();
  const double length_m = are_central ? 1 : distance_m;
  std::vector<LinePair> pairs;
  const Area& area = second.area();
  for (double y = std::ceil(area.y0); y <= area.y1; y += step_px) {
    for (double x = std::ceil(area.x0); x <= area.x1; x += step_px) {
      const Eigen::Vector2d pixel(x, y);
      if (!first.IsInImageCircle(pixel) || !second.IsInImageCircle(pixel))
        continue;
      const auto a = first.Line(pixel);
      const auto b = second.Line(pixel);
      LinearizedProjection projection;
      if (!a || !b ||
          !first.Linearize(a->origin + length_m * a->direction, &pixel, 1,
                           &projection))
        continue;
      pairs.push_back({pixel, *a, *b, 0, length_m * projection.J_point});
      if (are_central) continue;
      pairs.push_back(pairs.back());
      pairs.back().inverse_distance = 1 / distance_m;
    }
  }
  return pairs;
}

// Returns the direction from the first line's origin to the point on the second
// line, in units of its distance.
Eigen::Vector3d ComputeDirection(const LinePair& pair,
                                 const Pose& first_from_second) {
  return first_from_second.rotation * pair.second.direction +
         pair.inverse_distance *
             (first_from_second * pair.second.origin - pair.first.origin);
}

Eigen::Vector2d ComputeErrorPx(const LinePair& pair,
                               const Pose& first_from_second) {
  return pair.J_direction * ComputeDirection(pair, first_from_second);
}

// Solves Wahba's problem by singular value decomposition (Markley, 1988).
Eigen::Quaterniond WeightedRotation(const std::vector<LinePair>& pairs,
                                    const std::vector<double>& weights) {
  Eigen::Matrix3d product = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < pairs.size(); ++i)
    product += weights[i] * pairs[i].first.direction *
               pairs[i].second.direction.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      product, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(
      1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * sign.asDiagonal() *
                                            svd.matrixV().transpose()));
}

// Returns the Huber weights with a threshold of twice the median norm.
std::vector<double> Weights(const std::vector<LinePair>& pairs,
                            const Pose& first_from_second) {
  std::vector<double> norms;
  for (const LinePair& pair : pairs)
    norms.push_back(ComputeErrorPx(pair, first_from_second).norm());
  const double scale = std::max(2 * Quantile(norms, 0.5), 1e-12);
  std::vector<double> weights;
  for (const double norm : norms)
    weights.push_back(norm <= scale ? 1 : scale / norm);
  return weights;
}

// Performs a Gauss-Newton step on the pixel distances.
Pose ApplyMotion(const std::vector<LinePair>& pairs, const Pose& pose) {
  const std::vector<double> weights = Weights(pairs, pose);
  Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  for (size_t i = 0; i < pairs.size(); ++i) {
    const double q = pairs[i].inverse_distance;
    const Eigen::Vector3d turned = pose.rotation * (pairs[i].second.direction +
                                                    q * pairs[i].second.origin);
    Eigen::Matrix<double, 3, 6> J_update;             // as in UpdatedPose()
    J_update << 0, turned.z(), -turned.y(), q, 0, 0,  //
        -turned.z(), 0, turned.x(), 0, q, 0,          //
        turned.y(), -turned.x(), 0, 0, 0, q;
    const Eigen::Matrix<double, 2, 6> row = pairs[i].J_direction * J_update;
    matrix += weights[i] * row.transpose() * row;
    right -= weights[i] * row.transpose() * ComputeErrorPx(pairs[i], pose);
  }
  return UpdatedPose(pose, matrix.ldlt().solve(right));
}

Pose EstimateMotion(const std::vector<LinePair>& pairs, bool are_central) {
  constexpr int kRounds = 10;
  std::vector<double> weights(pairs.size(), 1);
  Pose pose;
  for (int round = 0; round < kRounds; ++round) {
    pose.rotation = WeightedRotation(pairs, weights);
    weights = Weights(pairs, pose);
  }
  if (are_central) return pose;
  for (int round = 0; round < kRounds; ++round) pose = ApplyMotion(pairs, pose);
  return pose;
}

ModelDifference ComputeDifference(const std::vector<LinePair>& pairs,
                                  const Pose& first_from_second,
                                  bool are_central) {
  ModelDifference difference;
  difference.first_from_second = first_from_second;
  double sum = 0;
  std::vector<double> norms;
  for (const LinePair& pair : pairs) {
    difference.pixels.push_back(pair.pixel);
    difference.error_px.push_back(ComputeErrorPx(pair, first_from_second));
    if (!are_central)
      difference.inverse_distances.push_back(pair.inverse_distance);
    norms.push_back(difference.error_px.back().norm());
    sum += norms.back() * norms.back();
  }
  difference.rms_px = std::sqrt(sum / static_cast<double>(norms.size()));
  difference.median_px = Quantile(norms, 0.5);
  difference.p99_px = Quantile(norms, 0.99);
  difference.max_px = Quantile(norms, 1);
  return difference;
}

}  // namespace

ModelDifference CompareModels(const CameraModel& first,
                              const CameraModel& second, double step_px,
                              double distance_m) {
  const std::vector<LinePair> pairs =
      SampleLines(first, second, step_px, distance_m);
  if (pairs.empty()) return {};
  const bool are_central = first.IsCentral() && second.IsCentral();
  return ComputeDifference(pairs, EstimateMotion(pairs, are_central),
                           are_central);
}

ModelDifference CompareRotatedModels(
    const CameraModel& first, const CameraModel& second, double step_px,
    const Eigen::Quaterniond& first_from_second) {
  const std::vector<LinePair> pairs = SampleLines(first, second, step_px, 1);
  if (pairs.empty()) return {};
  return ComputeDifference(pairs, {first_from_second, Eigen::Vector3d::Zero()},
                           true);
}

}  // namespace raygrid
