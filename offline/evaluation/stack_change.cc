#include "evaluation/stack_change.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <string>

#include "camera/model_fitting.h"

namespace raygrid {
namespace {

// Pixels per radian in the middle of the area: the root of their product along
// two axes across the line of sight.
double FocalPx(const CentralGeneric& camera) {
  const Eigen::Vector2d pixel = camera.area().center();
  const auto direction = camera.Unproject(pixel);
  LinearizedProjection projection;
  if (!direction || !camera.Linearize(*direction, &pixel, 1, &projection))
    return NAN;
  const Eigen::Matrix2d square =
      projection.by_point * projection.by_point.transpose();
  return std::pow(square.determinant(), 0.25);
}

Eigen::Vector2d CenterPx(const CentralGeneric& camera) {
  FitOptions options;
  options.free_rotation = true;
  const auto lens =
      FitParametricModel("thin-prism-fisheye", camera, camera.area(), options)
          .model;
  const std::vector<std::string>& names = lens->ParameterNames();
  const Eigen::VectorXd named = lens->Parameters().tail(names.size());
  Eigen::Vector2d center(NAN, NAN);
  for (size_t k = 0; k < names.size(); ++k) {
    if (names[k] == "cx") center.x() = named[static_cast<Eigen::Index>(k)];
    if (names[k] == "cy") center.y() = named[static_cast<Eigen::Index>(k)];
  }
  return center;
}

StackChange ChangeOf(const CentralGeneric& middle, const CentralGeneric& camera,
                     double value) {
  constexpr int kSteps = 16;
  const Area& area = middle.area();
  std::vector<Eigen::Vector2d> from, moved;
  for (int j = 0; j <= kSteps; ++j)
    for (int i = 0; i <= kSteps; ++i) {
      const Eigen::Vector2d pixel(area.x0 + area.width() * i / kSteps,
                                  area.y0 + area.height() * j / kSteps);
      const auto direction = middle.Unproject(pixel);
      if (!direction) continue;
      const auto seen = camera.Project(*direction, &pixel, 0.1 * area.width());
      if (!seen) continue;
      from.push_back(pixel - area.center());
      moved.push_back(*seen - pixel);
    }
  StackChange change;
  change.value = value;
  change.focal_px = FocalPx(camera);
  change.center_px = CenterPx(camera);
  const auto count = static_cast<Eigen::Index>(from.size());
  if (count < 3) return change;
  Eigen::MatrixX3d design(2 * count, 3);
  Eigen::VectorXd observed(2 * count);
  for (Eigen::Index k = 0; k < count; ++k) {
    design.row(2 * k) << from[k].x(), 1, 0;
    design.row(2 * k + 1) << from[k].y(), 0, 1;
    observed.segment<2>(2 * k) = moved[k];
  }
  const Eigen::Vector3d fitted = design.householderQr().solve(observed);
  change.growth = fitted[0];
  change.distortion_px = std::sqrt((observed - design * fitted).squaredNorm() /
                                   static_cast<double>(count));
  return change;
}

}  // namespace

std::vector<StackChange> MeasureStackChanges(const CameraStack& stack,
                                             int num_values) {
  const CentralGeneric middle = stack.At(stack.middle());
  std::vector<StackChange> changes;
  for (int k = 0; k < num_values; ++k) {
    const double value =
        stack.low() + (stack.high() - stack.low()) * k / (num_values - 1);
    changes.push_back(ChangeOf(middle, stack.At(value), value));
  }
  return changes;
}

}  // namespace raygrid
