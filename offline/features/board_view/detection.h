/// Types of detection: options and results.
#ifndef RAYGRID_FEATURES_BOARD_VIEW_DETECTION_H
#define RAYGRID_FEATURES_BOARD_VIEW_DETECTION_H

#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "dataset/image_files.h"

namespace raygrid {

/// Methods of sub-pixel refinement (paper, "Feature Extraction"): by symmetry
/// of one of three images derived from the photograph, by OpenCV's
/// cornerSubPix, or none after the initial localization.
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

/// A grey image as input of detectors.
struct GreyImage {
  ImageSize size;
  std::vector<float> levels;   ///< row by row, scaled to 0 to 255
  std::vector<uint8_t> bytes;  ///< levels, rounded
  float level_step = 1;        ///< step of the file's levels
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

/// Halves width and height: pixel (x, y) is the mean of four, the first of
/// which is (2 x, 2 y).
GreyImage Halved(const GreyImage& image);

/// Converts a pixel to an image downscaled by averaging to 1 / scale of the
/// size, and back.
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

/// Accepted and rejected features of one image.
struct ImageDetection {
  std::vector<Feature> features;  ///< by board, row, column
  std::vector<RejectedFeature> rejected;
  std::vector<std::string> warnings;  ///< such as mirrored board, other tags
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_DETECTION_H
