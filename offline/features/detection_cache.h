#ifndef RAYGRID_FEATURES_DETECTION_CACHE_H
#define RAYGRID_FEATURES_DETECTION_CACHE_H

#include <optional>
#include <string>

#include "features/board_view/detection.h"

namespace raygrid {

/// The detection in one image, and the image size, which is unknown before
/// decoding.
struct DetectedImage {
  ImageSize size;
  ImageDetection detection;
};

/// Caches detections in one small text file per image. If a file cannot be read
/// or written, the features of the image are detected again.
class DetectionCache {
 public:
  /// The folder is created when the first file is written.
  explicit DetectionCache(std::string folder) : folder_(std::move(folder)) {}

  /// Returns the user's cache folder: raygrid in $XDG_CACHE_HOME or ~/.cache;
  /// empty if neither exists.
  static std::string DefaultFolder();

  /// Returns a hash of everything that the detection depends on, including the
  /// version of the library.
  static std::string Key(const std::string& image_bytes, const Pattern& pattern,
                         const DetectionOptions& options);

  std::optional<DetectedImage> Find(const std::string& key) const;
  void Store(const std::string& key, const DetectedImage& seen) const;
  /// Removes the oldest files above the maximum number.
  void Trim(int max_files = 20000) const;

 private:
  std::string Path(const std::string& key) const;
  std::string folder_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_DETECTION_CACHE_H
