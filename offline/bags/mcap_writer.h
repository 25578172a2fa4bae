#ifndef RAYGRID_BAGS_MCAP_WRITER_H
#define RAYGRID_BAGS_MCAP_WRITER_H

#include <cstdint>
#include <map>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace raygrid {

/// Writes ROS 2 messages to a stream, in uncompressed chunks with checksums and
/// an index: the same bytes for the same messages. Errors are left to the
/// stream's state.
class McapWriter {
 public:
  explicit McapWriter(std::ostream* stream);

  /// Declares a topic. type: one of GetMessageDefinition(). Returns its number.
  uint16_t AddTopic(const std::string& name, const std::string& type);
  /// Writes a message in CDR.
  void Write(uint16_t topic, int64_t log_ns, const std::string& message);
  void Finish();

 private:
  struct Chunk {
    uint64_t offset = 0, size = 0;  // of the record
    uint64_t first_ns = 0, last_ns = 0, records_size = 0;
    std::map<uint16_t, uint64_t> index_offsets;
    uint64_t index_size = 0;
  };
  void Put(const std::string& bytes);
  void FinishChunk();
  std::string Summary() const;

  std::ostream* stream_;
  uint64_t size_ = 0;
  std::string declarations_;  // records of schemas and channels
  std::map<uint16_t, uint64_t> counts_;
  std::string records_;  // of the current chunk
  // Times and offsets of the current chunk's messages, by topic.
  std::map<uint16_t, std::vector<std::pair<uint64_t, uint64_t>>> index_;
  std::vector<Chunk> chunks_;
  uint32_t sequence_ = 0;
};

/// Returns the definition of a message type and those that it contains:
/// "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo" or
/// "tf2_msgs/msg/TFMessage".
std::string GetMessageDefinition(const std::string& type);

}  // namespace raygrid

#endif  // RAYGRID_BAGS_MCAP_WRITER_H
