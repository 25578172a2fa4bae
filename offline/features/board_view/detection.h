/// Types of detection: options and results.
#ifndef RAYGRID_FEATURES_BOARD_VIEW_DETECTION_H
#define RAYGRID_FEATURES_BOARD_VIEW_DETECTION_H

#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "dataset/image_files.h"

namespace raygrid {

/// Methods of sub-pixel refinement (paper, "Feature Extraction"): maximization
/// of the symmetry of the intensities, of the gradient components or of the
/// gradient magnitude; OpenCV's cornerSubPix; or no refinement.
enum class Refinement {
  kIntensities,
  kGradientsXY,
  kGradientMagnitude,
  kCornerSubpix,
  kNone
};

struct DetectionOptions {
  Refinement refinement = Refinement::kIntensities;
  int window_px = 21;  ///< side of the refinement window, odd
};

/// A grey image, the input of detectors.
struct GreyImage {
  ImageSize size;
  std::vector<float> levels;   ///< row-major, scaled to 0 to 255
  std::vector<uint8_t> bytes;  ///< levels rounded to integers
  float level_step = 1;        ///< quantization step of the file
  bool was_mosaic = false;     ///< see BalanceMosaic()

  float at(int x, int y) const { return levels[y * size.width + x]; }
};

GreyImage MakeGreyImage(const Image& image);
GreyImage MakeGreyImage(GreyLevels grey);

/// Whether an image is large enough to contain a board; libraries for detection
/// may fail for smaller ones.
bool IsLargeEnough(const ImageSize& size);

/// Flips the image horizontally.
GreyImage MirrorImage(GreyImage image);

/// Halves width and height: pixel (x, y) is the mean of the 2 x 2 pixels from
/// (2 x, 2 y) on.
GreyImage HalveImage(const GreyImage& image);

/// Converts pixel coordinates to and from an image downscaled by a factor of
/// `scale` by averaging.
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
  std::string reason;  ///< short description for messages
};

/// Accepted and rejected features of one image.
struct ImageDetection {
  std::vector<Feature> features;  ///< ordered by board, row, column
  std::vector<RejectedFeature> rejected;
  std::vector<std::string> warnings;  ///< e.g. mirrored board, tags of other
                                      ///< boards
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_DETECTION_H
