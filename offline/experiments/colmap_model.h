#ifndef RAYGRID_EXPERIMENTS_COLMAP_MODEL_H
#define RAYGRID_EXPERIMENTS_COLMAP_MODEL_H

#include <string>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"

namespace raygrid {

/// Structure from motion of a user's images, without the intrinsics.
struct ColmapModel {
  struct Observation {
    Eigen::Vector2d pixel;  ///< (0, 0) is the centre of the first pixel
    int point = 0;          ///< index
  };
  struct Image {
    std::string name;
    Pose camera_from_world;
    std::vector<Observation> observations;
  };

  ImageSize size;
  std::vector<Image> images;  ///< sorted by name
  std::vector<Eigen::Vector3d> points;
};

/// Reads cameras.txt, images.txt and points3D.txt of a folder, as written by
/// `colmap model_converter --output_type TXT`. All cameras must have the same
/// image size. Throws InputError.
ColmapModel ReadColmapModel(const std::string& folder);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_COLMAP_MODEL_H
