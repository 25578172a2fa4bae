#include "bags/camera_info.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "bags/bag.h"
#include "bags/message_fields.h"
#include "bags/topic_choice.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr size_t kMaxCoefficients = 1000;

CameraInfo ParseCameraInfo(MessageEncoding encoding, std::string_view data) {
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
    if (own.type == "sensor_msgs/CameraInfo" &&
        (own.encoding == MessageEncoding::kRos1 ||
         own.encoding == MessageEncoding::kCdr))
      AddInfo(own, message, &by_topic[message.topic]);
  });
  *remarks = bag.remarks();
  std::vector<std::string> names;
  std::vector<const InfoTopic*> topics;
  for (const auto& [number, found] : by_topic) {
    names.push_back(bag.topics()[number].name);
    topics.push_back(&found);
  }
  const size_t chosen =
      ChooseTopic(bag, names, topic, "messages of sensor_msgs/CameraInfo");
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
