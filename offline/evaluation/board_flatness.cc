#include "evaluation/board_flatness.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace raygrid {
namespace {

// Returns the indices of the board's points that are detectable features.
std::vector<int> FeaturePoints(const Board& board) {
  std::vector<int> indices;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if (board.HasFeature(column, row))
        indices.push_back(board.PointIndex(column, row));
  return indices;
}

Eigen::Matrix3Xd SelectPoints(const std::vector<Eigen::Vector3d>& points,
                              const std::vector<int>& indices) {
  Eigen::Matrix3Xd selected(3, indices.size());
  for (size_t i = 0; i < indices.size(); ++i)
    selected.col(static_cast<Eigen::Index>(i)) = points[indices[i]];
  return selected;
}

}  // namespace

BoardFlatness MeasureFlatness(const Board& board) {
  const std::vector<int> indices = FeaturePoints(board);
  BoardFlatness shape;
  shape.height_m.assign(board.num_points(),
                        std::numeric_limits<double>::quiet_NaN());
  if (indices.size() < 3) return shape;
  const Eigen::Matrix3Xd points = SelectPoints(board.points, indices);
  const Eigen::Vector3d center = points.rowwise().mean();
  const Eigen::Matrix3Xd centered = points.colwise() - center;
  Eigen::Vector3d normal =
      Eigen::JacobiSVD<Eigen::MatrixXd>(centered, Eigen::ComputeThinU)
          .matrixU()
          .col(2);
  if (normal.z() < 0) normal = -normal;
  const Eigen::RowVectorXd heights = normal.transpose() * centered;
  for (size_t i = 0; i < indices.size(); ++i)
    shape.height_m[indices[i]] = heights[static_cast<Eigen::Index>(i)];
  const double count = static_cast<double>(indices.size());
  shape.rms_height_m = heights.norm() / std::sqrt(count);
  shape.max_height_m = heights.cwiseAbs().maxCoeff();

  if (board.IsPointSet()) return shape;  // no nominal plane
  const Eigen::Matrix3Xd nominal = SelectPoints(board.NominalPoints(), indices);
  const Eigen::Matrix4d similarity = Eigen::umeyama(nominal, points, true);
  const Eigen::Matrix3Xd difference =
      points - (similarity * nominal.colwise().homogeneous()).topRows<3>();
  const Eigen::Matrix3Xd shift =
      difference - normal * (normal.transpose() * difference);
  shape.rms_shift_m = shift.norm() / std::sqrt(count);
  return shape;
}

}  // namespace raygrid
