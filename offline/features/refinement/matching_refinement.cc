#include "features/refinement/matching_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "appearance/board_appearance.h"
#include "dataset/kinds/star.h"
#include "features/refinement/float_lanes.h"

namespace raygrid {
namespace {

constexpr int kSupersampling = 4;  // along each axis
constexpr size_t kMinSamples = 40;
constexpr double kMaxShiftPx = 1.5;  // after the search at integer pixels
constexpr double kFirstSearchRadiusPx = 2;      // radius of the first search
constexpr double kMinCertainCorrelation = 0.7;  // minimum correlation to skip
                                                // the larger search
constexpr double kConvergedShiftPx = 0.03;  // convergence threshold; symmetry
                                            // refines further

// Pixel offsets from the centre, and the rendered intensities (1: white).
struct Rendering {
  std::vector<float> x, y, white;
  size_t size() const { return x.size(); }
};

// Random sample offsets in the window, the same for all features.
struct Places {
  std::vector<float> x, y;
};

Places MakeSamplePositions(int window_px) {
  Places places;
  std::mt19937 engine(1);
  const auto uniform = [&engine] {
    return static_cast<float>(engine() >> 8) * 0x1p-24f - 0.5f;
  };
  const int half = window_px / 2;
  for (int y = -half; y <= half; ++y) {
    for (int x = -half; x <= half; ++x) {
      places.x.push_back(static_cast<float>(x) + uniform());
      places.y.push_back(static_cast<float>(y) + uniform());
    }
  }
  return places;
}

// Cached; recomputed only if the window size changes.
const Places& GetWindowSamples(int window_px) {
  thread_local int made_for = 0;
  thread_local Places places;
  if (made_for != window_px) places = MakeSamplePositions(window_px);
  made_for = window_px;
  return places;
}

Rendering Render(const StarTexture& texture, const SymmetryMask& mask,
                 const LocalMapping& start, const Places& places) {
  const Eigen::Matrix2f inverse = start.linear.inverse().cast<float>();
  Eigen::Vector2f samples[kSupersampling * kSupersampling];
  for (int j = 0; j < kSupersampling; ++j)
    for (int i = 0; i < kSupersampling; ++i)
      samples[j * kSupersampling + i] =
          inverse * Eigen::Vector2f((i + 0.5f) / kSupersampling - 0.5f,
                                    (j + 0.5f) / kSupersampling - 0.5f);
  Rendering rendering;
  for (auto* column : {&rendering.x, &rendering.y, &rendering.white})
    column->reserve(places.x.size());
  for (size_t i = 0; i < places.x.size(); ++i) {
    const float x = places.x[i], y = places.y[i];
    const float u = inverse(0, 0) * x + inverse(0, 1) * y;
    const float v = inverse(1, 0) * x + inverse(1, 1) * y;
    if (!mask.IsSymmetric(u, v)) continue;
    int ink = 0;
    for (const Eigen::Vector2f& s : samples)
      ink += texture.Ink(u + s.x(), v + s.y());
    constexpr float kPart = 1.f / (kSupersampling * kSupersampling);
    rendering.x.push_back(x);
    rendering.y.push_back(y);
    rendering.white.push_back(1 - kPart * static_cast<float>(ink));
  }
  return rendering;
}

// Returns the samples that stay in the image if the centre moves by margin_px.
Rendering SelectSamplesInImage(const Rendering& rendering,
                               const ImageSize& size,
                               const Eigen::Vector2d& center,
                               double margin_px) {
  Rendering inside;
  const double x0 = margin_px - center.x(), y0 = margin_px - center.y();
  const double x1 = size.width - 1 - margin_px - center.x();
  const double y1 = size.height - 1 - margin_px - center.y();
  for (auto* column : {&inside.x, &inside.y, &inside.white})
    column->reserve(rendering.size());
  for (size_t i = 0; i < rendering.size(); ++i) {
    const double x = rendering.x[i], y = rendering.y[i];
    if (!(x >= x0 && x <= x1 && y >= y0 && y <= y1)) continue;
    inside.x.push_back(rendering.x[i]);
    inside.y.push_back(rendering.y[i]);
    inside.white.push_back(rendering.white[i]);
  }
  return inside;
}

// Sums over image intensities p and rendered intensities q, from which the
// optimal f and b and the correlation are computed.
struct Moments {
  double n = 0, p = 0, q = 0, pp = 0, pq = 0, qq = 0;

  double Covariance() const { return pq - p * q / n; }
  double Factor() const { return Covariance() / (pp - p * p / n); }
  double Bias() const { return (q - Factor() * p) / n; }
  double Correlation() const {
    const double variances = (pp - p * p / n) * (qq - q * q / n);
    return variances > 0 ? Covariance() / std::sqrt(variances) : 0;
  }
};

// Returns the intensity at a position, which is subtracted from all samples to
// preserve the precision of floats.
float ComputeMeanGreyLevel(const GreyImage& image, const Eigen::Vector2d& at) {
  const auto index = [](double x, int count) {
    return static_cast<int>(std::clamp(x, 0.0, count - 1.0));
  };
  return image.at(index(at.x(), image.size.width),
                  index(at.y(), image.size.height));
}

// Samples the nearest pixels, at integer shifts.
class ShiftedSamples {
 public:
  ShiftedSamples(const GreyImage& image, const Rendering& rendering,
                 const Eigen::Vector2d& start, int reach)
      : image_(image), middle_(ComputeMeanGreyLevel(image, start)) {
    const Eigen::Array2f first = start.array().cast<float>() + 0.5f;
    const Eigen::Array2i size(image.size.width, image.size.height);
    for (size_t i = 0; i < rendering.size(); i += kStride) {
      const Eigen::Array2f at(rendering.x[i], rendering.y[i]);
      const Eigen::Array2i pixel = (first + at).floor().cast<int>();
      are_samples_inside_ &=
          (pixel >= reach).all() && (pixel < size - reach).all();
      pixels_.push_back(pixel);
      sample_offsets_.push_back(pixel.y() * image.size.width + pixel.x());
      white_.push_back(rendering.white[i]);
      constant_moments_.q += rendering.white[i];
      constant_moments_.qq += rendering.white[i] * rendering.white[i];
    }
    constant_moments_.n = static_cast<double>(white_.size());
  }

  // Returns the correlation of the samples that are in the image after a shift;
  // -1 if there are too few.
  double Correlation(int x, int y) const {
    const Moments moments =
        are_samples_inside_ ? ComputeMoments(x, y) : ComputeMomentsInside(x, y);
    return moments.n * kStride < kMinSamples ? -1 : moments.Correlation();
  }

 private:
  static constexpr size_t kStride = 3;

  Moments ComputeMoments(int x, int y) const {
    const float* shifted = image_.levels.data();
    const int shift = y * image_.size.width + x;
    float p = 0, pp = 0, pq = 0;
    for (size_t i = 0; i < sample_offsets_.size(); ++i) {
      const float level = shifted[sample_offsets_[i] + shift] - middle_;
      p += level;
      pp += level * level;
      pq += level * white_[i];
    }
    return {constant_moments_.n, p, constant_moments_.q, pp, pq,
            constant_moments_.qq};
  }

  Moments ComputeMomentsInside(int x, int y) const {
    Moments moments;
    for (size_t i = 0; i < pixels_.size(); ++i) {
      const int column = pixels_[i].x() + x, row = pixels_[i].y() + y;
      if (column < 0 || row < 0 || column >= image_.size.width ||
          row >= image_.size.height)
        continue;
      const double level = image_.at(column, row) - middle_, q = white_[i];
      ++moments.n;
      moments.p += level;
      moments.q += q;
      moments.pp += level * level;
      moments.pq += level * q;
      moments.qq += q * q;
    }
    return moments;
  }

  const GreyImage& image_;
  float middle_;
  std::vector<Eigen::Array2i> pixels_;
  std::vector<int> sample_offsets_;
  std::vector<float> white_;
  bool are_samples_inside_ = true;
  Moments constant_moments_;  // terms that do not depend on the shift
};

// Returns the position with the highest correlation among integer shifts.
Eigen::Vector2d EstimateShift(const GreyImage& image,
                              const Rendering& rendering,
                              const Eigen::Vector2d& start, int reach) {
  const ShiftedSamples samples(image, rendering, start, reach);
  Eigen::Vector2d best = start;
  double best_correlation = -1;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const double correlation = samples.Correlation(x, y);
      if (correlation <= best_correlation) continue;
      best_correlation = correlation;
      best = start + Eigen::Vector2d(x, y);
    }
  }
  return best;
}

// Evaluates C_match near one position.
class Matching {
 public:
  Matching(const GreyImage& image, const Rendering& rendering,
           const Eigen::Vector2d& start)
      : image_(image),
        samples_(SelectSamplesInImage(rendering, image.size, start,
                                      kMaxShiftPx + 1)),
        middle_(ComputeMeanGreyLevel(image, start)) {
    const size_t whole = samples_.size() - samples_.size() % kLanes;
    for (auto* column : {&samples_.x, &samples_.y, &samples_.white})
      column->resize(whole);
    base_ = start.cast<int>().array() - kBasePx;
  }

  bool HasEnoughSamples() const { return samples_.size() >= kMinSamples; }

  // Computes one Gauss-Newton step for shift, factor and bias. moments: values
  // before the step.
  bool TakeStep(const Eigen::Vector2d& center, double f, double b,
                Eigen::Vector4d* step, Moments* moments) const {
    const auto x0 = static_cast<float>(center.x() - base_.x());
    const auto y0 = static_cast<float>(center.y() - base_.y());
    const int width = image_.size.width;
    const int origin = base_.y() * width + base_.x();
    FloatLanes xx = {}, xy = {}, yy = {}, xp = {}, yp = {}, xq = {}, yq = {};
    FloatLanes sx = {}, sy = {}, sp = {}, sq = {}, pp = {}, pq = {}, qq = {};
    for (size_t i = 0; i < samples_.size(); i += kLanes) {
      const FloatLanes q = LoadLanes(&samples_.white[i]);
      const SampledLanes s = Bilinear(image_.levels.data(), width, origin,
                                      x0 + LoadLanes(&samples_.x[i]),
                                      y0 + LoadLanes(&samples_.y[i]));
      const FloatLanes p = s.value - middle_;
      xx += s.dx * s.dx;
      xy += s.dx * s.dy;
      yy += s.dy * s.dy;
      xp += s.dx * p;
      yp += s.dy * p;
      xq += s.dx * q;
      yq += s.dy * q;
      sx += s.dx;
      sy += s.dy;
      sp += p;
      sq += q;
      pp += p * p;
      pq += p * q;
      qq += q * q;
    }
    const double n = static_cast<double>(samples_.size());
    *moments = {
        n,           SumLanes(sp), SumLanes(sq), SumLanes(pp), SumLanes(pq),
        SumLanes(qq)};
    // Normal equations of the Jacobian rows (f dp/dx, f dp/dy, p, 1) and the
    // residuals f p + b - q.
    Eigen::Matrix4d hessian;
    hessian << f * f * SumLanes(xx), f * f * SumLanes(xy), f * SumLanes(xp),
        f * SumLanes(sx), f * f * SumLanes(xy), f * f * SumLanes(yy),
        f * SumLanes(yp), f * SumLanes(sy), f * SumLanes(xp), f * SumLanes(yp),
        moments->pp, moments->p, f * SumLanes(sx), f * SumLanes(sy), moments->p,
        n;
    const Eigen::Vector4d gradient(
        f * (f * SumLanes(xp) + b * SumLanes(sx) - SumLanes(xq)),
        f * (f * SumLanes(yp) + b * SumLanes(sy) - SumLanes(yq)),
        f * moments->pp + b * moments->p - moments->pq,
        f * moments->p + b * n - moments->q);
    *step = -hessian.ldlt().solve(gradient);
    return step->allFinite();
  }

 private:
  // Keeps coordinates relative to base_ positive: windows are at most 101 px.
  static constexpr int kBasePx = 64;

  const GreyImage& image_;
  Rendering samples_;
  float middle_;
  Eigen::Vector2i base_;
};

// Searches integer shifts first, then applies the Gauss-Newton method.
MatchingResult MatchWithin(const GreyImage& image, const Rendering& rendering,
                           const Eigen::Vector2d& start, double search_px) {
  MatchingResult result;
  const Eigen::Vector2d first =
      EstimateShift(image, rendering, start, static_cast<int>(search_px));
  result.center = first;
  const Matching matching(image, rendering, first);
  if (!matching.HasEnoughSamples()) return result;
  double f = 0, b = 0;
  constexpr int kMaxSteps = 6;
  for (int i = 0; i < kMaxSteps; ++i) {
    Eigen::Vector4d step;
    Moments moments;
    if (!matching.TakeStep(result.center, f, b, &step, &moments)) return result;
    result.correlation = moments.Correlation();
    result.factor = moments.Factor();
    if (result.factor <= 0 || !std::isfinite(result.factor)) return result;
    if (i == 0) {  // initializes f and b
      f = result.factor;
      b = moments.Bias();
      continue;
    }
    // A star's correlation decreases within a pixel or two.
    constexpr double kMaxStepPx = 1;
    const Eigen::Vector2d move = step.head<2>();
    result.center += move * std::min(1.0, kMaxStepPx / move.norm());
    f += step[2];
    b += step[3];
    if ((result.center - first).norm() > kMaxShiftPx) return result;
    if (move.norm() < kConvergedShiftPx) break;
  }
  result.is_converged = true;
  return result;
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
  if (!start.center.allFinite()) return result;
  const Rendering rendering =
      Render(texture, mask, start, GetWindowSamples(window_px));
  if (rendering.size() < kMinSamples) return result;
  result = MatchWithin(image, rendering, start.center,
                       std::min(search_px, kFirstSearchRadiusPx));
  if (search_px <= kFirstSearchRadiusPx ||
      (result.is_converged && result.correlation >= kMinCertainCorrelation))
    return result;
  return MatchWithin(image, rendering, start.center, search_px);
}

}  // namespace raygrid
