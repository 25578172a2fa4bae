#ifndef RAYGRID_DATASET_IMAGE_CODECS_H
#define RAYGRID_DATASET_IMAGE_CODECS_H

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace raygrid {

// The module raygrid_image_codecs.so has these. It is loaded with the first
// image: OpenCV's codecs bring 140 libraries, which would take 0.09 s of each
// start. An InputError says where the module is missing.

/// Loads the module now.
void LoadImageCodecs();

/// Decodes an image file as cv::imdecode() does; flags are cv::ImreadModes. The
/// image is empty if the bytes are none.
cv::Mat DecodeImage(const std::string& bytes, int flags);

/// Encodes pixels as cv::imencode() does: extension is ".png" for example,
/// parameters are pairs of cv::ImwriteFlags and values.
std::string EncodeImage(const char* extension, const cv::Mat& pixels,
                        const std::vector<int>& parameters = {});

}  // namespace raygrid

#endif  // RAYGRID_DATASET_IMAGE_CODECS_H
