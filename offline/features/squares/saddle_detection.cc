#include "features/squares/saddle_detection.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace raygrid {
namespace {

constexpr double kSmoothingPx = 1.2;
constexpr double kMinStrength = 0.2;  // grey levels per squared pixel

cv::Mat ScaleImage(const GreyImage& image, double scale) {
  const cv::Mat levels(image.size.height, image.size.width, CV_32F,
                       const_cast<float*>(image.levels.data()));
  cv::Mat scaled;
  if (scale == 1)
    scaled = levels;
  else
    cv::resize(levels, scaled, cv::Size(), scale, scale,
               scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  cv::Mat smooth;
  cv::GaussianBlur(scaled, smooth, cv::Size(), kSmoothingPx);
  return smooth;
}

struct Derivatives {
  Eigen::Vector2d gradient;
  Eigen::Matrix2d hessian;
};

Derivatives DerivativesAt(const cv::Mat& image, int x, int y) {
  const auto at = [&](int dx, int dy) {
    return static_cast<double>(image.at<float>(y + dy, x + dx));
  };
  Derivatives d;
  d.gradient = {(at(1, 0) - at(-1, 0)) / 2, (at(0, 1) - at(0, -1)) / 2};
  const double twice = 2 * at(0, 0);
  const double xy = (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) / 4;
  d.hessian << at(1, 0) + at(-1, 0) - twice, xy,  //
      xy, at(0, 1) + at(0, -1) - twice;
  return d;
}

// Returns minus the determinant of the Hessian at each pixel.
cv::Mat ComputeStrengths(const cv::Mat& image) {
  cv::Mat strengths = cv::Mat::zeros(image.size(), CV_32F);
  for (int y = 1; y + 1 < image.rows; ++y) {
    const float* above = image.ptr<float>(y - 1);
    const float* here = image.ptr<float>(y);
    const float* below = image.ptr<float>(y + 1);
    float* strength = strengths.ptr<float>(y);
    for (int x = 1; x + 1 < image.cols; ++x) {
      const float xx = here[x + 1] + here[x - 1] - 2 * here[x];
      const float yy = above[x] + below[x] - 2 * here[x];
      const float xy =
          (above[x - 1] + below[x + 1] - above[x + 1] - below[x - 1]) / 4;
      strength[x] = xy * xy - xx * yy;
    }
  }
  return strengths;
}

bool IsLocalMaximum(const cv::Mat& values, int x, int y) {
  const float value = values.at<float>(y, x);
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const float other = values.at<float>(y + dy, x + dx);
      if (other > value || (other == value && (dy < 0 || (dy == 0 && dx < 0))))
        return false;
    }
  return true;
}

}  // namespace

std::array<Eigen::Vector2d, 2> Saddle::Edges() const {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(hessian);
  // Eigenvectors: directions of the most negative and most positive curvature.
  const double falling = std::sqrt(std::max(0.0, -solver.eigenvalues()[0]));
  const double rising = std::sqrt(std::max(0.0, solver.eigenvalues()[1]));
  const Eigen::Vector2d valley = falling * solver.eigenvectors().col(1);
  const Eigen::Vector2d ridge = rising * solver.eigenvectors().col(0);
  const Eigen::Vector2d a = (valley + ridge).normalized();
  const Eigen::Vector2d b = (valley - ridge).normalized();
  if (a.x() * b.y() - a.y() * b.x() > 0) return {a, b};
  return {b, a};
}

std::vector<Saddle> FindSaddles(const GreyImage& image, double scale,
                                int max_count) {
  const cv::Mat smooth = ScaleImage(image, scale);
  const cv::Mat strengths = ComputeStrengths(smooth);
  std::vector<Saddle> saddles;
  for (int y = 2; y + 2 < smooth.rows; ++y) {
    for (int x = 2; x + 2 < smooth.cols; ++x) {
      const float strength = strengths.at<float>(y, x);
      if (strength < kMinStrength * kMinStrength ||
          !IsLocalMaximum(strengths, x, y))
        continue;
      const Derivatives d = DerivativesAt(smooth, x, y);
      const Eigen::Vector2d step = -d.hessian.inverse() * d.gradient;
      // Corners of single squares have similar determinants, but larger
      // gradients.
      constexpr double kMaxStepPx = 1;
      if (step.norm() > kMaxStepPx) continue;
      Saddle saddle;
      saddle.pixel =
          ((Eigen::Vector2d(x, y) + step).array() + 0.5) / scale - 0.5;
      saddle.hessian = d.hessian;
      saddle.strength = std::sqrt(strength);
      saddles.push_back(saddle);
    }
  }
  std::stable_sort(
      saddles.begin(), saddles.end(),
      [](const Saddle& a, const Saddle& b) { return a.strength > b.strength; });
  if (static_cast<int>(saddles.size()) > max_count) saddles.resize(max_count);
  return saddles;
}

}  // namespace raygrid
