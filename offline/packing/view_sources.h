#ifndef RAYGRID_PACKING_VIEW_SOURCES_H
#define RAYGRID_PACKING_VIEW_SOURCES_H

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "camera/camera_model.h"
#include "packing/view.h"

namespace raygrid {

/// The source positions of a view's pixels in a camera's image, or the inverse,
/// evaluated exactly for every pixel.
struct ViewSources {
  ImageSize size, source_size;
  /// Row by row; NaN without a source, such as outside the image circle.
  std::vector<Eigen::Vector2d> sources;
};

/// Returns the central camera that approximates a non-central one at infinity,
/// which the blob's tables use; a copy of a central camera. Throws
/// Error(kUsage), without the file name, for other non-central cameras.
std::unique_ptr<CameraModel> CentralCamera(const CameraModel& camera);

/// Computes the sources of a view's pixels; if is_reverse, of the camera's
/// pixels in the view. Non-central cameras are evaluated at infinity. Throws
/// like CentralCamera().
ViewSources MakeViewSources(const CameraModel& camera, const VirtualView& view,
                            bool is_reverse, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_VIEW_SOURCES_H
