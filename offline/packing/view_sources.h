#ifndef RAYGRID_PACKING_VIEW_SOURCES_H
#define RAYGRID_PACKING_VIEW_SOURCES_H

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "camera/camera_model.h"
#include "packing/view.h"

namespace raygrid {

/// The places in a camera's image that the pixels of a view show, or the other
/// way around, by the camera's own answer for every pixel.
struct ViewSources {
  ImageSize size, source_size;
  /// Row by row; NaN where a pixel has none, as beyond the image circle.
  std::vector<Eigen::Vector2d> sources;
};

/// A camera of lines as it sees what is far away, which is what the tables of
/// blobs are of; a copy of a central camera. Throws Error(kUsage), without the
/// file's name, for cameras of other lines.
std::unique_ptr<CameraModel> CentralCamera(const CameraModel& camera);

/// The sources of a view's pixels; if is_reverse, those of the camera's pixels
/// in the view. Of a camera of lines they are those of what is far away. Throws
/// as CentralCamera() does.
ViewSources SourcesOfView(const CameraModel& camera, const VirtualView& view,
                          bool is_reverse, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_VIEW_SOURCES_H
