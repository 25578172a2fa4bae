#ifndef RAYGRID_EXPERIMENTS_COLMAP_MODEL_H
#define RAYGRID_EXPERIMENTS_COLMAP_MODEL_H

#include <string>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"

namespace raygrid {

/// The structure from motion of a user's images. Its camera's parameters are of
/// no use here.
struct ColmapModel {
  struct Observation {
    Eigen::Vector2d pixel;  ///< (0, 0) in the middle of the first pixel
    int point = 0;          ///< index
  };
  struct Image {
    std::string name;
    Pose camera_from_world;
    std::vector<Observation> observations;
  };

  ImageSize size;
  std::vector<Image> images;  ///< by their names
  std::vector<Eigen::Vector3d> points;
};

/// cameras.txt, images.txt and points3D.txt of a folder, as `colmap
/// model_converter --output_type TXT` writes them. All cameras must have images
/// of one size. Throws InputError.
ColmapModel ReadColmapModel(const std::string& folder);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_COLMAP_MODEL_H
