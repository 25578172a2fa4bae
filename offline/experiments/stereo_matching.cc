#include "experiments/stereo_matching.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

constexpr int kStepPx = Matching::kStepPx;
constexpr int kHalfWindowPx = Matching::kHalfWindowPx;

// ---- Rectification ---------------------------------------------------------

Eigen::Vector3d RightCenter(const StereoRig& cameras) {
  return cameras.right_from_left.Inverse().translation;
}

// Returns the rectified frame: x towards the right camera, z approximately
// along the ray of the left image's centre.
Eigen::Matrix3d RectifiedFromLeft(const StereoRig& cameras) {
  const CameraModel& left = *cameras.left;
  const Eigen::Vector3d x = RightCenter(cameras).normalized();
  const Eigen::Vector3d center =
      left.Unproject(left.area().center()).value_or(Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d y = center.cross(x).normalized();
  Eigen::Matrix3d rows;
  rows << x.transpose(), y.transpose(), x.cross(y).transpose();
  return rows;
}

Eigen::Vector3d RectifiedRay(const Matching& matching, const ImageSize& size,
                             double u, double v) {
  return {(u - (size.width - 1) / 2.0) / matching.focal_px,
          (v - (size.height - 1) / 2.0) / matching.focal_px, 1};
}

// Rectifies an image; with a non-central camera, rectification is exact for
// points at depth_m.
cv::Mat Rectified(const cv::Mat& image, const CameraModel& camera,
                  const Eigen::Matrix3d& camera_from_rectified, double depth_m,
                  const Matching& matching, int num_threads) {
  constexpr float kNowhere = -1e4f;
  cv::Mat x(image.size(), CV_32F), y(image.size(), CV_32F), rectified;
  ParallelFor(image.rows, num_threads, [&](int v) {
    for (int u = 0; u < image.cols; ++u) {
      const auto pixel =
          camera.Project(depth_m * camera_from_rectified *
                         RectifiedRay(matching, camera.image_size(), u, v));
      x.at<float>(v, u) = pixel ? static_cast<float>(pixel->x()) : kNowhere;
      y.at<float>(v, u) = pixel ? static_cast<float>(pixel->y()) : kNowhere;
    }
  });
  cv::remap(image, rectified, x, y, cv::INTER_CUBIC, cv::BORDER_CONSTANT, -1);
  return rectified;
}

// ---- Matching --------------------------------------------------------------

// Returns the zero-mean normalized cross-correlation of two windows on the same
// image row.
double Correlation(const cv::Mat& left, const cv::Mat& right, int u, int v,
                   int disparity) {
  double a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (int j = -kHalfWindowPx; j <= kHalfWindowPx; ++j) {
    const float* l = left.ptr<float>(v + j) + u;
    const float* r = right.ptr<float>(v + j) + u - disparity;
    for (int i = -kHalfWindowPx; i <= kHalfWindowPx; ++i) {
      a += l[i];
      b += r[i];
      aa += l[i] * l[i];
      bb += r[i] * r[i];
      ab += l[i] * r[i];
    }
  }
  const double n = std::pow(2 * kHalfWindowPx + 1, 2);
  return (ab - a * b / n) /
         std::sqrt(std::max(1e-9, (aa - a * a / n) * (bb - b * b / n)));
}

bool IsComplete(const cv::Mat& image, int u, int v) {
  for (int j = -kHalfWindowPx; j <= kHalfWindowPx; ++j)
    for (int i = -kHalfWindowPx; i <= kHalfWindowPx; ++i)
      if (image.at<float>(v + j, u + i) < 0) return false;
  return true;
}

// Returns the best disparity, with parabolic interpolation.
std::optional<double> Match(const cv::Mat& left, const cv::Mat& right,
                            const Matching& matching, int u, int v) {
  constexpr double kMinCorrelation = 0.8;
  if (u - matching.max_disparity - 1 < kHalfWindowPx || !IsComplete(left, u, v))
    return std::nullopt;
  std::vector<double> scores;
  for (int d = matching.min_disparity; d <= matching.max_disparity; ++d)
    scores.push_back(Correlation(left, right, u, v, d));
  const auto best = std::max_element(scores.begin(), scores.end());
  const auto k = best - scores.begin();
  if (*best < kMinCorrelation || k == 0 ||
      k + 1 == static_cast<std::ptrdiff_t>(scores.size()) ||
      !IsComplete(right, u - matching.min_disparity - static_cast<int>(k), v))
    return std::nullopt;
  const double below = best[-1], above = best[1];
  return matching.min_disparity + static_cast<double>(k) +
         (below - above) / (2 * (below - 2 * *best + above));
}

// ---- Depth -----------------------------------------------------------------

// Returns the depth that corresponds to the centre of the disparity range.
double CenterDepthM(const StereoRig& cameras, const Matching& matching) {
  return RightCenter(cameras).norm() * matching.focal_px * 2 /
         (matching.min_disparity + matching.max_disparity);
}

// Returns the midpoint of the shortest segment between the observation lines of
// two pixels, in the left camera's frame; nullopt if it is not in front of the
// cameras.
std::optional<Eigen::Vector3d> ComputeMidpoint(const StereoRig& cameras,
                                               const Eigen::Vector2d& left,
                                               const Eigen::Vector2d& right) {
  const auto a = cameras.left->Line(left),
             in_right = cameras.right->Line(right);
  if (!a || !in_right) return std::nullopt;
  const Pose left_from_right = cameras.right_from_left.Inverse();
  const Eigen::Vector3d origin = left_from_right * in_right->origin;
  const Eigen::Vector3d direction =
      left_from_right.rotation * in_right->direction;
  const Eigen::Vector3d between = origin - a->origin;
  const double cosine = a->direction.dot(direction);
  const double squared_sine = 1 - cosine * cosine;
  if (!(squared_sine > 0)) return std::nullopt;
  const double along_a =
      (between.dot(a->direction) - cosine * between.dot(direction)) /
      squared_sine;
  const double along_b =
      (cosine * between.dot(a->direction) - between.dot(direction)) /
      squared_sine;
  if (along_a <= 0 || along_b <= 0) return std::nullopt;
  return Eigen::Vector3d(
      (a->origin + along_a * a->direction + origin + along_b * direction) / 2);
}

}  // namespace

double BaselineM(const StereoRig& cameras) {
  return RightCenter(cameras).norm();
}

StereoCloud MatchStereo(const StereoRig& cameras, const Matching& matching,
                        const cv::Mat& left, const cv::Mat& right,
                        int num_threads) {
  const ImageSize& size = cameras.left->image_size();
  const Eigen::Matrix3d left_from_rectified =
      RectifiedFromLeft(cameras).transpose();
  const Eigen::Matrix3d right_from_rectified =
      cameras.right_from_left.rotation.toRotationMatrix() * left_from_rectified;
  const double depth_m = CenterDepthM(cameras, matching);
  const cv::Mat a = Rectified(left, *cameras.left, left_from_rectified, depth_m,
                              matching, num_threads);
  const cv::Mat b = Rectified(right, *cameras.right, right_from_rectified,
                              depth_m, matching, num_threads);
  StereoCloud cloud;
  cloud.columns = (size.width - 2 * kHalfWindowPx - 1) / kStepPx + 1;
  const int rows = (size.height - 2 * kHalfWindowPx - 1) / kStepPx + 1;
  cloud.points.resize(static_cast<size_t>(cloud.columns) * rows);
  ParallelFor(rows, num_threads, [&](int j) {
    for (int i = 0; i < cloud.columns; ++i) {
      const int u = kHalfWindowPx + i * kStepPx,
                v = kHalfWindowPx + j * kStepPx;
      const auto disparity = Match(a, b, matching, u, v);
      if (!disparity) continue;
      const auto in_left = cameras.left->Project(
          depth_m * left_from_rectified * RectifiedRay(matching, size, u, v));
      const auto in_right = cameras.right->Project(
          depth_m * right_from_rectified *
          RectifiedRay(matching, cameras.right->image_size(), u - *disparity,
                       v));
      if (!in_left || !in_right) continue;
      if (const auto point = ComputeMidpoint(cameras, *in_left, *in_right))
        cloud.points[j * cloud.columns + i] = {*in_left, *point};
    }
  });
  return cloud;
}

Surface MakeSurface(const StereoCloud& cloud, const StereoRig& cameras,
                    const Matching& matching) {
  constexpr double kSmooth = 0.03;  // inverse depth, between control points
  const ImageSize size = cameras.left->image_size();
  const Eigen::Matrix3d rectified_from_left = RectifiedFromLeft(cameras);
  const double depth_m = CenterDepthM(cameras, matching);
  const int rows = static_cast<int>(cloud.points.size()) / cloud.columns;
  return [=, &cloud](
             const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector3d> {
    const auto line = cameras.left->Line(pixel);
    if (!line) return std::nullopt;
    const Eigen::Vector3d origin = rectified_from_left * line->origin;
    const Eigen::Vector3d direction = rectified_from_left * line->direction;
    if (direction.z() <= 0) return std::nullopt;
    // The point at this pixel of the rectified image.
    const Eigen::Vector3d ray =
        origin + direction * ((depth_m - origin.z()) / direction.z());
    const double x = (ray.x() / ray.z() * matching.focal_px +
                      (size.width - 1) / 2.0 - kHalfWindowPx) /
                     kStepPx;
    const double y = (ray.y() / ray.z() * matching.focal_px +
                      (size.height - 1) / 2.0 - kHalfWindowPx) /
                     kStepPx;
    const int i = std::clamp(static_cast<int>(x), 0, cloud.columns - 2);
    const int j = std::clamp(static_cast<int>(y), 0, rows - 2);
    double sum = 0, low = INFINITY, high = 0;
    for (int k = 0; k < 4; ++k) {
      const auto& node = cloud.points[(j + k / 2) * cloud.columns + i + k % 2];
      if (!node) return std::nullopt;
      const double inverse = 1 / (rectified_from_left * node->point).z();
      const double weight_x = k % 2 == 0 ? 1 - (x - i) : x - i;
      const double weight_y = k / 2 == 0 ? 1 - (y - j) : y - j;
      sum += weight_x * weight_y * inverse;
      low = std::min(low, inverse);
      high = std::max(high, inverse);
    }
    if (high > low * (1 + kSmooth) || !(sum > 0)) return std::nullopt;
    return Eigen::Vector3d(line->origin +
                           line->direction *
                               ((1 / sum - origin.z()) / direction.z()));
  };
}

namespace {

// Returns the similarity transform (Umeyama, 1991) from points of a cloud to
// the surface, without outliers: points whose depth error relative to the
// squared depth exceeds six times the median.
Eigen::Matrix4d EstimateRobustSimilarity(
    const StereoCloud& cloud, const std::vector<size_t>& matched,
    const std::vector<Eigen::Vector3d>& seen) {
  constexpr int kRounds = 20;
  constexpr double kTimesMedian = 6;
  std::vector<size_t> kept(matched.size());
  std::iota(kept.begin(), kept.end(), 0);
  Eigen::Matrix4d similarity;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3Xd from(3, kept.size()), to(3, kept.size());
    for (size_t i = 0; i < kept.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      from.col(column) = cloud.points[matched[kept[i]]]->point;
      to.col(column) = seen[kept[i]];
    }
    similarity = Eigen::umeyama(from, to, true);
    std::vector<double> errors;
    for (size_t k = 0; k < matched.size(); ++k) {
      const Eigen::Vector3d moved =
          (similarity * cloud.points[matched[k]]->point.homogeneous())
              .head<3>();
      errors.push_back(std::abs(moved.z() - seen[k].z()) /
                       seen[k].squaredNorm());
    }
    const double limit = kTimesMedian * Quantile(errors, 0.5);
    std::vector<size_t> consistent;
    for (size_t k = 0; k < matched.size(); ++k)
      if (errors[k] <= limit) consistent.push_back(k);
    if (consistent == kept) break;
    kept = std::move(consistent);
  }
  return similarity;
}

}  // namespace

DepthErrorMap CompareToSurface(const StereoCloud& cloud,
                               const Surface& surface) {
  constexpr size_t kMinMatches = 100;
  std::vector<size_t> matched;
  std::vector<Eigen::Vector3d> seen;
  for (size_t k = 0; k < cloud.points.size(); ++k) {
    if (!cloud.points[k]) continue;
    const auto point = surface(cloud.points[k]->left_pixel);
    if (!point) continue;
    matched.push_back(k);
    seen.push_back(*point);
  }
  if (matched.size() < kMinMatches)
    throw Error(ExitCode::kInsufficientData,
                "stereo-depth: too few stereo matches");
  const Eigen::Matrix4d similarity =
      EstimateRobustSimilarity(cloud, matched, seen);
  DepthErrorMap map;
  map.columns = cloud.columns;
  map.num_matched = static_cast<int>(matched.size());
  map.similarity_scale =
      std::cbrt(similarity.topLeftCorner<3, 3>().determinant());
  map.error_mm.assign(cloud.points.size(), NAN);
  map.depth_m.assign(cloud.points.size(), NAN);
  for (size_t k = 0; k < matched.size(); ++k) {
    const Eigen::Vector3d& point = cloud.points[matched[k]]->point;
    map.error_mm[matched[k]] =
        1000 * ((similarity * point.homogeneous()).z() - seen[k].z());
    map.depth_m[matched[k]] = seen[k].z();
  }
  return map;
}

}  // namespace raygrid
