#include "bags/camera_info.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "bags/bag.h"
#include "bags/message_fields.h"
#include "bags/topic_choice.h"
#include "dataset/byte_reader.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr size_t kMaxCoefficients = 1000;

// Appends a number, or the packed numbers, of a repeated field of doubles.
void AppendDoubles(const ProtobufField& field, std::vector<double>* numbers) {
  if (field.wire_type == ProtobufField::kFixed64) {
    double number;
    std::memcpy(&number, &field.value, sizeof(number));
    numbers->push_back(number);
  }
  ByteReader reader(field.bytes);
  while (reader.remaining() > 0) numbers->push_back(reader.Get<double>());
}

// foxglove.CameraCalibration
CameraInfo ParseCameraCalibration(std::string_view data) {
  CameraInfo info;
  std::vector<double>* const lists[] = {&info.d, &info.k, &info.r, &info.p};
  for (const ProtobufField& field : ReadProtobuf(data)) {
    if (field.number == 2) info.width = static_cast<uint32_t>(field.value);
    if (field.number == 3) info.height = static_cast<uint32_t>(field.value);
    if (field.number == 4) info.model = std::string(field.bytes);
    if (field.number >= 5 && field.number <= 8)
      AppendDoubles(field, lists[field.number - 5]);
  }
  const size_t num_r = info.r.size(), num_p = info.p.size();
  if (info.d.size() > kMaxCoefficients || info.k.size() != 9 ||
      (num_r != 0 && num_r != 9) || (num_p != 0 && num_p != 12))
    throw InputError(
        fmt::format("{} coefficients, and {}, {} and {} numbers of K, R and P",
                    info.d.size(), info.k.size(), num_r, num_p));
  // Optional, unlike in ROS.
  const std::vector<double>& k = info.k;
  if (info.r.empty()) info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (info.p.empty())
    info.p = {k[0], k[1], k[2], 0, k[3], k[4], k[5], 0, k[6], k[7], k[8], 0};
  return info;
}

bool HasCameraInfo(const BagTopic& topic) {
  return topic.encoding == MessageEncoding::kProtobuf
             ? topic.type == "foxglove.CameraCalibration"
             : topic.type == "sensor_msgs/CameraInfo" &&
                   (topic.encoding == MessageEncoding::kRos1 ||
                    topic.encoding == MessageEncoding::kCdr);
}

CameraInfo ParseCameraInfo(MessageEncoding encoding, std::string_view data) {
  if (encoding == MessageEncoding::kProtobuf)
    return ParseCameraCalibration(data);
  MessageFields fields(encoding, data);
  CameraInfo info;
  std::string frame_id;
  fields.Header(&frame_id);
  info.height = fields.Get<uint32_t>();
  info.width = fields.Get<uint32_t>();
  info.model = fields.Text();
  info.d = fields.ListOfDoubles(kMaxCoefficients);
  info.k = fields.Doubles(9);
  info.r = fields.Doubles(9);
  info.p = fields.Doubles(12);
  info.binning_x = fields.Get<uint32_t>();
  info.binning_y = fields.Get<uint32_t>();
  for (uint32_t& value : info.roi) value = fields.Get<uint32_t>();
  return info;
}

// The first message of a topic, if it decodes.
struct InfoTopic {
  std::string name, failure;
  std::optional<CameraInfo> first;
  uint64_t num_different = 0;
};

void AddInfo(const BagTopic& topic, const BagMessage& message,
             InfoTopic* found) {
  try {
    const CameraInfo info = ParseCameraInfo(topic.encoding, message.data);
    if (!found->first) found->first = info;
    found->num_different +=
        FormatCameraInfo(info) != FormatCameraInfo(*found->first);
  } catch (const InputError& error) {
    found->failure = error.what();
  }
}

}  // namespace

CameraInfo ReadCameraInfo(const std::string& path, const std::string& topic,
                          std::vector<std::string>* remarks) {
  Bag bag(path);
  std::map<size_t, InfoTopic> by_topic;
  bag.Scan([&](const BagMessage& message) {
    const BagTopic& own = bag.topics()[message.topic];
    if (HasCameraInfo(own)) AddInfo(own, message, &by_topic[message.topic]);
  });
  *remarks = bag.remarks();
  std::vector<std::string> names;
  std::vector<const InfoTopic*> topics;
  for (const auto& [number, found] : by_topic) {
    names.push_back(bag.topics()[number].name);
    topics.push_back(&found);
  }
  const size_t chosen =
      ChooseTopic(bag, names, topic,
                  "CameraInfo (sensor_msgs) or CameraCalibration (Foxglove)");
  const InfoTopic& found = *topics[chosen];
  if (!found.first)
    throw InputError(fmt::format("{}:{}: no message decodes ({})", path,
                                 names[chosen], found.failure));
  if (found.num_different > 0)
    remarks->push_back(fmt::format(
        "{}:{}: {} messages differ from the first one, which is used", path,
        names[chosen], found.num_different));
  return *found.first;
}

std::string FormatCameraInfo(const CameraInfo& info) {
  return fmt::format(
      "height: {}\nwidth: {}\ndistortion_model: {}\nD: [{}]\nK: [{}]\nR: "
      "[{}]\nP: [{}]\nbinning_x: {}\nbinning_y: {}\nroi:\n  x_offset: {}\n  "
      "y_offset: {}\n  height: {}\n  width: {}\n",
      info.height, info.width,
      nlohmann::json(info.model)
          .dump(-1, ' ', true, nlohmann::json::error_handler_t::replace),
      fmt::join(info.d, ", "), fmt::join(info.k, ", "), fmt::join(info.r, ", "),
      fmt::join(info.p, ", "), info.binning_x, info.binning_y, info.roi[0],
      info.roi[1], info.roi[2], info.roi[3]);
}

}  // namespace raygrid
