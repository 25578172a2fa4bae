#include "bags/message_writer.h"

#include <fmt/format.h>

#include "dataset/byte_reader.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

// Appends fields in little-endian CDR, aligned to their size.
class CdrWriter {
 public:
  template <typename Number>
  void Put(Number number) {
    bytes_.resize((bytes_.size() + sizeof(Number) - 1) / sizeof(Number) *
                  sizeof(Number));
    Append(number, &bytes_);
  }
  void PutText(const std::string& text) {
    Put(static_cast<uint32_t>(text.size() + 1));
    bytes_ += text;
    bytes_.push_back('\0');
  }
  void PutHeader(const MessageHeader& header) {
    const int64_t seconds = header.stamp_ns / 1000000000;
    if (header.stamp_ns < 0 || seconds > INT32_MAX)
      throw InputError(fmt::format(
          "a stamp of {} s is not from 1970 to 2038, the range of ROS 2",
          seconds));
    Put(static_cast<int32_t>(seconds));
    Put(static_cast<uint32_t>(header.stamp_ns % 1000000000));
    PutText(header.frame_id);
  }
  void PutAll(const std::vector<double>& numbers) {
    for (const double number : numbers) Put(number);
  }
  void PutBytes(const std::vector<uint8_t>& bytes) {
    Put(static_cast<uint32_t>(bytes.size()));
    bytes_.append(bytes.begin(), bytes.end());
  }
  std::string Message() const { return std::string("\0\1\0\0", 4) + bytes_; }

 private:
  std::string bytes_;
};

}  // namespace

std::string WriteImageMessage(const MessageHeader& header, const Image& image) {
  const char* const channels = image.channels == 1   ? "mono"
                               : image.channels == 3 ? "bgr"
                                                     : "bgra";
  CdrWriter writer;
  writer.PutHeader(header);
  writer.Put(static_cast<uint32_t>(image.size.height));
  writer.Put(static_cast<uint32_t>(image.size.width));
  writer.PutText(fmt::format("{}{}", channels, 8 * image.sample_bytes));
  writer.Put(uint8_t{__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__});
  writer.Put(static_cast<uint32_t>(image.stride()));
  writer.PutBytes(image.pixels);
  return writer.Message();
}

std::string WriteCameraInfo(const MessageHeader& header,
                            const CameraInfo& info) {
  CdrWriter writer;
  writer.PutHeader(header);
  writer.Put(info.height);
  writer.Put(info.width);
  writer.PutText(info.model);
  writer.Put(static_cast<uint32_t>(info.d.size()));
  writer.PutAll(info.d);
  writer.PutAll(info.k);
  writer.PutAll(info.r);
  writer.PutAll(info.p);
  writer.Put(info.binning_x);
  writer.Put(info.binning_y);
  for (const uint32_t value : info.roi) writer.Put(value);
  writer.Put(uint8_t{0});
  return writer.Message();
}

std::string WriteTransforms(const std::vector<StaticTransform>& transforms) {
  CdrWriter writer;
  writer.Put(static_cast<uint32_t>(transforms.size()));
  for (const StaticTransform& transform : transforms) {
    writer.PutHeader(transform.header);
    writer.PutText(transform.child_frame_id);
    writer.PutAll(transform.translation);
    writer.PutAll(transform.rotation);
  }
  return writer.Message();
}

}  // namespace raygrid
