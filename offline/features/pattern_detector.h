#ifndef RAYGRID_FEATURES_PATTERN_DETECTOR_H
#define RAYGRID_FEATURES_PATTERN_DETECTOR_H

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "features/board_view/detection.h"
#include "features/detection_cache.h"

namespace raygrid {

/// Detects all boards of a pattern in images. Thread-safe.
class PatternDetector {
 public:
  /// Throws InputError for kinds of boards that cannot be detected, and options
  /// out of range.
  PatternDetector(const Pattern& pattern, const DetectionOptions& options);
  ~PatternDetector();

  ImageDetection Detect(const GreyImage& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Detections in a set of images.
struct FolderDetection {
  Dataset dataset;                     ///< without the skipped images
  std::vector<std::string> paths;      ///< paths of the dataset's images
  std::vector<ImageDetection> images;  ///< detections of the dataset's images
  std::vector<SkippedImage> skipped;   ///< unreadable, or of a different size
  std::vector<std::string> turned;     ///< names, for WarnAboutOrientation()
};

/// Summarizes warnings and the reasons for images without a board: each with
/// the number of images and the name of the first one.
std::vector<std::string> SummarizeWarnings(const FolderDetection& folder);

/// Detects the pattern in all images; progress is called with the fraction
/// done. Images without a board have no features. cache may be NULL. Images
/// must have the most frequent size. Throws InputError if no image is readable,
/// if two image sizes are equally frequent, if names are not unique, and like
/// PatternDetector.
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
