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

/// An AprilTag in an image: the corners of its black square, clockwise from the
/// top left as the tag stands.
struct DetectedTag {
  TagFamily family = TagFamily::k36h11;
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;
};

/// The defaults are libapriltag's.
struct TagOptions {
  /// Squares are sought in every decimate-th row and column; corners are found
  /// in all.
  float decimate = 1;
  int max_wrong_bits = 2;  ///< none of tag16h5: any square would pass
  /// Squared pixels that the edges of squares may be off a straight line.
  float max_line_fit_mse = 10;
  /// Grey levels between the cells and their threshold, on average.
  float min_margin = 0;
};

/// libapriltag's detector. Serves one thread at a time.
class TagDetector {
 public:
  TagDetector(const std::vector<TagFamily>& families,
              const TagOptions& options);
  ~TagDetector();

  /// All tags of the families in a grey image, 8 bits; by id.
  std::vector<DetectedTag> Detect(const cv::Mat& image) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// kQuick leaves out every second row and column of large images, and with
/// them tags less than about 20 px wide.
enum class TagSearch { kQuick, kThorough };

/// All tags of tag36h11 with one wrong bit at most and wholly in the image.
std::vector<DetectedTag> DetectTags(const GreyImage& image,
                                    TagSearch search = TagSearch::kQuick);
/// Whether images of this size are not large.
bool IsQuickSearchThorough(const ImageSize& size);

/// Describes other tags where DetectTags() finds nothing: "mirrored tag 3",
/// "tag 3 of family tag25h9". For messages.
std::vector<std::string> DescribeOtherTags(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_TAG_DETECTION_H
