#ifndef RAYGRID_FEATURES_TAG_DETECTION_H
#define RAYGRID_FEATURES_TAG_DETECTION_H

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "features/detection.h"

namespace raygrid {

/// An AprilTag in an image: the corners of its black square, clockwise from the
/// top left as the tag stands.
struct DetectedTag {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;
};

/// All tags of tag36h11 read without a wrong bit and wholly in the image; tags
/// too small at first are sought in the enlarged image.
std::vector<DetectedTag> DetectTags(const GreyImage& image);

/// What there is where DetectTags() finds nothing: "mirrored tag 3", "tag 3 of
/// family tag25h9". For messages.
std::vector<std::string> DescribeOtherTags(const GreyImage& image);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_TAG_DETECTION_H
