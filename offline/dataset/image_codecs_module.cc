#include "dataset/image_codecs_module.h"

#include <opencv2/imgcodecs.hpp>

namespace raygrid {
namespace {

cv::Mat Decode(const cv::Mat& encoded, int flags) {
  return cv::imdecode(encoded, flags);
}

std::string Encode(const char* extension, const cv::Mat& pixels,
                   const std::vector<int>& parameters) {
  std::vector<uint8_t> bytes;
  cv::imencode(extension, pixels, bytes, parameters);
  return {bytes.begin(), bytes.end()};
}

}  // namespace
}  // namespace raygrid

// A function whose name is not mangled, so that dlsym() finds it.
extern "C" __attribute__((visibility("default"))) const raygrid::ImageCodecs*
raygrid_image_codecs() {
  static const raygrid::ImageCodecs codecs = {raygrid::Decode, raygrid::Encode};
  return &codecs;
}
