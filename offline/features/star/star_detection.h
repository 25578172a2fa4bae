#ifndef RAYGRID_FEATURES_STAR_STAR_DETECTION_H
#define RAYGRID_FEATURES_STAR_STAR_DETECTION_H

#include <memory>

#include "features/board_view/detection.h"

namespace raygrid {

/// Finds the star boards of a pattern in images (paper's supplement, "Feature
/// detection"): AprilTags, local mappings from pattern to image, growth
/// outwards, one star at a time. Where that leaves boards out though there are
/// more stars, lattices of them are grown from anywhere and told by what is
/// seen of their tags. One detector serves all threads.
class StarDetector {
 public:
  StarDetector(const Pattern& pattern, const DetectionOptions& options);
  ~StarDetector();

  ImageDetection Detect(const GreyImage& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_STAR_STAR_DETECTION_H
