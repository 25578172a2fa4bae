#include "features/squares/corner_matching.h"

#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr double kMinPatchContrast = 1;  // standard deviation, grey levels
constexpr double kFinestStepPx = 0.25;
constexpr double kStepSquares = 0.06;

constexpr int kNumSamples = DrawnPatch::kSamples * DrawnPatch::kSamples;

float Interpolated(const GreyImage& image, float x, float y) {
  const int ix = std::min(static_cast<int>(x), image.size.width - 2);
  const int iy = std::min(static_cast<int>(y), image.size.height - 2);
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
  const float* p = &image.levels[static_cast<size_t>(iy) * image.size.width];
  const float* q = p + image.size.width;
  const float top = p[ix] + fx * (p[ix + 1] - p[ix]);
  const float bottom = q[ix] + fx * (q[ix + 1] - q[ix]);
  return top + fy * (bottom - top);
}

// A patch laid over an image by a mapping, to be shifted.
class PatchOverlay {
 public:
  PatchOverlay(const GreyImage& image, const DrawnPatch& patch,
               const LocalMapping& mapping, double min_visible)
      : image_(image), patch_(patch), min_visible_(min_visible) {
    for (const Eigen::Vector2d& offset : patch.Offsets())
      places_.push_back(mapping(offset).cast<float>());
  }

  double Correlation(const Eigen::Vector2d& shift) const {
    const Eigen::Vector2f s = shift.cast<float>();
    const float x1 = static_cast<float>(image_.size.width - 1);
    const float y1 = static_cast<float>(image_.size.height - 1);
    int count = 0;
    double sum_p = 0, sum_q = 0, sum_pp = 0, sum_qq = 0, sum_pq = 0;
    for (int i = 0; i < kNumSamples; ++i) {
      const float x = places_[i].x() + s.x(), y = places_[i].y() + s.y();
      if (!(x >= 0 && y >= 0 && x <= x1 && y <= y1)) continue;
      const double p = Interpolated(image_, x, y), q = patch_.levels()[i];
      ++count;
      sum_p += p;
      sum_q += q;
      sum_pp += p * p;
      sum_qq += q * q;
      sum_pq += p * q;
    }
    if (count < min_visible_ * kNumSamples) return -1;
    const double var_p = sum_pp / count - sum_p * sum_p / count / count;
    const double var_q = sum_qq / count - sum_q * sum_q / count / count;
    if (var_p < kMinPatchContrast * kMinPatchContrast || var_q < 1e-3)
      return -1;
    return (sum_pq / count - sum_p * sum_q / count / count) /
           std::sqrt(var_p * var_q);
  }

 private:
  const GreyImage& image_;
  const DrawnPatch& patch_;
  double min_visible_;
  std::vector<Eigen::Vector2f> places_;
};

}  // namespace

DrawnPatch::DrawnPatch(
    double reach,
    const std::function<bool(const Eigen::Vector2d& offset)>& is_black)
    : reach_(reach) {
  // Each sample is the mean over its cell.
  constexpr int kParts = 3;
  const double part = 2 * reach / kSamples / kParts;
  for (const Eigen::Vector2d& offset : Offsets()) {
    int white = 0;
    for (int j = 0; j < kParts; ++j)
      for (int i = 0; i < kParts; ++i)
        white += !is_black(
            offset + part * Eigen::Vector2d(i - kParts / 2, j - kParts / 2));
    levels_.push_back(static_cast<float>(white) / (kParts * kParts));
  }
}

std::vector<Eigen::Vector2d> DrawnPatch::Offsets() const {
  std::vector<Eigen::Vector2d> offsets;
  for (int j = 0; j < kSamples; ++j)
    for (int i = 0; i < kSamples; ++i)
      offsets.push_back(reach_ * Eigen::Vector2d((2 * i + 1.0) / kSamples - 1,
                                                 (2 * j + 1.0) / kSamples - 1));
  return offsets;
}

std::optional<double> MeanLevel(const GreyImage& image,
                                const LocalMapping& mapping,
                                const Eigen::Vector2d& offset) {
  constexpr double kReach = 0.1;  // squares
  double sum = 0;
  for (const double dx : {-kReach, 0.0, kReach}) {
    for (const double dy : {-kReach, 0.0, kReach}) {
      const Eigen::Vector2d at = mapping(offset + Eigen::Vector2d(dx, dy));
      if (!WholeImage(image.size).Contains(at)) return std::nullopt;
      sum += Interpolated(image, static_cast<float>(at.x()),
                          static_cast<float>(at.y()));
    }
  }
  return sum / 9;
}

PatchMatch FindPatch(const GreyImage& image, const DrawnPatch& patch,
                     const LocalMapping& prediction, double search_px,
                     double min_visible) {
  const PatchOverlay overlay(image, patch, prediction, min_visible);
  Eigen::Vector2d best_shift = Eigen::Vector2d::Zero();
  double best = overlay.Correlation(best_shift);
  const auto try_shift = [&](const Eigen::Vector2d& shift) {
    if (shift.norm() > search_px) return;
    const double correlation = overlay.Correlation(shift);
    if (correlation <= best) return;
    best = correlation;
    best_shift = shift;
  };
  double step =
      std::max(2 * kFinestStepPx, kStepSquares * prediction.SpacingPx());
  const int reach = static_cast<int>(search_px / step);
  for (int j = -reach; j <= reach; ++j)
    for (int i = -reach; i <= reach; ++i)
      try_shift(step * Eigen::Vector2d(i, j));
  for (; step > kFinestStepPx; step /= 2) {
    const Eigen::Vector2d around = best_shift;
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i)
        try_shift(around + step / 2 * Eigen::Vector2d(i, j));
  }
  return {best, prediction.center + best_shift};
}

}  // namespace raygrid
