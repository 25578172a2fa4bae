/// Bags that tests write, each with a few grey images of a topic.
#ifndef RAYGRID_TESTS_OFFLINE_BAGS_WRITTEN_BAGS_H
#define RAYGRID_TESTS_OFFLINE_BAGS_WRITTEN_BAGS_H

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "dataset/byte_reader.h"

namespace raygrid {

constexpr int kWrittenImages = 6;
constexpr char kWrittenTopic[] = "/cam/image_raw";

inline int64_t WrittenStamp(int image) {
  return 1700000000000000000 + 100000000 * int64_t{image};
}

/// The pixels of an image of 4 x 3 pixels.
inline std::string WrittenPixels(int image) {
  std::string pixels;
  for (int k = 0; k < 12; ++k)
    pixels.push_back(static_cast<char>(20 * image + k));
  return pixels;
}

/// Appends a text after its length.
inline void AppendText(const std::string& text, std::string* bytes) {
  Append(static_cast<uint32_t>(text.size()), bytes);
  *bytes += text;
}

/// sensor_msgs/Image, of mono8 pixels with 5 bytes per row.
inline std::string Ros1Image(int image) {
  std::string data, padded;
  Append(uint32_t{7}, &data);
  Append(static_cast<uint32_t>(WrittenStamp(image) / 1000000000), &data);
  Append(static_cast<uint32_t>(WrittenStamp(image) % 1000000000), &data);
  AppendText("cam", &data);
  Append(uint32_t{3}, &data);
  Append(uint32_t{4}, &data);
  AppendText("mono8", &data);
  Append(uint8_t{0}, &data);
  Append(uint32_t{5}, &data);
  for (int y = 0; y < 3; ++y)
    padded += WrittenPixels(image).substr(4 * y, 4) + "-";
  AppendText(padded, &data);
  return data;
}

inline std::string CdrImage(int image, ByteOrder order = ByteOrder::kLittle) {
  std::string data, padded;
  const auto number = [&](uint32_t value) {
    data.resize((data.size() + 3) / 4 * 4);
    Append(value, &data, order);
  };
  const auto text = [&](const std::string& value) {
    number(static_cast<uint32_t>(value.size() + 1));
    data += value + '\0';
  };
  number(static_cast<uint32_t>(WrittenStamp(image) / 1000000000));
  number(static_cast<uint32_t>(WrittenStamp(image) % 1000000000));
  text("cam");
  number(3);
  number(4);
  text("mono8");
  data.push_back('\0');
  number(4);
  number(12);
  const std::string start = {0, order == ByteOrder::kLittle ? '\1' : '\0', 0,
                             0};
  return start + data + WrittenPixels(image);
}

inline std::string Compressed(const std::string& method,
                              const std::string& data) {
  std::string out(2 * data.size() + 1000, '\0');
  if (method == "zstd") {
    out.resize(
        ZSTD_compress(out.data(), out.size(), data.data(), data.size(), 1));
  } else if (method == "lz4") {
    out.resize(LZ4F_compressFrame(out.data(), out.size(), data.data(),
                                  data.size(), nullptr));
  } else if (method == "bz2") {
    auto size = static_cast<unsigned>(out.size());
    std::string in = data;
    BZ2_bzBuffToBuffCompress(out.data(), &size, in.data(),
                             static_cast<unsigned>(in.size()), 9, 0, 0);
    out.resize(size);
  } else {
    out = data;
  }
  return out;
}

inline void AppendMcapRecord(uint8_t opcode, const std::string& content,
                             std::string* bytes) {
  bytes->push_back(static_cast<char>(opcode));
  Append(uint64_t{content.size()}, bytes);
  *bytes += content;
}

inline std::string McapBag(const std::string& method, bool has_crc = true) {
  std::string schema, channel, bag = "\x89MCAP0\r\n";
  Append(uint16_t{1}, &schema);
  for (const char* text : {"sensor_msgs/msg/Image", "ros2msg", ""})
    AppendText(text, &schema);
  Append(uint16_t{1}, &channel);
  Append(uint16_t{1}, &channel);
  for (const char* text : {kWrittenTopic, "cdr", ""})
    AppendText(text, &channel);
  for (int first = 0; first < kWrittenImages; first += 3) {
    std::string records, chunk;
    if (first == 0) AppendMcapRecord(3, schema, &records);
    if (first == 0) AppendMcapRecord(4, channel, &records);
    for (int image = first; image < first + 3; ++image) {
      std::string message;
      Append(uint16_t{1}, &message);
      Append(uint32_t(image), &message);
      Append(WrittenStamp(image) + 5, &message);
      Append(WrittenStamp(image) + 5, &message);
      AppendMcapRecord(5, message + CdrImage(image), &records);
    }
    Append(uint64_t{0}, &chunk);
    Append(uint64_t{0}, &chunk);
    Append(uint64_t{records.size()}, &chunk);
    Append(has_crc ? static_cast<uint32_t>(crc32(
                         0, reinterpret_cast<const Bytef*>(records.data()),
                         static_cast<uInt>(records.size())))
                   : 0,
           &chunk);
    AppendText(method, &chunk);
    const std::string data = Compressed(method, records);
    Append(uint64_t{data.size()}, &chunk);
    AppendMcapRecord(6, chunk + data, &bag);
  }
  AppendMcapRecord(15, std::string(4, '\0'), &bag);
  AppendMcapRecord(2, std::string(20, '\0'), &bag);
  return bag + "\x89MCAP0\r\n";
}

using Ros1Header = std::vector<std::pair<std::string, std::string>>;

inline std::string Ros1HeaderText(const Ros1Header& header) {
  std::string text;
  for (const auto& [key, value] : header) AppendText(key + "=" + value, &text);
  return text;
}

inline void AppendRos1Record(const Ros1Header& header, const std::string& data,
                             std::string* bytes) {
  AppendText(Ros1HeaderText(header), bytes);
  AppendText(data, bytes);
}

template <typename Number>
std::string NumberText(Number number) {
  std::string text;
  Append(number, &text);
  return text;
}

inline std::string Ros1Bag(const std::string& method) {
  std::string bag = "#ROSBAG V2.0\n";
  AppendRos1Record({{"op", "\3"},
                    {"index_pos", NumberText(uint64_t{1})},
                    {"conn_count", NumberText(1)},
                    {"chunk_count", NumberText(2)}},
                   std::string(100, ' '), &bag);
  const std::string connection = NumberText(0);
  for (int first = 0; first < kWrittenImages; first += 3) {
    std::string records;
    if (first == 0)
      AppendRos1Record(
          {{"op", "\7"}, {"conn", connection}, {"topic", kWrittenTopic}},
          Ros1HeaderText(
              {{"topic", kWrittenTopic}, {"type", "sensor_msgs/Image"}}),
          &records);
    for (int image = first; image < first + 3; ++image)
      AppendRos1Record({{"op", "\2"},
                        {"conn", connection},
                        {"time", NumberText(static_cast<uint32_t>(
                                     WrittenStamp(image) / 1000000000)) +
                                     NumberText(static_cast<uint32_t>(
                                         WrittenStamp(image) % 1000000000))}},
                       Ros1Image(image), &records);
    AppendRos1Record(
        {{"op", "\5"},
         {"compression", method},
         {"size", NumberText(static_cast<uint32_t>(records.size()))}},
        Compressed(method, records), &bag);
  }
  return bag;
}

/// Writes a database.
inline void WriteDatabaseBag(const std::string& path) {
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  std::string sql = fmt::format(
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, "
      "serialization_format, offered_qos_profiles);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, "
      "data);"
      "INSERT INTO topics VALUES(1, '{}', 'sensor_msgs/msg/Image', 'cdr', '');",
      kWrittenTopic);
  for (int image = 0; image < kWrittenImages; ++image) {
    std::string hex;
    for (const unsigned char c : CdrImage(image))
      hex += fmt::format("{:02x}", c);
    sql += fmt::format("INSERT INTO messages VALUES({}, 1, {}, x'{}');",
                       image + 1, WrittenStamp(image), hex);
  }
  sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr);
  sqlite3_close(database);
}

}  // namespace raygrid

#endif  // RAYGRID_TESTS_OFFLINE_BAGS_WRITTEN_BAGS_H
