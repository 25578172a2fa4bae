#ifndef RAYGRID_PACKING_VIEW_CURVES_H
#define RAYGRID_PACKING_VIEW_CURVES_H

#include <Eigen/Core>
#include <vector>

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"
#include "packing/view.h"

namespace raygrid {

/// A polyline in an image, in pixels.
using PixelCurve = std::vector<Eigen::Vector2d>;

/// Straight lines in space projected to a view: a grid of squares on the walls
/// of a room, a cube centred at the camera with walls at a distance of 1 along
/// the room's axes. Curves end at the limits of the projection, and extend
/// beyond the image.
std::vector<PixelCurve> MakeRoomLines(const VirtualView& view,
                                      const Eigen::Matrix3d& camera_from_room,
                                      double square);

/// Returns the side of squares, 2 / 2^k, for about ten lines across a view.
double ComputeViewSquareSize(const VirtualView& view);

/// Returns the edges of the valid region, including the image's edge.
std::vector<PixelCurve> ComputeValidOutline(const ValidityMask& mask,
                                            const ImageSize& size);
std::vector<PixelCurve> ComputeAreaOutline(const Area& area);

/// Transforms curves from a camera's image to a view. Points up to a pixel
/// outside the camera's area are clamped to its edge.
std::vector<PixelCurve> ProjectCurves(const CameraModel& camera,
                                      const VirtualView& view,
                                      const std::vector<PixelCurve>& curves);

/// Returns the edge of a view's image where the camera's area covers it.
std::vector<PixelCurve> ComputeViewEdge(const CameraModel& camera,
                                        const VirtualView& view);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_VIEW_CURVES_H
