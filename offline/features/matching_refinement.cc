#include "features/matching_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "appearance/board_appearance.h"

namespace raygrid {
namespace {

// Offsets from the centre, and the ink that the rendering has there.
struct Rendering {
  std::vector<float> x, y, ink;
  size_t size() const { return x.size(); }
};

constexpr int kSupersampling = 4;  // along each axis
constexpr size_t kMinSamples = 40;

Rendering Render(const StarTexture& texture, const SymmetryMask& mask,
                 const LocalMapping& start, int window_px) {
  Rendering rendering;
  const Eigen::Matrix2f inverse = start.linear.inverse().cast<float>();
  std::mt19937 engine(1);
  const auto uniform = [&engine] {
    return static_cast<float>(engine() >> 8) * 0x1p-24f - 0.5f;
  };
  const int half = window_px / 2;
  for (int row = -half; row <= half; ++row) {
    for (int column = -half; column <= half; ++column) {
      const float x = static_cast<float>(column) + uniform();
      const float y = static_cast<float>(row) + uniform();
      const Eigen::Vector2f place = inverse * Eigen::Vector2f(x, y);
      if (!mask.IsSymmetric(place.x(), place.y())) continue;
      float ink = 0;
      for (int j = 0; j < kSupersampling; ++j) {
        for (int i = 0; i < kSupersampling; ++i) {
          const Eigen::Vector2f sample =
              place + inverse * Eigen::Vector2f((i + 0.5f) / 4 - 0.5f,
                                                (j + 0.5f) / 4 - 0.5f);
          ink += texture.Ink(sample.x(), sample.y());
        }
      }
      rendering.x.push_back(x);
      rendering.y.push_back(y);
      rendering.ink.push_back(1 - ink / (kSupersampling * kSupersampling));
    }
  }
  return rendering;
}

// Sums for the best f and b, and for the correlation.
struct Moments {
  double n = 0, p = 0, q = 0, pp = 0, pq = 0, qq = 0;

  void Add(double image, double rendering) {
    n += 1;
    p += image;
    q += rendering;
    pp += image * image;
    pq += image * rendering;
    qq += rendering * rendering;
  }
  double Covariance() const { return pq - p * q / n; }
  double Factor() const { return Covariance() / (pp - p * p / n); }
  double Bias() const { return (q - Factor() * p) / n; }
  double Correlation() const {
    const double variances = (pp - p * p / n) * (qq - q * q / n);
    return variances > 0 ? Covariance() / std::sqrt(variances) : 0;
  }
};

bool IsInside(const GreyImage& image, double x, double y) {
  return x >= 1 && y >= 1 && x < image.size.width - 2 &&
         y < image.size.height - 2;
}

// Correlation at nearest pixels, with every stride-th sample.
double CoarseCorrelation(const GreyImage& image, const Rendering& rendering,
                         const Eigen::Vector2d& center, size_t stride) {
  Moments moments;
  for (size_t i = 0; i < rendering.size(); i += stride) {
    const double x = center.x() + rendering.x[i];
    const double y = center.y() + rendering.y[i];
    if (!IsInside(image, x, y)) continue;
    moments.Add(image.at(static_cast<int>(x + 0.5), static_cast<int>(y + 0.5)),
                rendering.ink[i]);
  }
  if (moments.n * stride < kMinSamples) return -1;
  return moments.Correlation();
}

Eigen::Vector2d CoarseSearch(const GreyImage& image, const Rendering& rendering,
                             const Eigen::Vector2d& start, double search_px) {
  const int reach = static_cast<int>(search_px);
  Eigen::Vector2d best = start;
  double best_correlation = -1;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const Eigen::Vector2d center = start + Eigen::Vector2d(x, y);
      const double correlation = CoarseCorrelation(image, rendering, center, 3);
      if (correlation > best_correlation) {
        best_correlation = correlation;
        best = center;
      }
    }
  }
  return best;
}

// One step of Gauss and Newton's method for shift, factor and bias; the
// moments are those before the step.
bool Step(const GreyImage& image, const Rendering& rendering,
          const Eigen::Vector2d& center, double f, double b,
          Eigen::Vector4d* step, Moments* moments) {
  Eigen::Matrix4d hessian = Eigen::Matrix4d::Zero();
  Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
  for (size_t i = 0; i < rendering.size(); ++i) {
    const double x = center.x() + rendering.x[i];
    const double y = center.y() + rendering.y[i];
    if (!IsInside(image, x, y)) continue;
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    const double fx = x - ix, fy = y - iy;
    const float* pixel = &image.levels[iy * image.size.width + ix];
    const double p00 = pixel[0], p10 = pixel[1];
    const double p01 = pixel[image.size.width];
    const double p11 = pixel[image.size.width + 1];
    const double p = (p00 * (1 - fx) + p10 * fx) * (1 - fy) +
                     (p01 * (1 - fx) + p11 * fx) * fy;
    const Eigen::Vector4d jacobian(
        f * ((p10 - p00) * (1 - fy) + (p11 - p01) * fy),
        f * ((p01 - p00) * (1 - fx) + (p11 - p10) * fx), p, 1);
    hessian += jacobian * jacobian.transpose();
    gradient += jacobian * (f * p + b - rendering.ink[i]);
    moments->Add(p, rendering.ink[i]);
  }
  if (moments->n < kMinSamples) return false;
  *step = -hessian.ldlt().solve(gradient);
  return step->allFinite();
}

}  // namespace

StarTexture::StarTexture(int segments) : texels_(kTexels * kTexels) {
  for (int j = 0; j < kTexels; ++j)
    for (int i = 0; i < kTexels; ++i)
      texels_[j * kTexels + i] = IsBlackInStar(
          segments, (i + 0.5) / kTexels - 0.5, (j + 0.5) / kTexels - 0.5);
}

MatchingResult MatchStar(const GreyImage& image, const StarTexture& texture,
                         const SymmetryMask& mask, const LocalMapping& start,
                         int window_px, double search_px) {
  MatchingResult result;
  result.center = start.center;
  const Rendering rendering = Render(texture, mask, start, window_px);
  if (rendering.size() < kMinSamples) return result;
  if (search_px >= 1)
    result.center = CoarseSearch(image, rendering, start.center, search_px);
  double f = 0, b = 0;
  constexpr int kMaxSteps = 6;
  for (int i = 0; i < kMaxSteps; ++i) {
    Eigen::Vector4d step;
    Moments moments;
    if (!Step(image, rendering, result.center, f, b, &step, &moments))
      return result;
    result.correlation = moments.Correlation();
    result.factor = moments.Factor();
    if (result.factor <= 0 || !std::isfinite(result.factor)) return result;
    if (i == 0) {  // only now are f and b known
      f = result.factor;
      b = moments.Bias();
      continue;
    }
    // A star's correlation falls off within a pixel or two.
    constexpr double kMaxStepPx = 1;
    const Eigen::Vector2d move = step.head<2>();
    result.center += move * std::min(1.0, kMaxStepPx / move.norm());
    f += step[2];
    b += step[3];
    if ((result.center - start.center).norm() > search_px + 1.5) return result;
    constexpr double kConvergedPx = 0.01;
    if (move.norm() < kConvergedPx) break;
  }
  result.is_converged = true;
  return result;
}

}  // namespace raygrid
