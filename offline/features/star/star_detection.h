#ifndef RAYGRID_FEATURES_STAR_STAR_DETECTION_H
#define RAYGRID_FEATURES_STAR_STAR_DETECTION_H

#include <memory>

#include "features/board_view/detection.h"

namespace raygrid {

/// Detects the star boards of a pattern in images (paper's supplement, "Feature
/// detection"): detects AprilTags, fits local mappings from pattern to image,
/// and extends the lattice outwards, one star at a time. If boards are missing
/// and unexplained stars remain, grows lattices from arbitrary stars and
/// identifies the boards from the visible parts of tags. Thread-safe.
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
