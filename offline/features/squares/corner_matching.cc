#include "features/squares/corner_matching.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "features/refinement/float_lanes.h"

namespace raygrid {
namespace {

constexpr float kMinPatchContrast = 1;  // standard deviation, grey levels
constexpr double kFinestStepPx = 0.25;
constexpr double kStepSquares = 0.06;

constexpr int kNumSamples = DrawnPatch::kSamples * DrawnPatch::kSamples;
static_assert(kNumSamples % kLanes == 0);

float InterpolateBilinear(const GreyImage& image, float x, float y) {
  const int ix = std::min(static_cast<int>(x), image.size.width - 2);
  const int iy = std::min(static_cast<int>(y), image.size.height - 2);
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
  const float* p = &image.levels[static_cast<size_t>(iy) * image.size.width];
  const float* q = p + image.size.width;
  const float top = p[ix] + fx * (p[ix + 1] - p[ix]);
  const float bottom = q[ix] + fx * (q[ix + 1] - q[ix]);
  return top + fy * (bottom - top);
}

// A patch projected into an image by a mapping, which can be shifted.
class PatchOverlay {
 public:
  PatchOverlay(const GreyImage& image, const DrawnPatch& patch,
               const LocalMapping& mapping, double min_visible)
      : image_(image), patch_(patch), min_visible_(min_visible) {
    int i = 0;
    for (const Eigen::Vector2d& offset : patch.Offsets()) {
      const Eigen::Vector2f place = mapping(offset).cast<float>();
      x_[i] = place.x();
      y_[i++] = place.y();
    }
    first_ = {x_.minCoeff(), y_.minCoeff()};
    last_ = {x_.maxCoeff(), y_.maxCoeff()};
  }

  double Correlation(const Eigen::Vector2d& shift) const {
    Levels seen, drawn;
    const int count = Sample(shift.cast<float>(), &seen, &drawn);
    if (count == 0 || count < min_visible_ * kNumSamples) return -1;
    auto p = seen.head(count), q = drawn.head(count);
    p -= p.mean();
    q -= q.mean();
    const float var_p = p.square().mean(), var_q = q.square().mean();
    if (var_p < kMinPatchContrast * kMinPatchContrast || var_q < 1e-3F)
      return -1;
    return (p * q).mean() / std::sqrt(var_p * var_q);
  }

 private:
  using Levels = Eigen::Array<float, kNumSamples, 1>;

  // Returns the number of samples in the image, with their grey levels and
  // those of the drawing.
  int Sample(const Eigen::Vector2f& shift, Levels* seen, Levels* drawn) const {
    const int width = image_.size.width;
    const float x1 = static_cast<float>(width - 1);
    const float y1 = static_cast<float>(image_.size.height - 1);
    const Eigen::Vector2f first = first_ + shift, last = last_ + shift;
    if (first.x() >= 0 && first.y() >= 0 && last.x() < x1 && last.y() < y1) {
      for (int i = 0; i < kNumSamples; i += kLanes) {
        const FloatLanes value = Bilinear(image_.levels.data(), width, 0,
                                          LoadLanes(&x_[i]) + shift.x(),
                                          LoadLanes(&y_[i]) + shift.y())
                                     .value;
        std::memcpy(&(*seen)[i], &value, sizeof(value));
      }
      *drawn = Levels::Map(patch_.levels().data());
      return kNumSamples;
    }
    int count = 0;
    for (int i = 0; i < kNumSamples; ++i) {
      const float x = x_[i] + shift.x(), y = y_[i] + shift.y();
      if (!(x >= 0 && y >= 0 && x <= x1 && y <= y1)) continue;
      (*seen)[count] = InterpolateBilinear(image_, x, y);
      (*drawn)[count++] = patch_.levels()[i];
    }
    return count;
  }

  const GreyImage& image_;
  const DrawnPatch& patch_;
  double min_visible_;
  Levels x_, y_;                  // positions of the samples
  Eigen::Vector2f first_, last_;  // bounding box of the samples
};

}  // namespace

DrawnPatch::DrawnPatch(
    double reach,
    const std::function<bool(const Eigen::Vector2d& offset)>& is_black)
    : reach_(reach) {
  // Each sample is the mean of kSubsamples x kSubsamples points of its cell.
  constexpr int kSubsamples = 3;
  const double subsample_size = 2 * reach / kSamples / kSubsamples;
  for (const Eigen::Vector2d& offset : Offsets()) {
    int white = 0;
    for (int j = 0; j < kSubsamples; ++j)
      for (int i = 0; i < kSubsamples; ++i)
        white += !is_black(offset + subsample_size *
                                        Eigen::Vector2d(i - kSubsamples / 2,
                                                        j - kSubsamples / 2));
    levels_.push_back(static_cast<float>(white) / (kSubsamples * kSubsamples));
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

std::optional<double> ComputeMeanGreyLevel(const GreyImage& image,
                                           const LocalMapping& mapping,
                                           const Eigen::Vector2d& offset) {
  constexpr double kReach = 0.1;  // squares
  double sum = 0;
  for (const double dx : {-kReach, 0.0, kReach}) {
    for (const double dy : {-kReach, 0.0, kReach}) {
      const Eigen::Vector2d at = mapping(offset + Eigen::Vector2d(dx, dy));
      if (!WholeImage(image.size).Contains(at)) return std::nullopt;
      sum += InterpolateBilinear(image, static_cast<float>(at.x()),
                                 static_cast<float>(at.y()));
    }
  }
  return sum / 9;
}

PatchCorrelation FindPatch(const GreyImage& image, const DrawnPatch& patch,
                           const LocalMapping& prediction, double search_px,
                           double min_visible) {
  const PatchOverlay overlay(image, patch, prediction, min_visible);
  Eigen::Vector2d best_shift = Eigen::Vector2d::Zero();
  double best = overlay.Correlation(best_shift);
  const auto try_shift = [&](const Eigen::Vector2d& shift) {
    if (shift == best_shift || shift.norm() > search_px) return;
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
