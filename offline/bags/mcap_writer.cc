#include "bags/mcap_writer.h"

#include <zlib.h>

#include <algorithm>

#include "bags/bag_file.h"
#include "dataset/byte_reader.h"

namespace raygrid {
namespace {

constexpr size_t kChunkBytes = 4 << 20;

void AppendMcapText(const std::string& text, std::string* bytes) {
  Append(static_cast<uint32_t>(text.size()), bytes);
  *bytes += text;
}

void AppendMcapRecord(uint8_t opcode, const std::string& content,
                      std::string* bytes) {
  Append(opcode, bytes);
  Append(uint64_t{content.size()}, bytes);
  *bytes += content;
}

uint32_t ComputeMcapCrc(const std::string& bytes) {
  return static_cast<uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string Definition(const std::string& fields,
                       const std::vector<std::string>& contained) {
  static const std::map<std::string, std::string> definitions = {
      {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
      {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
      {"sensor_msgs/RegionOfInterest",
       "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool "
       "do_rectify\n"},
      {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"geometry_msgs/Quaternion",
       "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
      {"geometry_msgs/Transform",
       "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion "
       "rotation\n"},
      {"geometry_msgs/TransformStamped",
       "std_msgs/Header header\nstring child_frame_id\n"
       "geometry_msgs/Transform transform\n"}};
  std::string text = fields;
  for (const std::string& name : contained)
    text +=
        std::string(80, '=') + "\nMSG: " + name + "\n" + definitions.at(name);
  return text;
}

}  // namespace

std::string GetMessageDefinition(const std::string& type) {
  const std::vector<std::string> header = {"std_msgs/Header",
                                           "builtin_interfaces/Time"};
  if (type == "sensor_msgs/msg/Image")
    return Definition(
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring "
        "encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n",
        header);
  if (type == "sensor_msgs/msg/CameraInfo")
    return Definition(
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring "
        "distortion_model\nfloat64[] d\nfloat64[9] k\nfloat64[9] r\n"
        "float64[12] p\nuint32 binning_x\nuint32 binning_y\n"
        "sensor_msgs/RegionOfInterest roi\n",
        {"std_msgs/Header", "builtin_interfaces/Time",
         "sensor_msgs/RegionOfInterest"});
  return Definition("geometry_msgs/TransformStamped[] transforms\n",
                    {"geometry_msgs/TransformStamped", "std_msgs/Header",
                     "builtin_interfaces/Time", "geometry_msgs/Transform",
                     "geometry_msgs/Vector3", "geometry_msgs/Quaternion"});
}

McapWriter::McapWriter(std::ostream* stream) : stream_(stream) {
  std::string header = kMcapMagic, content;
  AppendMcapText("ros2", &content);
  AppendMcapText("raygrid", &content);
  AppendMcapRecord(1, content, &header);
  Put(header);
}

void McapWriter::Put(const std::string& bytes) {
  stream_->write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  size_ += bytes.size();
}

uint16_t McapWriter::AddTopic(const std::string& name,
                              const std::string& type) {
  const auto number = static_cast<uint16_t>(counts_.size() + 1);
  counts_[number] = 0;
  std::string schema, channel, declaration;
  Append(number, &schema);
  AppendMcapText(type, &schema);
  AppendMcapText("ros2msg", &schema);
  AppendMcapText(GetMessageDefinition(type), &schema);
  AppendMcapRecord(3, schema, &declaration);
  Append(number, &channel);
  Append(number, &channel);
  AppendMcapText(name, &channel);
  AppendMcapText("cdr", &channel);
  Append(uint32_t{0}, &channel);
  AppendMcapRecord(4, channel, &declaration);
  declarations_ += declaration;
  records_ += declaration;
  return number;
}

void McapWriter::Write(uint16_t topic, int64_t log_ns,
                       const std::string& message) {
  const auto time = static_cast<uint64_t>(log_ns);
  index_[topic].emplace_back(time, records_.size());
  ++counts_[topic];
  std::string content;
  Append(topic, &content);
  Append(sequence_++, &content);
  Append(time, &content);
  Append(time, &content);
  AppendMcapRecord(5, content + message, &records_);
  if (records_.size() >= kChunkBytes) FinishChunk();
}

void McapWriter::FinishChunk() {
  if (index_.empty()) return;
  Chunk chunk;
  chunk.offset = size_;
  chunk.first_ns = UINT64_MAX;
  for (const auto& [topic, entries] : index_)
    for (const auto& [time, offset] : entries) {
      chunk.first_ns = std::min(chunk.first_ns, time);
      chunk.last_ns = std::max(chunk.last_ns, time);
    }
  chunk.records_size = records_.size();
  std::string content, record;
  Append(chunk.first_ns, &content);
  Append(chunk.last_ns, &content);
  Append(chunk.records_size, &content);
  Append(ComputeMcapCrc(records_), &content);
  AppendMcapText("", &content);
  Append(chunk.records_size, &content);
  AppendMcapRecord(6, content + records_, &record);
  chunk.size = record.size();
  Put(record);
  const uint64_t index_begin = size_;
  for (const auto& [topic, entries] : index_) {
    chunk.index_offsets[topic] = size_;
    std::string index, index_record;
    Append(topic, &index);
    Append(static_cast<uint32_t>(16 * entries.size()), &index);
    for (const auto& [time, offset] : entries) {
      Append(time, &index);
      Append(offset, &index);
    }
    AppendMcapRecord(7, index, &index_record);
    Put(index_record);
  }
  chunk.index_size = size_ - index_begin;
  chunks_.push_back(chunk);
  records_.clear();
  index_.clear();
}

// The records of the summary: declarations, statistics, index of chunks.
std::string McapWriter::Summary() const {
  std::string summary = declarations_, statistics;
  uint64_t num_messages = 0, first_ns = chunks_.empty() ? 0 : UINT64_MAX,
           last_ns = 0;
  for (const auto& [topic, count] : counts_) num_messages += count;
  for (const Chunk& chunk : chunks_) {
    first_ns = std::min(first_ns, chunk.first_ns);
    last_ns = std::max(last_ns, chunk.last_ns);
  }
  Append(num_messages, &statistics);
  Append(static_cast<uint16_t>(counts_.size()), &statistics);
  Append(static_cast<uint32_t>(counts_.size()), &statistics);
  Append(uint64_t{0}, &statistics);  // no attachments, no metadata
  Append(static_cast<uint32_t>(chunks_.size()), &statistics);
  Append(first_ns, &statistics);
  Append(last_ns, &statistics);
  Append(static_cast<uint32_t>(10 * counts_.size()), &statistics);
  for (const auto& [topic, count] : counts_) {
    Append(topic, &statistics);
    Append(count, &statistics);
  }
  AppendMcapRecord(11, statistics, &summary);
  for (const Chunk& chunk : chunks_) {
    std::string index;
    for (const uint64_t value :
         {chunk.first_ns, chunk.last_ns, chunk.offset, chunk.size})
      Append(value, &index);
    Append(static_cast<uint32_t>(10 * chunk.index_offsets.size()), &index);
    for (const auto& [topic, offset] : chunk.index_offsets) {
      Append(topic, &index);
      Append(offset, &index);
    }
    Append(chunk.index_size, &index);
    AppendMcapText("", &index);
    Append(chunk.records_size, &index);
    Append(chunk.records_size, &index);
    AppendMcapRecord(8, index, &summary);
  }
  return summary;
}

void McapWriter::Finish() {
  FinishChunk();
  std::string end;
  AppendMcapRecord(15, std::string(4, '\0'), &end);
  Put(end);
  // The footer's own checksum covers the summary and the footer's start.
  std::string tail = Summary(), footer;
  Append(size_, &footer);
  Append(uint64_t{0}, &footer);
  Append(uint8_t{2}, &tail);
  Append(uint64_t{20}, &tail);
  tail += footer;
  Append(ComputeMcapCrc(tail), &tail);
  Put(tail + kMcapMagic);
}

}  // namespace raygrid
