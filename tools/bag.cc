#include "bags/bag.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "dataset/text_encoding.h"
#include "help_formatter.h"
#include "json_output.h"
#include "progress_bar.h"

namespace raygrid {
namespace {

double DurationS(const BagTopic& topic) {
  return 1e-9 * static_cast<double>(topic.last_ns - topic.first_ns);
}

// Messages per second; 0 if there are too few.
double RateHz(const BagTopic& topic) {
  const double seconds = DurationS(topic);
  return seconds > 0 ? static_cast<double>(topic.num_messages - 1) / seconds
                     : 0;
}

std::string FormatBytes(uint64_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (bytes < 10000) return fmt::format("{} B", bytes);
  if (value < 1e7) return fmt::format("{:.0f} kB", value / 1e3);
  return fmt::format("{:.0f} MB", value / 1e6);
}

void PrintTopics(const Bag& bag, const std::vector<BagTopic>& topics) {
  uint64_t num_messages = 0;
  int64_t first_ns = INT64_MAX, last_ns = 0;
  size_t name_width = 5, type_width = 4;
  for (const BagTopic& topic : topics) {
    num_messages += topic.num_messages;
    name_width = std::max(name_width, topic.name.size());
    type_width = std::max(type_width, topic.type.size());
    if (topic.num_messages == 0) continue;
    first_ns = std::min(first_ns, topic.first_ns);
    last_ns = std::max(last_ns, topic.last_ns);
  }
  fmt::print("{}: {}, {} messages", Printable(bag.path()), bag.kind(),
             num_messages);
  if (num_messages > 0)
    fmt::print(" in {:.3f} s", 1e-9 * static_cast<double>(last_ns - first_ns));
  fmt::print("\n{:{}}  {:{}}  {:>8}  {:>8}  {:>8}\n", "topic", name_width,
             "type", type_width, "messages", "rate", "size");
  for (const BagTopic& topic : topics)
    fmt::print("{:{}}  {:{}}  {:8}  {:>8}  {:>8}\n", topic.name, name_width,
               topic.type, type_width, topic.num_messages,
               fmt::format("{:.4g} Hz", RateHz(topic)),
               FormatBytes(topic.num_bytes));
}

nlohmann::ordered_json ToJson(const Bag& bag,
                              const std::vector<BagTopic>& topics) {
  nlohmann::ordered_json json = {{"bag", Printable(bag.path())},
                                 {"kind", bag.kind()},
                                 {"topics", nlohmann::ordered_json::array()}};
  for (const BagTopic& topic : topics)
    json["topics"].push_back(
        {{"topic", topic.name},
         {"type", topic.type},
         {"encoding", topic.encoding_name},
         {"messages", topic.num_messages},
         {"bytes", topic.num_bytes},
         {"first_s", 1e-9 * static_cast<double>(topic.first_ns)},
         {"last_s", 1e-9 * static_cast<double>(topic.last_ns)},
         {"rate_hz", RateHz(topic)}});
  json["remarks"] = nlohmann::ordered_json::array();
  for (const std::string& remark : bag.remarks())
    json["remarks"].push_back(Printable(remark));
  return json;
}

void Run(const std::string& path, const CommonOptions& common) {
  Bag bag(path);
  {
    ProgressBar bar(common.quiet);
    bag.Scan({}, [&](double done) { bar.Show("reading", done); });
  }
  std::vector<BagTopic> topics = bag.topics();
  std::sort(
      topics.begin(), topics.end(),
      [](const BagTopic& a, const BagTopic& b) { return a.name < b.name; });
  if (!common.quiet && !common.json)
    for (const std::string& remark : bag.remarks())
      fmt::print(stderr, "raygrid: {}\n", Printable(remark));
  if (common.json)
    PrintCommandJson(ToJson(bag, topics));
  else
    PrintTopics(bag, topics);
}

}  // namespace

void AddBag(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "bag", "List the topics of a bag: MCAP, rosbag2 or ROS 1.",
      "raygrid bag run.mcap", common);
  auto path = std::make_shared<std::string>();
  command
      ->add_option("bag", *path,
                   ".mcap, .db3 or .bag file, or a folder of rosbag2")
      ->required();
  command->callback([path, common] { Run(*path, *common); });
}

}  // namespace raygrid
