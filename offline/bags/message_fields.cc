#include "bags/message_fields.h"

#include <fmt/format.h>

#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr size_t kEncapsulationBytes = 4;

uint64_t GetVarint(ByteReader* reader) {
  uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    const auto byte = reader->Get<uint8_t>();
    value |= uint64_t{byte & 0x7fu} << shift;
    if (byte < 0x80) return value;
  }
  throw InputError("a number of more than 64 bits");
}

int Base64Value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

}  // namespace

MessageFields::MessageFields(MessageEncoding encoding, std::string_view data)
    : is_aligned_(encoding == MessageEncoding::kCdr),
      reader_(is_aligned_ && data.size() >= kEncapsulationBytes
                  ? data.substr(kEncapsulationBytes)
                  : data) {
  if (!is_aligned_) return;
  // CDR_BE is 0, CDR_LE is 1; others are for types with optional members.
  if (data.size() < kEncapsulationBytes || data[0] != 0 ||
      (data[1] != 0 && data[1] != 1))
    throw InputError("not serialized as plain CDR");
  order_ = data[1] == 0 ? ByteOrder::kBig : ByteOrder::kLittle;
}

std::string MessageFields::Text() {
  std::string_view text = Bytes();
  if (is_aligned_ && !text.empty() && text.back() == '\0')
    text.remove_suffix(1);
  return std::string(text);
}

std::vector<double> MessageFields::Doubles(size_t count) {
  std::vector<double> numbers(count);
  for (double& number : numbers) number = Get<double>();
  return numbers;
}

std::vector<double> MessageFields::ListOfDoubles(size_t most) {
  const auto count = Get<uint32_t>();
  if (count > most)
    throw InputError(fmt::format("a list of {} numbers", count));
  return Doubles(count);
}

int64_t MessageFields::Time() {
  const auto seconds = Get<uint32_t>();
  return MakeStamp(
      is_aligned_ ? int64_t{static_cast<int32_t>(seconds)} : int64_t{seconds},
      Get<uint32_t>());
}

int64_t MessageFields::Header(std::string* frame_id) {
  if (!is_aligned_) Get<uint32_t>();
  const int64_t stamp_ns = Time();
  *frame_id = Text();
  return stamp_ns;
}

std::vector<ProtobufField> ReadProtobuf(std::string_view data) {
  std::vector<ProtobufField> fields;
  ByteReader reader(data);
  while (reader.remaining() > 0) {
    const uint64_t key = GetVarint(&reader);
    ProtobufField& field = fields.emplace_back();
    field.number = static_cast<int>(key >> 3 & 0x1fffffff);
    field.wire_type = static_cast<int>(key & 7);
    switch (field.wire_type) {
      case ProtobufField::kVarint:
        field.value = GetVarint(&reader);
        break;
      case ProtobufField::kFixed64:
        field.value = reader.Get<uint64_t>();
        break;
      case ProtobufField::kFixed32:
        field.value = reader.Get<uint32_t>();
        break;
      case ProtobufField::kLengthDelimited:
        field.bytes = reader.View(GetVarint(&reader));
        break;
      default:
        throw InputError("not serialized as protobuf");
    }
  }
  return fields;
}

std::string DecodeBase64(std::string_view text) {
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  uint32_t bits = 0;
  int count = 0;
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  for (const char c : text) {
    const int value = Base64Value(c);
    if (value < 0) throw InputError("not base64");
    bits = bits << 6 | static_cast<uint32_t>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<char>(bits >> count & 0xff));
  }
  return bytes;
}

int64_t MakeStamp(int64_t seconds, int64_t nanoseconds) {
  constexpr int64_t kSecond = 1000000000, kMaxSeconds = kSecond * 9;
  if (seconds < 0 || seconds > kMaxSeconds || nanoseconds < 0 ||
      nanoseconds >= kSecond)
    throw InputError(
        fmt::format("invalid stamp of {} s and {} ns", seconds, nanoseconds));
  return seconds * kSecond + nanoseconds;
}

}  // namespace raygrid
