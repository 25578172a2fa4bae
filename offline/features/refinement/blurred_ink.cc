#include "features/refinement/blurred_ink.h"

#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

constexpr double kSameLine = 1e-9;

void AddLine(double place, std::vector<double>* lines) {
  for (const double line : *lines)
    if (std::fabs(line - place) < kSameLine) return;
  lines->push_back(place);
}

int LineAt(double place, const std::vector<double>& lines) {
  int k = 0;
  while (std::fabs(lines[k] - place) >= kSameLine) ++k;
  return k;
}

}  // namespace

Quadrants::Quadrants(const std::vector<InkRectangle>& ink, double reach) {
  std::vector<InkRectangle> near;
  for (InkRectangle r : ink) {
    r = {std::max(r.u0, -reach), std::max(r.v0, -reach), std::min(r.u1, reach),
         std::min(r.v1, reach)};
    if (r.u0 < r.u1 && r.v0 < r.v1) near.push_back(r);
  }
  for (const InkRectangle& r : near) {
    for (const double u : {r.u0, r.u1}) AddLine(u, &u_);
    for (const double v : {r.v0, r.v1}) AddLine(v, &v_);
  }
  weights_ = Eigen::MatrixXd::Zero(u_.size(), v_.size());
  for (const InkRectangle& r : near) {
    const int u0 = LineAt(r.u0, u_), u1 = LineAt(r.u1, u_);
    const int v0 = LineAt(r.v0, v_), v1 = LineAt(r.v1, v_);
    weights_(u0, v0) += 1;
    weights_(u1, v1) += 1;
    weights_(u0, v1) -= 1;
    weights_(u1, v0) -= 1;
  }
}

InkBlurrer::InkBlurrer(const Quadrants& quadrants, const BoardBlur& blur)
    : quadrants_(quadrants),
      blur_(blur),
      steps_u_(quadrants.u().size()),
      steps_v_(quadrants.v().size()) {}

InkBlurrer::Step InkBlurrer::EvaluateBlurredStep(double offset, double sigma) {
  const double t = offset / sigma;
  constexpr double kFar = 6;
  if (t > kFar) return {kFar, 0, 1};
  if (t < -kFar) return {-kFar, 0, 0};
  return {t, std::exp(-t * t / 2) / std::sqrt(2 * M_PI),
          0.5 * std::erfc(-t * M_SQRT1_2)};
}

BlurredInk InkBlurrer::At(double u, double v) {
  for (size_t i = 0; i < steps_u_.size(); ++i)
    steps_u_[i] = EvaluateBlurredStep(u - quadrants_.u()[i], blur_.sigma_u);
  for (size_t j = 0; j < steps_v_.size(); ++j)
    steps_v_[j] = EvaluateBlurredStep(v - quadrants_.v()[j], blur_.sigma_v);
  const double r = blur_.correlation;
  BlurredInk sum;
  for (size_t i = 0; i < steps_u_.size(); ++i) {
    const Step& a = steps_u_[i];
    if (a.sum == 0) continue;
    for (size_t j = 0; j < steps_v_.size(); ++j) {
      const Step& b = steps_v_[j];
      const double weight = quadrants_.weight(i, j);
      if (weight == 0 || b.sum == 0) continue;
      // Hermite polynomials of second and third degree.
      const double a2 = a.t * a.t - 1, b2 = b.t * b.t - 1;
      const double a3 = a.t * (a.t * a.t - 3), b3 = b.t * (b.t * b.t - 3);
      const double both = a.density * b.density * r;
      sum.ink += weight * (a.sum * b.sum +
                           both * (1 + r / 2 * a.t * b.t + r * r / 6 * a2 * b2 +
                                   r * r * r / 24 * a3 * b3));
      const double by_a = a.density * b.sum -
                          both * (a.t + r / 2 * a2 * b.t + r * r / 6 * a3 * b2);
      const double by_b = b.density * a.sum -
                          both * (b.t + r / 2 * b2 * a.t + r * r / 6 * b3 * a2);
      sum.J_u += weight * by_a / blur_.sigma_u;
      sum.J_v += weight * by_b / blur_.sigma_v;
      sum.J_log_sigma -= weight * (by_a * a.t + by_b * b.t);
    }
  }
  return sum;
}

}  // namespace raygrid
