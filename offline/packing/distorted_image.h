#ifndef RAYGRID_PACKING_DISTORTED_IMAGE_H
#define RAYGRID_PACKING_DISTORTED_IMAGE_H

#include "camera/camera_model.h"
#include "dataset/image_files.h"
#include "packing/source_map.h"
#include "packing/view.h"

namespace raygrid {

/// Computes the positions, in a view's image, of the pixels of a camera's image
/// within its image circle.
SourceMap MakeDistortionMap(const CameraModel& camera, const VirtualView& view,
                            int num_threads);

/// Distorts an image of the view to the camera's image by bilinear
/// interpolation, with the channels and depth of `picture`; 0 outside the view.
/// `picture` has the size of the view, the result that of the camera.
Image DistortImage(const SourceMap& map, const Image& picture, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_DISTORTED_IMAGE_H
