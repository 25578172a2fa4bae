#ifndef RAYGRID_FEATURES_BOARD_VIEW_TAG_DETECTION_H
#define RAYGRID_FEATURES_BOARD_VIEW_TAG_DETECTION_H

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "features/board_view/detection.h"

namespace cv {
class Mat;
}

namespace raygrid {

enum class TagFamily {
  k36h11,
  k25h9,
  k16h5,
  // With a black border of two cells, as in AprilGrids.
  k36h11WideBorder,
  k25h9WideBorder,
  k16h5WideBorder,
  kStandard41h12
};

/// An AprilTag in an image: corners of its black square, clockwise from the top
/// left of the tag in upright orientation.
struct DetectedTag {
  TagFamily family = TagFamily::k36h11;
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;
};

/// Options of tag detection; defaults as in libapriltag.
struct TagOptions {
  /// Quads are searched in every decimate-th row and column; corners are
  /// located at full resolution.
  float decimate = 1;
  int max_wrong_bits = 2;  ///< ignored (0) for tag16h5, whose false-positive
                           ///< rate would be too high
  /// Maximum mean squared distance of edge points from fitted lines, px^2.
  float max_line_fit_mse = 10;
  /// Minimum mean difference between cells and the threshold, in grey levels.
  float min_margin = 0;
};

/// Wrapper of libapriltag's detector. Not thread-safe.
class TagDetector {
 public:
  TagDetector(const std::vector<TagFamily>& families,
              const TagOptions& options);
  ~TagDetector();

  /// Detects all tags of the families in an 8-bit grey image, ordered by id.
  std::vector<DetectedTag> Detect(const cv::Mat& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// kQuick skips every second row and column of large images, and therefore
/// misses tags less than about 20 px wide.
enum class TagSearch { kQuick, kThorough };

/// Detects all tags of family tag36h11 with at most one bit error.
std::vector<DetectedTag> DetectTags(const GreyImage& image,
                                    TagSearch search = TagSearch::kQuick);
/// Returns whether kQuick searches all rows of images of this size, because
/// they are small.
bool IsQuickSearchThorough(const ImageSize& size);

/// Describes tags that DetectTags() does not detect, e.g. "mirrored tag 3" or
/// "tag 3 of family tag25h9", for warnings.
std::vector<std::string> DescribeOtherTags(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_TAG_DETECTION_H
