#include "features/star/star_candidates.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "features/board_view/image_noise.h"

namespace raygrid {
namespace {

// Standard deviation of the Gaussian weights of edges around a pixel: a quarter
// of the side of the smallest star.
constexpr double kSigmaPx = 2.6;
constexpr int kRadiusPx = 6;
constexpr int kNumScales = 3;  // factor 2 between successive scales
constexpr double kMaxScatter = 0.35;
// Minimum isotropy of the gradients: edges must have different directions.
constexpr double kMinIsotropy = 0.25;
constexpr size_t kMaxCandidates = 3000;
constexpr double kMinGradient = 2;  // RMS, in grey levels per pixel, for images
                                    // with noise; see FindStarCandidates()
constexpr double kMinGradientOverNoise = 1;  // for images with little noise

// Gradient products, and the scatter of the edges around each pixel.
struct GradientMaps {
  cv::Mat xx, xy, yy;
  cv::Mat scatter;  // S / T
  cv::Mat energy;   // T, normalized by the sum of weights
};

// Returns the 1-D kernel w(d) d^power for d = -kRadiusPx ... kRadiusPx.
cv::Mat Kernel(int power) {
  cv::Mat kernel(2 * kRadiusPx + 1, 1, CV_32F);
  double sum = 0;
  for (int d = -kRadiusPx; d <= kRadiusPx; ++d)
    sum += std::exp(-d * d / (2 * kSigmaPx * kSigmaPx));
  for (int d = -kRadiusPx; d <= kRadiusPx; ++d)
    kernel.at<float>(d + kRadiusPx) =
        static_cast<float>(std::exp(-d * d / (2 * kSigmaPx * kSigmaPx)) / sum *
                           std::pow(d, power));
  return kernel;
}

cv::Mat FilterImage(const cv::Mat& image, int power_x, int power_y) {
  cv::Mat filtered;
  // sepFilter2D() computes a correlation, so odd powers keep their sign.
  cv::sepFilter2D(image, filtered, CV_32F, Kernel(power_x), Kernel(power_y),
                  cv::Point(-1, -1), 0, cv::BORDER_REFLECT);
  return filtered;
}

// Computes, for each pixel c, S(c) = sum w (g . (x - c))^2, normalized by T(c)
// = sum w |g|^2 |x - c|^2 / 2, the expected S(c) for gradients g of random
// directions.
GradientMaps MakeMaps(const cv::Mat& image) {
  cv::Mat gx, gy;
  cv::Scharr(image, gx, CV_32F, 1, 0, 1 / 32.0);
  cv::Scharr(image, gy, CV_32F, 0, 1, 1 / 32.0);
  GradientMaps maps;
  maps.xx = gx.mul(gx);
  maps.xy = gx.mul(gy);
  maps.yy = gy.mul(gy);
  const cv::Mat all = maps.xx + maps.yy;
  const cv::Mat s = FilterImage(maps.xx, 2, 0) +
                    2 * FilterImage(maps.xy, 1, 1) + FilterImage(maps.yy, 0, 2);
  maps.energy = (FilterImage(all, 2, 0) + FilterImage(all, 0, 2)) / 2;
  maps.scatter = s / (maps.energy + 1e-3f);
  return maps;
}

bool IsLocalMinimum(const cv::Mat& map, int x, int y) {
  constexpr int kReach = 2;
  const float value = map.at<float>(y, x);
  for (int dy = -kReach; dy <= kReach; ++dy)
    for (int dx = -kReach; dx <= kReach; ++dx)
      if (map.at<float>(y + dy, x + dx) < value) return false;
  return true;
}

// Isotropy of the gradient directions (0 to 1), and intersection of the edges.
struct JunctionFit {
  double isotropy = 0;
  Eigen::Vector2d offset = {0, 0};
};

JunctionFit FitJunction(const GradientMaps& maps, int x, int y) {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (int dy = -kRadiusPx; dy <= kRadiusPx; ++dy) {
    for (int dx = -kRadiusPx; dx <= kRadiusPx; ++dx) {
      const double weight =
          std::exp(-(dx * dx + dy * dy) / (2 * kSigmaPx * kSigmaPx));
      Eigen::Matrix2d product;
      product << maps.xx.at<float>(y + dy, x + dx),
          maps.xy.at<float>(y + dy, x + dx), maps.xy.at<float>(y + dy, x + dx),
          maps.yy.at<float>(y + dy, x + dx);
      sum += weight * product;
      right += weight * product * Eigen::Vector2d(dx, dy);
    }
  }
  JunctionFit junction;
  const double trace = sum.trace();
  if (trace <= 0) return junction;
  junction.isotropy = 4 * sum.determinant() / (trace * trace);
  if (junction.isotropy > 1e-3) junction.offset = sum.inverse() * right;
  return junction;
}

void FindCandidatesAtScale(const cv::Mat& image, double scale,
                           double min_gradient,
                           std::vector<StarCandidate>* candidates) {
  const GradientMaps maps = MakeMaps(image);
  const double min_energy = min_gradient * min_gradient * kSigmaPx * kSigmaPx;
  for (int y = kRadiusPx; y < image.rows - kRadiusPx; ++y) {
    for (int x = kRadiusPx; x < image.cols - kRadiusPx; ++x) {
      const float scatter = maps.scatter.at<float>(y, x);
      if (scatter > kMaxScatter || maps.energy.at<float>(y, x) < min_energy ||
          !IsLocalMinimum(maps.scatter, x, y))
        continue;
      const JunctionFit junction = FitJunction(maps, x, y);
      constexpr double kMaxOffsetPx = 2;
      if (junction.isotropy < kMinIsotropy ||
          junction.offset.norm() > kMaxOffsetPx)
        continue;
      const Eigen::Vector2d place = Eigen::Vector2d(x, y) + junction.offset;
      candidates->push_back({(place.array() + 0.5) * scale - 0.5, scatter});
    }
  }
}

// Returns the candidates without duplicates: of those closer than 3 px (found
// at several scales), the one with the least scatter is kept.
std::vector<StarCandidate> RemoveDuplicates(
    std::vector<StarCandidate> candidates) {
  constexpr double kSamePx = 3;
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const StarCandidate& a, const StarCandidate& b) {
                     return a.scatter < b.scatter;
                   });
  if (candidates.size() > kMaxCandidates) candidates.resize(kMaxCandidates);
  std::vector<StarCandidate> distinct;
  for (const StarCandidate& candidate : candidates)
    if (std::none_of(distinct.begin(), distinct.end(),
                     [&](const StarCandidate& other) {
                       return (other.pixel - candidate.pixel).norm() < kSamePx;
                     }))
      distinct.push_back(candidate);
  return distinct;
}

}  // namespace

std::vector<StarCandidate> FindStarCandidates(const GreyImage& image) {
  const double min_gradient = std::min(
      kMinGradient, kMinGradientOverNoise * EstimateNoise(image) + 0.2);
  std::vector<StarCandidate> found;
  cv::Mat scaled(image.size.height, image.size.width, CV_32F,
                 const_cast<float*>(image.levels.data()));
  double scale = 1;
  for (int k = 0; k < kNumScales; ++k) {
    if (std::min(scaled.cols, scaled.rows) < 4 * kRadiusPx) break;
    FindCandidatesAtScale(scaled, scale, min_gradient, &found);
    cv::Mat half;
    cv::resize(scaled, half, cv::Size(scaled.cols / 2, scaled.rows / 2), 0, 0,
               cv::INTER_AREA);
    scaled = half;
    scale *= 2;
  }
  return RemoveDuplicates(std::move(found));
}

}  // namespace raygrid
