#include "evaluation/model_difference.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

struct RayPair {
  Eigen::Vector2d pixel;
  Eigen::Vector3d first, second;
  Eigen::Matrix<double, 2, 3> pixel_by_ray;  // of the first camera
};

std::vector<RayPair> SampleRays(const CameraModel& first,
                                const CameraModel& second, double step_px) {
  std::vector<RayPair> pairs;
  const Area& area = second.area();
  for (double y = std::ceil(area.y0); y <= area.y1; y += step_px) {
    for (double x = std::ceil(area.x0); x <= area.x1; x += step_px) {
      const Eigen::Vector2d pixel(x, y);
      const auto a = first.Unproject(pixel);
      const auto b = second.Unproject(pixel);
      LinearizedProjection projection;
      if (a && b && first.Linearize(*a, &pixel, 1, &projection))
        pairs.push_back({pixel, *a, *b, projection.by_point});
    }
  }
  return pairs;
}

Eigen::Vector2d ErrorPx(const RayPair& pair,
                        const Eigen::Quaterniond& rotation) {
  return pair.pixel_by_ray * (rotation * pair.second);
}

// Wahba's problem by singular value decomposition (Markley, 1988).
Eigen::Quaterniond WeightedRotation(const std::vector<RayPair>& pairs,
                                    const std::vector<double>& weights) {
  Eigen::Matrix3d product = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < pairs.size(); ++i)
    product += weights[i] * pairs[i].first * pairs[i].second.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      product, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(
      1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * sign.asDiagonal() *
                                            svd.matrixV().transpose()));
}

}  // namespace

ModelDifference CompareModels(const CameraModel& first,
                              const CameraModel& second, double step_px) {
  const std::vector<RayPair> pairs = SampleRays(first, second, step_px);
  ModelDifference difference;
  difference.first_from_second = Eigen::Quaterniond::Identity();
  if (pairs.empty()) return difference;

  std::vector<double> weights(pairs.size(), 1), norms(pairs.size());
  for (int round = 0; round < 10; ++round) {
    difference.first_from_second = WeightedRotation(pairs, weights);
    for (size_t i = 0; i < pairs.size(); ++i)
      norms[i] = ErrorPx(pairs[i], difference.first_from_second).norm();
    const double scale = std::max(2 * Quantile(norms, 0.5), 1e-12);
    for (size_t i = 0; i < pairs.size(); ++i)
      weights[i] = norms[i] <= scale ? 1 : scale / norms[i];
  }

  double sum = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    difference.pixels.push_back(pairs[i].pixel);
    difference.error_px.push_back(
        ErrorPx(pairs[i], difference.first_from_second));
    norms[i] = difference.error_px.back().norm();
    sum += norms[i] * norms[i];
  }
  difference.rms_px = std::sqrt(sum / static_cast<double>(norms.size()));
  difference.median_px = Quantile(norms, 0.5);
  difference.p99_px = Quantile(norms, 0.99);
  difference.max_px = Quantile(norms, 1);
  return difference;
}

}  // namespace raygrid
