/// Serialization of messages, from untrusted files: every read is checked.
#ifndef RAYGRID_BAGS_MESSAGE_FIELDS_H
#define RAYGRID_BAGS_MESSAGE_FIELDS_H

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "bags/bag.h"
#include "dataset/byte_reader.h"

namespace raygrid {

/// Reads the fields of a message in their order: packed in ROS 1, aligned to
/// their size in CDR (OMG DDSI-RTPS 2.3, 10.2). All functions throw InputError
/// at the end.
class MessageFields {
 public:
  /// Throws InputError for CDR with another encapsulation than plain CDR.
  MessageFields(MessageEncoding encoding, std::string_view data);

  template <typename Number>
  Number Get() {
    if (is_aligned_) {
      const size_t beyond = reader_.at() % sizeof(Number);
      if (beyond > 0) reader_.Skip(1, sizeof(Number) - beyond);
    }
    return reader_.Get<Number>(order_);
  }
  std::string Text();
  std::string_view Bytes() { return reader_.View(Get<uint32_t>()); }
  /// Reads a fixed number of doubles, or a list of at most this many.
  std::vector<double> Doubles(size_t count);
  std::vector<double> ListOfDoubles(size_t most);
  /// Reads a time or std_msgs/Header, whose sequence number ROS 1 alone has;
  /// returns nanoseconds. Throws InputError for negative times.
  int64_t Time();
  int64_t Header(std::string* frame_id);

 private:
  bool is_aligned_ = false;
  ByteOrder order_ = ByteOrder::kLittle;
  ByteReader reader_;
};

/// The fields of a protobuf message: varints, and 4 or 8 bytes, are numbers.
struct ProtobufField {
  enum { kVarint = 0, kFixed64 = 1, kLengthDelimited = 2, kFixed32 = 5 };
  int number = 0;
  uint64_t value = 0;
  int wire_type = 0;       ///< kFixed64, kLengthDelimited, ...
  std::string_view bytes;  ///< of text, bytes, messages and packed numbers
};
/// Throws InputError.
std::vector<ProtobufField> ReadProtobuf(std::string_view data);

/// Decodes base64. Throws InputError.
std::string DecodeBase64(std::string_view text);

/// Seconds and nanoseconds as nanoseconds. Throws InputError if negative.
int64_t MakeStamp(int64_t seconds, int64_t nanoseconds);

}  // namespace raygrid

#endif  // RAYGRID_BAGS_MESSAGE_FIELDS_H
