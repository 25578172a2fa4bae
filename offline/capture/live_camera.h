#ifndef RAYGRID_CAPTURE_LIVE_CAMERA_H
#define RAYGRID_CAPTURE_LIVE_CAMERA_H

#include <optional>
#include <string>
#include <vector>

#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"
#include "dataset/pattern.h"

namespace raygrid {

/// The camera as images tell it so far: a coarse grid, whose prior makes it as
/// stiff as a parametric lens while images are few. Boards are as they are
/// nominally.
class LiveCamera {
 public:
  LiveCamera(const Pattern& pattern, const ImageSize& size, int num_threads);

  /// One more image. From kNumFirstViews on the camera is adjusted to all of
  /// them: anew whenever they have become half as many again, else from where
  /// it was.
  void Add(const ImageFeatures& image);
  /// Some more at once, and the camera anew.
  void Add(const std::vector<ImageFeatures>& images);
  /// All but the image of that name, and the camera of them.
  void Remove(const std::string& image);

  const Dataset& images() const { return images_; }
  /// Nothing while images tell no camera.
  const std::optional<Adjusted>& adjusted() const { return adjusted_; }

 private:
  void AdjustAnew();
  void GoOn();
  AdjustmentOptions Options() const;

  Pattern pattern_;
  Dataset images_;
  int num_threads_;
  size_t num_at_anew_ = 0;
  std::optional<Adjusted> adjusted_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_LIVE_CAMERA_H
