#ifndef RAYGRID_FEATURES_PATTERN_DETECTOR_H
#define RAYGRID_FEATURES_PATTERN_DETECTOR_H

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "features/board_view/detection.h"
#include "features/detection_cache.h"

namespace raygrid {

/// Finds all boards of a pattern in images; one serves all threads.
class PatternDetector {
 public:
  /// Throws InputError: kinds of boards that cannot be detected, options out of
  /// range.
  PatternDetector(const Pattern& pattern, const DetectionOptions& options);
  ~PatternDetector();

  ImageDetection Detect(const GreyImage& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// The detections in a folder of images.
struct FolderDetection {
  Dataset dataset;                     ///< without the images that were skipped
  std::vector<std::string> paths;      ///< of the dataset's images
  std::vector<ImageDetection> images;  ///< likewise
  std::vector<SkippedImage> skipped;   ///< damaged, or of another size
  std::vector<std::string> turned;     ///< names, for WarnAboutOrientation()
};

/// The remarks on images, and why those without a board have none: each with
/// the number of its images and the name of the first.
std::vector<std::string> SummarizeWarnings(const FolderDetection& folder);

/// Detects the pattern in all images; told how much is done. Images without a
/// board have no features. Without a cache, pass nullptr. The size of most
/// images is the size of all. Throws InputError: no image that can be read, no
/// size that most images have, several of one name; and as PatternDetector.
FolderDetection DetectFeatures(const std::vector<std::string>& image_paths,
                               const Pattern& pattern,
                               const DetectionOptions& options,
                               const DetectionCache* cache, int num_threads,
                               const std::function<void(double)>& progress);

/// Detects the pattern in all images with default options, without a cache.
Dataset DetectFeatures(const std::vector<std::string>& image_paths,
                       const Pattern& pattern, int num_threads,
                       const std::function<void(double)>& progress);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_PATTERN_DETECTOR_H
