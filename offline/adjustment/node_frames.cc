#include "adjustment/node_frames.h"

#include <Eigen/Geometry>
#include <vector>

#include "camera/noncentral_generic.h"
#include "camera/stereographic.h"

namespace raygrid {

NodeFrames::NodeFrames(const ParameterLayout& layout,
                       const AdjustmentState& state) {
  constexpr int kPerNode = NonCentralGeneric::kPerNode;
  constexpr int kFirstOfPoint = NonCentralGeneric::kFirstOfPoint;
  std::vector<Eigen::Triplet<double>> triplets;
  std::vector<bool> has_frame(layout.size, false);
  for (size_t c = 0; c + 1 < layout.first_camera.size(); ++c) {
    const BSplineSurface* grid = state.cameras[c]->DirectionGrid();
    if (!grid || state.cameras[c]->IsCentral()) continue;
    int first = layout.first_camera[c] + kFirstOfPoint;
    for (const Eigen::Vector2d& chart : grid->points()) {
      const Eigen::Matrix3d axes =
          Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(),
                                             FromChart(chart))
              .toRotationMatrix();
      for (int row = 0; row < 3; ++row) {
        has_frame[first + row] = true;
        for (int column = 0; column < 3; ++column)
          triplets.emplace_back(first + row, first + column, axes(row, column));
      }
      first += kPerNode;
    }
  }
  if (triplets.empty()) return;
  for (int i = 0; i < layout.size; ++i)
    if (!has_frame[i]) triplets.emplace_back(i, i, 1);
  axes_.resize(layout.size, layout.size);
  axes_.setFromTriplets(triplets.begin(), triplets.end());
}

}  // namespace raygrid
