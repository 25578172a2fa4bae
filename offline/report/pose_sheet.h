#ifndef RAYGRID_REPORT_POSE_SHEET_H
#define RAYGRID_REPORT_POSE_SHEET_H

#include <string>
#include <vector>

#include "camera/camera_model.h"
#include "dataset/image_files.h"
#include "dataset/pattern.h"

namespace raygrid {

/// An image with the targets that were localized in it.
struct LocalizedImage {
  std::string title;
  std::string caption;
  Image picture;  ///< has the camera's image size
  const CameraModel* camera = nullptr;
  std::vector<const Board*> boards;
  std::vector<Pose> camera_from_board;
};

/// Draws the reprojected lattices of the boards and the axes of their frames
/// over the images, side by side.
Image PoseSheet(std::vector<LocalizedImage> images);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_POSE_SHEET_H
