#include "appearance/marker_bits.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>
#include <fmt/format.h>

#include <memory>
#include <opencv2/aruco/dictionary.hpp>

#include "dataset/error.h"

namespace raygrid {

namespace {

using FamilyPointer =
    std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)>;

FamilyPointer MakeAprilTagFamily(const std::string& name) {
  if (name == "tag36h11") return {tag36h11_create(), tag36h11_destroy};
  if (name == "tag25h9") return {tag25h9_create(), tag25h9_destroy};
  if (name == "tag16h5") return {tag16h5_create(), tag16h5_destroy};
  throw InputError(fmt::format(
      "unknown tag family '{}'; use tag36h11, tag25h9 or tag16h5", name));
}

}  // namespace

MarkerBits AprilTagBits(const std::string& family_name, int id) {
  const FamilyPointer family = MakeAprilTagFamily(family_name);
  if (id < 0 || id >= static_cast<int>(family->ncodes))
    throw InputError(
        fmt::format("tag {}: out of range, family {} has tags 0 to {}", id,
                    family_name, family->ncodes - 1));
  const std::unique_ptr<image_u8_t, decltype(&image_u8_destroy)> image(
      apriltag_to_image(family.get(), id), &image_u8_destroy);
  MarkerBits bits;
  bits.size = image->width;
  for (int row = 0; row < bits.size; ++row)
    for (int column = 0; column < bits.size; ++column)
      bits.is_black.push_back(image->buf[row * image->stride + column] < 128);
  return bits;
}

namespace {

const char* const kDictionaryNames[] = {
    "DICT_4X4_50",        "DICT_4X4_100", "DICT_4X4_250", "DICT_4X4_1000",
    "DICT_5X5_50",        "DICT_5X5_100", "DICT_5X5_250", "DICT_5X5_1000",
    "DICT_6X6_50",        "DICT_6X6_100", "DICT_6X6_250", "DICT_6X6_1000",
    "DICT_7X7_50",        "DICT_7X7_100", "DICT_7X7_250", "DICT_7X7_1000",
    "DICT_ARUCO_ORIGINAL"};

int DictionaryNumber(const std::string& name) {
  int number = 0;
  for (const char* known : kDictionaryNames) {
    if (name == known) return number;
    ++number;
  }
  throw InputError(fmt::format(
      "unknown dictionary '{}'; use OpenCV's DICT_4X4_50 to DICT_7X7_1000 or "
      "DICT_ARUCO_ORIGINAL (for DICT_APRILTAG_36h11 use tag family tag36h11)",
      name));
}

}  // namespace

MarkerBits ArucoBits(const std::string& dictionary, int id) {
  const cv::Ptr<cv::aruco::Dictionary> markers =
      cv::aruco::getPredefinedDictionary(DictionaryNumber(dictionary));
  if (id < 0 || id >= markers->bytesList.rows)
    throw InputError(
        fmt::format("marker {}: out of range, {} has markers 0 to {}", id,
                    dictionary, markers->bytesList.rows - 1));
  const cv::Mat inner = cv::aruco::Dictionary::getBitsFromByteList(
      markers->bytesList.row(id), markers->markerSize);
  MarkerBits bits;
  bits.size = markers->markerSize + 2;
  bits.is_black.assign(bits.size * bits.size, true);
  for (int row = 0; row < inner.rows; ++row)
    for (int column = 0; column < inner.cols; ++column)
      bits.is_black[(row + 1) * bits.size + column + 1] =
          inner.at<uint8_t>(row, column) == 0;
  return bits;
}

}  // namespace raygrid
