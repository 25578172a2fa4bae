#include "camera/operating_point_grid.h"

#include <utility>

namespace raygrid {

static_assert(2 * (1 + OperatingPointModel::kMaxConditions *
                           OperatingPointModel::kMaxOrder) <=
              LinearizedProjection::kMaxPerNode);

OperatingPointGrid::OperatingPointGrid(OperatingPointModel stack,
                                       OperatingPoint values)
    : CameraModel(stack.image_size(), stack.terms().front().area()),
      model_(std::move(stack)),
      values_(std::move(values)),
      factors_(model_.EvaluateBasis(values_)),
      camera_(model_.At(values_)) {}

bool OperatingPointGrid::Linearize(const Eigen::Vector3d& point,
                                   const Eigen::Vector2d* start,
                                   double margin_px,
                                   LinearizedProjection* projection) const {
  if (!camera_.Linearize(point, start, margin_px, projection)) return false;
  const Eigen::Matrix2d J_grid = projection->J_node.leftCols<2>();
  const int count = static_cast<int>(factors_.size());
  projection->num_per_node = 2 * count;
  for (int j = 0; j < count; ++j)
    projection->J_node.middleCols<2>(2 * j) = factors_[j] * J_grid;
  for (int k = 0; k < projection->num_nodes; ++k)
    projection->node_parameter[k] *= count;
  return true;
}

Eigen::VectorXd OperatingPointGrid::Parameters() const {
  const int count = static_cast<int>(factors_.size());
  const int num_points = camera_.surface().num_points();
  Eigen::VectorXd parameters(2 * count * num_points);
  for (int k = 0; k < num_points; ++k)
    for (int j = 0; j < count; ++j)
      parameters.segment<2>(2 * (count * k + j)) =
          model_.terms()[j].points()[k];
  return parameters;
}

void OperatingPointGrid::SetParameters(const Eigen::VectorXd& parameters) {
  const int count = static_cast<int>(factors_.size());
  for (int k = 0; k < camera_.surface().num_points(); ++k)
    for (int j = 0; j < count; ++j)
      model_.terms()[j].points()[k] =
          parameters.segment<2>(2 * (count * k + j));
  SetValues(values_);
}

void OperatingPointGrid::SetValues(OperatingPoint values) {
  values_ = std::move(values);
  factors_ = model_.EvaluateBasis(values_);
  camera_ = model_.At(values_);
}

}  // namespace raygrid
