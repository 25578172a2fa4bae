#ifndef RAYGRID_INITIALIZATION_CHART_ADJUSTMENT_H
#define RAYGRID_INITIALIZATION_CHART_ADJUSTMENT_H

#include <vector>

#include "camera/bspline_surface.h"
#include "camera/pose.h"

namespace raygrid {

/// A target point and its observation.
struct ChartObservation {
  int pose = 0;  ///< index into camera_from_board
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
};

/// Optimizes an initial surface of chart coordinates and all poses jointly,
/// which avoids the drift of localizing view by view. Residuals are the
/// differences between the surface at a pixel and the chart coordinates of its
/// point, in pixels to first order (Huber loss, 1 px), so that no projection is
/// needed; deviations from the initial surface are regularized by smoothness.
void OptimizeInChart(const std::vector<ChartObservation>& observations,
                     BSplineSurface* surface, std::vector<Pose>* poses);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_CHART_ADJUSTMENT_H
