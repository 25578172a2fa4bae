#ifndef RAYGRID_CALIBRATION_IMAGE_TRANSFORMS_H
#define RAYGRID_CALIBRATION_IMAGE_TRANSFORMS_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/adjusted.h"
#include "dataset/dataset.h"

namespace raygrid {

/// How an image was changed after it was taken: mirrored, then rotated about
/// its centre, then scaled about its corner.
struct ImageTransform {
  bool is_mirrored = false;  ///< left to right
  int quarter_turns = 0;     ///< clockwise
  double scale = 1;

  /// The pixel of the image as it was taken.
  Eigen::Vector2d Undo(const Eigen::Vector2d& pixel,
                       const ImageSize& size) const;

  /// "rotated by 180°", "mirrored left to right", "scaled by 0.5".
  std::string Text() const;
};

/// Images that were changed alike, relative to the others.
struct TransformedImages {
  ImageTransform transform;
  std::vector<std::string> images;
  bool is_left_out = true;  ///< or found too late for that
};

/// The images whose features fit the camera of the others only once a transform
/// is undone: some programs apply the orientation that EXIF states, others do
/// not, and resized copies get among the originals. A parametric lens takes up
/// most of a turn in its principal point, so the residuals stay small, and the
/// camera is wrong. joint is the lens of all images, or null if none fits them:
/// a parametric one, or a coarse grid where the lens has what those do not
/// follow.
std::vector<TransformedImages> FindTransformedImages(
    const Dataset& dataset, const Pattern& pattern, const Adjusted* joint,
    const AdjustmentOptions& options);

Dataset WithoutTransformed(const Dataset& dataset,
                           const std::vector<TransformedImages>& transformed);

/// The images as rejected ones.
std::vector<RejectedImage> AsRejected(
    const std::vector<TransformedImages>& transformed);

/// Warns of images that were left out; fails where as many others may be the
/// wrong ones, or where the images were used.
void WarnOfTransformedImages(const std::vector<TransformedImages>& transformed,
                             size_t num_images, Verdict* verdict);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_IMAGE_TRANSFORMS_H
