#ifndef RAYGRID_FEATURES_DETECTION_CACHE_H
#define RAYGRID_FEATURES_DETECTION_CACHE_H

#include <optional>
#include <string>

#include "features/board_view/detection.h"

namespace raygrid {

/// The detection in one image, and the image's size, which is not known before
/// it is decoded.
struct DetectedImage {
  ImageSize size;
  ImageDetection detection;
};

/// Remembers what images showed, in a small text file for each. Whatever goes
/// wrong with a file, the image is just detected again.
class DetectionCache {
 public:
  /// The folder is made when the first file is.
  explicit DetectionCache(std::string folder) : folder_(std::move(folder)) {}

  /// The folder in which the user keeps such files: raygrid in $XDG_CACHE_HOME
  /// or ~/.cache; empty if there is no such place.
  static std::string DefaultFolder();

  /// A hash of everything that the detection depends on, this version of the
  /// library included.
  static std::string Key(const std::string& image_bytes, const Pattern& pattern,
                         const DetectionOptions& options);

  std::optional<DetectedImage> Find(const std::string& key) const;
  void Store(const std::string& key, const DetectedImage& seen) const;
  /// Removes the oldest files above a number.
  void Trim(int max_files = 20000) const;

 private:
  std::string Path(const std::string& key) const;
  std::string folder_;
};

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_DETECTION_CACHE_H
