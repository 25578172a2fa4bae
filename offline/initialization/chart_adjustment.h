#ifndef RAYGRID_INITIALIZATION_CHART_ADJUSTMENT_H
#define RAYGRID_INITIALIZATION_CHART_ADJUSTMENT_H

#include <vector>

#include "camera/bspline_surface.h"
#include "camera/pose.h"

namespace raygrid {

/// A board's point and the pixel that shows it.
struct ChartObservation {
  int pose = 0;  ///< index of camera_from_board
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
};

/// Adjusts a starting surface of chart coordinates and all poses jointly, which
/// averaging view by view does not: views localised one on the other drift. The
/// errors are those between the surface at a pixel and the chart coordinates of
/// its point, in pixels to first order (Huber, 1 px), so that nothing need be
/// projected; how nodes without observations differ from the start is smooth.
void AdjustInChart(const std::vector<ChartObservation>& observations,
                   BSplineSurface* surface, std::vector<Pose>* poses);

}  // namespace raygrid

#endif  // RAYGRID_INITIALIZATION_CHART_ADJUSTMENT_H
