#include "bags/image_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "bags/message_fields.h"
#include "dataset/error.h"
#include "dataset/image_header.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

// ---- Encodings

// How pixels of 8 or 16 bits become grey or RGB samples: the first sample, and
// the sample of each channel.
struct PixelLayout {
  int bits = 8;
  int stored = 1;  // samples per pixel
  std::vector<int> channels = {0};
};

// The names of sensor_msgs/image_encodings.h, and Foxglove's.
std::optional<PixelLayout> FindLayout(const std::string& encoding) {
  static const std::map<std::string, PixelLayout> layouts = {
      {"mono8", {}},
      {"8UC1", {}},
      {"mono16", {16, 1, {0}}},
      {"16UC1", {16, 1, {0}}},
      {"rgb8", {8, 3, {0, 1, 2}}},
      {"bgr8", {8, 3, {2, 1, 0}}},
      {"8UC3", {8, 3, {2, 1, 0}}},
      {"rgba8", {8, 4, {0, 1, 2}}},
      {"bgra8", {8, 4, {2, 1, 0}}},
      {"8UC4", {8, 4, {2, 1, 0}}},
      {"rgb16", {16, 3, {0, 1, 2}}},
      {"bgr16", {16, 3, {2, 1, 0}}},
      {"16UC3", {16, 3, {2, 1, 0}}},
      {"rgba16", {16, 4, {0, 1, 2}}},
      {"bgra16", {16, 4, {2, 1, 0}}},
      // Luma: U Y V Y, or Y U Y V.
      {"yuv422", {8, 2, {1}}},
      {"uyvy", {8, 2, {1}}},
      {"yuv422_yuy2", {8, 2, {0}}},
      {"yuyv", {8, 2, {0}}},
      // A plane of luma, then others.
      {"nv12", {}},
      {"nv21", {}},
      {"nv24", {}}};
  static const char* const mosaics[] = {"rggb", "bggr", "gbrg", "grbg"};
  for (const char* mosaic : mosaics)
    for (const int bits : {8, 16})
      if (encoding == fmt::format("bayer_{}{}", mosaic, bits))
        return PixelLayout{bits, 1, {0}};
  const auto found = layouts.find(encoding);
  return found == layouts.end() ? std::nullopt : std::optional(found->second);
}

void RequirePixels(const ImageMessage& image) {
  const auto layout = FindLayout(image.encoding);
  if (!layout)
    throw InputError(
        fmt::format("encoding '{}' is not that of a camera image",
                    Printable(std::string_view(image.encoding).substr(0, 40))));
  const auto width = static_cast<uint64_t>(image.size.width),
             height = static_cast<uint64_t>(image.size.height);
  const uint64_t row_bytes = width * layout->stored * layout->bits / 8;
  if (image.step < row_bytes)
    throw InputError(fmt::format("rows of {} bytes for {} {} pixels",
                                 image.step, width, image.encoding));
  if (image.data.size() / image.step < height - 1 ||
      image.data.size() - image.step * (height - 1) < row_bytes)
    throw InputError(fmt::format("{} bytes for {} x {} {} pixels",
                                 image.data.size(), width, height,
                                 image.encoding));
}

ImageSize CheckedSize(uint64_t width, uint64_t height) {
  const std::string limit = DescribeSizeLimit(width, height);
  if (!limit.empty() || width == 0 || height == 0)
    throw InputError(fmt::format("{} x {} pixels{}{}", width, height,
                                 limit.empty() ? "" : "; ", limit));
  return {static_cast<int>(width), static_cast<int>(height)};
}

// ---- Messages

// sensor_msgs/Image; Foxglove's RawImage has no flag of the byte order.
void ParseRosImage(MessageFields* fields, ImageMessage* image) {
  image->stamp_ns = fields->Header(&image->frame_id);
  const auto height = fields->Get<uint32_t>(), width = fields->Get<uint32_t>();
  image->size = CheckedSize(width, height);
  image->encoding = fields->Text();
  image->is_big_endian = fields->Get<uint8_t>() != 0;
  image->step = fields->Get<uint32_t>();
  image->data = fields->Bytes();
}

void ParseRosCompressed(MessageFields* fields, ImageMessage* image) {
  image->stamp_ns = fields->Header(&image->frame_id);
  fields->Text();  // the format, which drivers fill in variously
  image->data = fields->Bytes();
}

void ParseFoxgloveRawFields(MessageFields* fields, ImageMessage* image) {
  image->stamp_ns = fields->Time();
  image->frame_id = fields->Text();
  const auto width = fields->Get<uint32_t>(), height = fields->Get<uint32_t>();
  image->size = CheckedSize(width, height);
  image->encoding = fields->Text();
  image->step = fields->Get<uint32_t>();
  image->data = fields->Bytes();
}

void ParseFoxgloveCompressedFields(MessageFields* fields, ImageMessage* image) {
  image->stamp_ns = fields->Time();
  image->frame_id = fields->Text();
  image->data = fields->Bytes();
}

int64_t ParseProtobufTime(std::string_view data) {
  int64_t seconds = 0, nanoseconds = 0;
  for (const ProtobufField& field : ReadProtobuf(data))
    (field.number == 1 ? seconds : nanoseconds) =
        static_cast<int64_t>(field.value);
  return MakeStamp(seconds, nanoseconds);
}

void ParseFoxgloveProtobuf(bool is_raw, std::string_view data,
                           ImageMessage* image) {
  uint64_t width = 0, height = 0;
  for (const ProtobufField& field : ReadProtobuf(data)) {
    const std::string text(field.bytes.substr(0, 256));
    if (field.number == 1) image->stamp_ns = ParseProtobufTime(field.bytes);
    if (field.number == (is_raw ? 6 : 2)) image->data = field.bytes;
    if (field.number == (is_raw ? 7 : 4)) image->frame_id = text;
    if (!is_raw) continue;
    if (field.number == 2) width = field.value;
    if (field.number == 3) height = field.value;
    if (field.number == 4) image->encoding = text;
    if (field.number == 5) image->step = field.value;
  }
  if (is_raw) image->size = CheckedSize(width, height);
}

void ParseFoxgloveJson(bool is_raw, std::string_view data,
                       ImageMessage* image) {
  try {
    const nlohmann::json json = nlohmann::json::parse(data);
    const nlohmann::json& time = json.at("timestamp");
    image->stamp_ns = MakeStamp(time.at("sec").get<int64_t>(),
                                time.at("nsec").get<int64_t>());
    image->frame_id = json.value("frame_id", "");
    image->own_data = DecodeBase64(json.at("data").get<std::string>());
    image->data = image->own_data;
    if (!is_raw) return;
    image->size = CheckedSize(json.at("width").get<uint64_t>(),
                              json.at("height").get<uint64_t>());
    image->encoding = json.at("encoding").get<std::string>();
    image->step = json.at("step").get<uint64_t>();
  } catch (const nlohmann::json::exception&) {
    throw InputError("not a Foxglove image in JSON");
  }
}

enum class ImageType {
  kNone,
  kRosRaw,
  kRosCompressed,
  kFoxgloveRaw,
  kFoxgloveCompressed
};

ImageType FindImageType(const std::string& type) {
  if (type == "sensor_msgs/Image") return ImageType::kRosRaw;
  if (type == "sensor_msgs/CompressedImage") return ImageType::kRosCompressed;
  for (const char* package : {"foxglove.", "foxglove_msgs/"}) {
    if (type == std::string(package) + "RawImage")
      return ImageType::kFoxgloveRaw;
    if (type == std::string(package) + "CompressedImage")
      return ImageType::kFoxgloveCompressed;
  }
  return ImageType::kNone;
}

void ParseFields(ImageType type, MessageFields fields, ImageMessage* image) {
  switch (type) {
    case ImageType::kRosRaw:
      ParseRosImage(&fields, image);
      break;
    case ImageType::kRosCompressed:
      ParseRosCompressed(&fields, image);
      break;
    case ImageType::kFoxgloveRaw:
      ParseFoxgloveRawFields(&fields, image);
      break;
    case ImageType::kFoxgloveCompressed:
      ParseFoxgloveCompressedFields(&fields, image);
      break;
    case ImageType::kNone:
      throw InputError("not an image");
  }
}

}  // namespace

bool HasImages(const BagTopic& topic) {
  return topic.encoding != MessageEncoding::kOther &&
         FindImageType(topic.type) != ImageType::kNone;
}

void ParseImageMessage(const BagTopic& topic, std::string_view data,
                       ImageMessage* image) {
  *image = ImageMessage();
  const ImageType type = FindImageType(topic.type);
  const bool is_raw =
      type == ImageType::kRosRaw || type == ImageType::kFoxgloveRaw;
  if (topic.encoding == MessageEncoding::kProtobuf)
    ParseFoxgloveProtobuf(is_raw, data, image);
  else if (topic.encoding == MessageEncoding::kJson)
    ParseFoxgloveJson(is_raw, data, image);
  else
    ParseFields(type, MessageFields(topic.encoding, data), image);
  if (is_raw)
    RequirePixels(*image);
  else
    image->size = ParseImageHeader("image", std::string(image->data)).size;
}

std::string MakeImageFile(const ImageMessage& image) {
  if (image.IsCompressed()) return std::string(image.data);
  const PixelLayout layout = *FindLayout(image.encoding);
  const size_t num_channels = layout.channels.size();
  const size_t sample_bytes = layout.bits / 8;
  std::string file =
      fmt::format("P{}\n{} {}\n{}\n", num_channels == 1 ? 5 : 6,
                  image.size.width, image.size.height, (1 << layout.bits) - 1);
  const size_t begin = file.size();
  file.resize(begin + static_cast<size_t>(image.size.width) *
                          image.size.height * num_channels * sample_bytes);
  char* to = &file[begin];
  // PNM is big-endian.
  const bool swaps = sample_bytes == 2 && !image.is_big_endian;
  for (int y = 0; y < image.size.height; ++y) {
    const char* from = image.data.data() + image.step * y;
    for (int x = 0; x < image.size.width; ++x) {
      for (const int channel : layout.channels) {
        const char* const sample = from + channel * sample_bytes;
        to[0] = sample[swaps];
        if (sample_bytes == 2) to[1] = sample[!swaps];
        to += sample_bytes;
      }
      from += layout.stored * sample_bytes;
    }
  }
  return file;
}

}  // namespace raygrid
