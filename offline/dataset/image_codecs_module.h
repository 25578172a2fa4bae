#ifndef RAYGRID_DATASET_IMAGE_CODECS_MODULE_H
#define RAYGRID_DATASET_IMAGE_CODECS_MODULE_H

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace raygrid {

/// The functions of the module, as DecodeImage() and EncodeImage() say.
struct ImageCodecs {
  cv::Mat (*decode)(const cv::Mat& encoded, int flags);
  std::string (*encode)(const char* extension, const cv::Mat& pixels,
                        const std::vector<int>& parameters);
};

/// The module's one function, which returns a const ImageCodecs*.
constexpr char kImageCodecsEntry[] = "raygrid_image_codecs";

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_CODECS_MODULE_H
