/// The vocabulary of detection: what is asked for, and what was found.
#ifndef RAYGRID_FEATURES_BOARD_VIEW_DETECTION_H
#define RAYGRID_FEATURES_BOARD_VIEW_DETECTION_H

#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "dataset/image_files.h"

namespace raygrid {

/// How features are brought to sub-pixel accuracy (paper, "Feature
/// Extraction"): by symmetry of one of three images made from the photograph,
/// by OpenCV's cornerSubPix, or not at all after the first localisation.
enum class Refinement {
  kIntensities,
  kGradientsXY,
  kGradientMagnitude,
  kCornerSubpix,
  kNone
};

struct DetectionOptions {
  Refinement refinement = Refinement::kIntensities;
  int window_px = 21;  ///< side of the refinement's window, odd
};

/// A photograph as detectors want it.
struct GreyImage {
  ImageSize size;
  std::vector<float> levels;   ///< row by row; 0 to 255, whatever the file has
  std::vector<uint8_t> bytes;  ///< the same, rounded
  float level_step = 1;        ///< between the values of its file
  bool was_mosaic = false;     ///< see BalanceMosaic()

  float at(int x, int y) const { return levels[y * size.width + x]; }
};

GreyImage MakeGreyImage(const Image& image);
GreyImage MakeGreyImage(GreyLevels grey);

/// False for images so small that no board is in them; libraries are not made
/// for those.
bool IsLargeEnough(const ImageSize& size);

/// Left and right exchanged.
GreyImage MirrorImage(GreyImage image);

/// Half as wide and high: pixel (x, y) is the mean of four, (2 x, 2 y) the
/// first of them.
GreyImage Halved(const GreyImage& image);

/// A place in an image that was halved until it is of 1 / scale of the size,
/// and back.
inline Eigen::Vector2d ToDownscaled(const Eigen::Vector2d& pixel,
                                    double scale) {
  return (pixel.array() + 0.5) / scale - 0.5;
}
inline Eigen::Vector2d FromDownscaled(const Eigen::Vector2d& pixel,
                                      double scale) {
  return (pixel.array() + 0.5) * scale - 0.5;
}

struct RejectedFeature {
  Feature feature;
  std::string reason;  ///< a few words
};

/// The features that one image shows, and those rejected.
struct ImageDetection {
  std::vector<Feature> features;  ///< by board, row, column
  std::vector<RejectedFeature> rejected;
  std::vector<std::string> warnings;  ///< about the image: mirrored, other tags
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_DETECTION_H
