#ifndef RAYGRID_PACKING_VIEW_CURVES_H
#define RAYGRID_PACKING_VIEW_CURVES_H

#include <Eigen/Core>
#include <vector>

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"
#include "packing/view.h"

namespace raygrid {

/// Points of an image, in pixels, to be joined by straight strokes.
using PixelCurve = std::vector<Eigen::Vector2d>;

/// Lines that are straight in the world, as a view shows them: those that cut
/// the walls of a room into squares. The room is a cube around the camera,
/// whose walls lie one unit from it along the room's axes. Curves end where the
/// view shows them no more, and reach beyond its image.
std::vector<PixelCurve> LinesOfRoom(const VirtualView& view,
                                    const Eigen::Matrix3d& camera_from_room,
                                    double square);

/// The side of the squares, 2 / 2^k, that gives a view about ten lines across.
double SquareOfView(const VirtualView& view);

/// The edges between trusted and other cells, and those at the image's edge.
std::vector<PixelCurve> OutlineOfTrusted(const TrustMask& mask,
                                         const ImageSize& size);
std::vector<PixelCurve> OutlineOfArea(const Area& area);

/// Curves of a camera's image as a view shows them. Points up to a pixel beyond
/// the camera's area count as its edge.
std::vector<PixelCurve> CurvesInView(const CameraModel& camera,
                                     const VirtualView& view,
                                     const std::vector<PixelCurve>& curves);

/// The edge of a view's image, as far as the camera's area shows it.
std::vector<PixelCurve> EdgeOfView(const CameraModel& camera,
                                   const VirtualView& view);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_VIEW_CURVES_H
