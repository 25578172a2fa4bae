#ifndef RAYGRID_CAPTURE_LIVE_CAMERA_H
#define RAYGRID_CAPTURE_LIVE_CAMERA_H

#include <optional>
#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"
#include "dataset/pattern.h"

namespace raygrid {

/// The camera estimated from the images so far: a coarse grid. While there are
/// few images, its prior keeps it close to a parametric model. Boards have
/// their nominal geometry.
class LiveCamera {
 public:
  LiveCamera(const Pattern& pattern, const ImageSize& size, int num_threads);

  /// Adds an image. From kNumFirstViews images on, the camera is optimized:
  /// from scratch whenever the number of images has grown by half, otherwise
  /// from its last state.
  void Add(const ImageFeatures& image);
  /// Adds several images, and estimates the camera from scratch.
  void Add(const std::vector<ImageFeatures>& images);
  /// Removes the image with this name, and estimates the camera without it.
  void Remove(const std::string& image);

  const Dataset& images() const { return images_; }
  /// Returns nullopt until a camera was estimated.
  const std::optional<AdjustmentResult>& adjusted() const { return adjusted_; }

 private:
  void OptimizeFromScratch();
  void ContinueOptimization();
  AdjustmentOptions MakeAdjustmentOptions() const;

  Pattern pattern_;
  Dataset images_;
  int num_threads_;
  size_t num_images_at_full_adjustment_ = 0;
  std::optional<AdjustmentResult> adjusted_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_LIVE_CAMERA_H
