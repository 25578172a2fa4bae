#include "features/refinement/symmetry_patch.h"

#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

// Lanczos coefficients (a = 4) of the four pixels on each side of the midpoint
// between two pixels.
constexpr float kHalfway[4] = {0.61892f, -0.16603f, 0.05972f, -0.01261f};
constexpr int kTaps = 4;

inline float InterpolateHalfway(float a0, float a1, float a2, float a3,
                                float b0, float b1, float b2, float b3) {
  return kHalfway[0] * (a0 + b0) + kHalfway[1] * (a1 + b1) +
         kHalfway[2] * (a2 + b2) + kHalfway[3] * (a3 + b3);
}

// Copies a square of the image, row-major; edge pixels are replicated.
void CopySquare(const GreyImage& image, const Eigen::Vector2i& first, int side,
                float* square) {
  const int width = image.size.width, height = image.size.height;
  const bool is_inside = first.x() >= 0 && first.x() + side <= width;
  for (int y = 0; y < side; ++y, square += side) {
    const float* row = &image.levels[static_cast<size_t>(std::clamp(
                                         first.y() + y, 0, height - 1)) *
                                     width];
    if (is_inside)
      std::copy(row + first.x(), row + first.x() + side, square);
    else
      for (int x = 0; x < side; ++x)
        square[x] = row[std::clamp(first.x() + x, 0, width - 1)];
  }
}

// Upsamples a row by a factor of 2: values of `in` from index kTaps - 1 on, and
// interpolated values between them.
void EnlargeRow(const float* in, int count, float* halfway, float* out) {
  in += kTaps - 1;
  for (int x = 0; x < count; ++x)
    halfway[x] = InterpolateHalfway(in[x], in[x - 1], in[x - 2], in[x - 3],
                                    in[x + 1], in[x + 2], in[x + 3], in[x + 4]);
  for (int x = 0; x < count; ++x) {
    out[2 * x] = in[x];
    out[2 * x + 1] = halfway[x];
  }
}

// Interpolates the row halfway between `row` and the following one.
void InterpolateHalfwayRow(const float* row, int width, float* out) {
  const auto at = [row, width](int y) { return row + y * width; };
  const float *a0 = at(0), *a1 = at(-1), *a2 = at(-2), *a3 = at(-3);
  const float *b0 = at(1), *b1 = at(2), *b2 = at(3), *b3 = at(4);
  for (int x = 0; x < width; ++x)
    out[x] = InterpolateHalfway(a0[x], a1[x], a2[x], a3[x], b0[x], b1[x], b2[x],
                                b3[x]);
}

// Returns a square with a side of 2 count values, upsampled from one with a
// side of count + 2 kTaps - 1 values.
std::vector<float> EnlargePatch(const std::vector<float>& square, int count) {
  const int side = count + 2 * kTaps - 1, width = 2 * count;
  std::vector<float> rows(static_cast<size_t>(side) * width);
  std::vector<float> halfway(count);
  for (int y = 0; y < side; ++y)
    EnlargeRow(&square[static_cast<size_t>(y) * side], count, halfway.data(),
               &rows[static_cast<size_t>(y) * width]);
  std::vector<float> enlarged(static_cast<size_t>(width) * width);
  for (int y = 0; y < count; ++y) {
    const float* row = &rows[static_cast<size_t>(y + kTaps - 1) * width];
    float* out = &enlarged[static_cast<size_t>(2 * y) * width];
    std::copy(row, row + width, out);
    InterpolateHalfwayRow(row, width, out + width);
  }
  return enlarged;
}

// Central differences; zero along the edge.
void Gradients(const std::vector<float>& levels, int side,
               std::vector<float>* gx, std::vector<float>* gy) {
  gx->assign(levels.size(), 0);
  gy->assign(levels.size(), 0);
  for (int y = 1; y + 1 < side; ++y) {
    for (int x = 1; x + 1 < side; ++x) {
      const float* p = &levels[static_cast<size_t>(y) * side + x];
      (*gx)[static_cast<size_t>(y) * side + x] = p[1] - p[-1];
      (*gy)[static_cast<size_t>(y) * side + x] = p[side] - p[-side];
    }
  }
}

}  // namespace

SymmetryPatch::SymmetryPatch(const GreyImage& image, Refinement refinement,
                             const Eigen::Vector2i& center, int reach_px)
    : refinement_(refinement),
      side_(2 * (2 * reach_px + 1)),
      origin_(center.array() - reach_px) {
  const int count = 2 * reach_px + 1, side = count + 2 * kTaps - 1;
  std::vector<float> square(static_cast<size_t>(side) * side);
  CopySquare(image, origin_.array() - (kTaps - 1), side, square.data());
  std::vector<float> levels = EnlargePatch(square, count);
  if (refinement != Refinement::kGradientsXY &&
      refinement != Refinement::kGradientMagnitude) {
    channels_.push_back(std::move(levels));
    return;
  }
  std::vector<float> gx, gy;
  Gradients(levels, side_, &gx, &gy);
  if (refinement == Refinement::kGradientsXY) {
    channels_.push_back(std::move(gx));
    channels_.push_back(std::move(gy));
    return;
  }
  for (size_t i = 0; i < gx.size(); ++i)
    gx[i] = std::sqrt(gx[i] * gx[i] + gy[i] * gy[i]);
  channels_.push_back(std::move(gx));
}

SymmetryPatch::Reflection SymmetryPatch::ComputeReflection(
    bool inverts_colors) const {
  switch (refinement_) {
    case Refinement::kGradientsXY:
      return {inverts_colors ? 1.f : -1.f, false};
    case Refinement::kGradientMagnitude:
      return {1.f, false};
    default:
      return {inverts_colors ? -1.f : 1.f, inverts_colors};
  }
}

}  // namespace raygrid
