// MCAP 0 (mcap.dev/spec), read forward. The summary, which a truncated file
// lacks, is used for the channels of damaged chunks only.
#include <fmt/format.h>
#include <zlib.h>

#include <map>
#include <optional>

#include "bags/bag_file.h"
#include "bags/compression.h"
#include "bags/random_access_file.h"
#include "dataset/byte_reader.h"
#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

enum McapOpcode : uint8_t {
  kMcapFooter = 2,
  kMcapSchema = 3,
  kMcapChannel = 4,
  kMcapMessage = 5,
  kMcapChunk = 6,
  kMcapDataEnd = 15
};

constexpr uint64_t kRecordStart = 9;    // opcode, size
constexpr uint64_t kMessageStart = 22;  // channel, sequence, two times

std::string McapText(ByteReader* reader) {
  return reader->GetText(reader->Get<uint32_t>());
}

uint32_t Crc32(std::string_view data) {
  return static_cast<uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(data.data()), data.size()));
}

struct McapChunk {
  uint64_t size = 0;  // uncompressed
  uint32_t crc = 0;   // of the uncompressed records; 0: none
  std::string compression;
  std::string_view data;

  explicit McapChunk(std::string_view content) {
    ByteReader reader(content);
    reader.Skip(2, 8);  // start and end time
    size = reader.Get<uint64_t>();
    crc = reader.Get<uint32_t>();
    compression = McapText(&reader);
    data = reader.View(reader.Get<uint64_t>());
  }
  std::string Records() const {
    std::string records = Decompress(compression, data, size);
    if (crc != 0 && Crc32(records) != crc) throw InputError("wrong checksum");
    return records;
  }
};

class McapFile : public BagFile {
 public:
  McapFile(const std::string& path, const std::string& name)
      : file_(path, name) {}

  void Scan(const BagVisitor& visitor) override;
  std::string Read(const MessagePlace& place) const override;

 private:
  // Reads a record; it is in the chunk at this byte, or (-1) at this offset of
  // the file.
  void ReadRecord(uint8_t opcode, std::string_view content, int64_t chunk,
                  uint64_t offset);
  void ReadSummary();
  void ReadChannel(std::string_view content);
  void ReadMessage(std::string_view content, int64_t chunk, uint64_t offset);
  void ReadChunk(std::string_view content, uint64_t offset);
  void RemarkEnd(uint64_t at, bool has_end);

  RandomAccessFile file_;
  mutable ChunkCache chunks_;
  // While scanning.
  const BagVisitor* visitor_ = nullptr;
  std::map<uint16_t, std::string> schemas_;
  std::map<uint16_t, size_t> topics_;  // by channel
  uint64_t num_unknown_ = 0;           // messages of unknown channels
};

void McapFile::ReadChannel(std::string_view content) {
  ByteReader reader(content);
  const auto id = reader.Get<uint16_t>(), schema = reader.Get<uint16_t>();
  const std::string topic = McapText(&reader), encoding = McapText(&reader);
  if (topics_.count(id)) return;
  const auto found = schemas_.find(schema);
  topics_[id] = visitor_->add_topic(
      topic, found == schemas_.end() ? "" : found->second, encoding);
}

void McapFile::ReadMessage(std::string_view content, int64_t chunk,
                           uint64_t offset) {
  ByteReader reader(content);
  const auto topic = topics_.find(reader.Get<uint16_t>());
  reader.Skip(1, 4);
  BagMessage message;
  message.log_ns = static_cast<int64_t>(reader.Get<uint64_t>());
  reader.Skip(1, 8);
  if (topic == topics_.end()) {
    ++num_unknown_;
    return;
  }
  message.topic = topic->second;
  message.data = content.substr(kMessageStart);
  message.place = {0, chunk, offset + kMessageStart, message.data.size()};
  visitor_->visit(message);
}

void McapFile::ReadChunk(std::string_view content, uint64_t offset) {
  const std::string records = McapChunk(content).Records();
  ByteReader reader(records);
  while (reader.remaining() > 0) {
    const auto opcode = reader.Get<uint8_t>();
    const std::string_view record = reader.View(reader.Get<uint64_t>());
    if (opcode == kMcapChunk) throw InputError("chunk in a chunk");
    ReadRecord(opcode, record, static_cast<int64_t>(offset),
               reader.at() - record.size());
  }
}

void McapFile::ReadRecord(uint8_t opcode, std::string_view content,
                          int64_t chunk, uint64_t offset) {
  if (opcode == kMcapSchema) {
    ByteReader reader(content);
    const auto id = reader.Get<uint16_t>();
    schemas_[id] = McapText(&reader);
  } else if (opcode == kMcapChannel) {
    ReadChannel(content);
  } else if (opcode == kMcapMessage) {
    ReadMessage(content, chunk, offset);
  } else if (opcode == kMcapChunk) {
    ReadChunk(content, offset);
  }
}

// Reads the schemas and channels that the summary repeats, if there is one.
void McapFile::ReadSummary() {
  constexpr uint64_t kFooterSize = 20, kMaxSummaryBytes = 64 << 20;
  const std::string magic = kMcapMagic;
  const uint64_t tail_size = kRecordStart + kFooterSize + magic.size();
  if (file_.size() < magic.size() + tail_size) return;
  const uint64_t end = file_.size() - tail_size;
  const std::string tail = file_.Read(end, tail_size);
  ByteReader footer(tail);
  if (footer.Get<uint8_t>() != kMcapFooter ||
      footer.Get<uint64_t>() != kFooterSize ||
      tail.compare(kRecordStart + kFooterSize, magic.size(), magic) != 0)
    return;
  const auto start = footer.Get<uint64_t>();
  if (start == 0 || start >= end || end - start > kMaxSummaryBytes) return;
  const std::string summary = file_.Read(start, end - start);
  ByteReader reader(summary);
  while (reader.remaining() > 0) {
    const auto opcode = reader.Get<uint8_t>();
    const std::string_view record = reader.View(reader.Get<uint64_t>());
    if (opcode == kMcapSchema || opcode == kMcapChannel)
      ReadRecord(opcode, record, -1, 0);
  }
}

void McapFile::RemarkEnd(uint64_t at, bool has_end) {
  if (!has_end)
    visitor_->remark(fmt::format(
        "{}: ends without a summary, within a record at byte {}; it is "
        "truncated or still being recorded, and was read up to there",
        file_.name(), at));
  if (num_unknown_ > 0)
    visitor_->remark(
        fmt::format("{}: {} messages of undeclared channels were skipped",
                    file_.name(), num_unknown_));
}

void McapFile::Scan(const BagVisitor& visitor) {
  visitor_ = &visitor;
  schemas_.clear();
  topics_.clear();
  num_unknown_ = 0;
  try {
    ReadSummary();
  } catch (const InputError&) {
    // Chunks declare their channels, too.
  }
  uint64_t at = sizeof(kMcapMagic) - 1;
  bool has_end = false;
  while (!has_end && file_.Contains(at, kRecordStart)) {
    const std::string start = file_.Read(at, kRecordStart);
    ByteReader reader(start);
    const auto opcode = reader.Get<uint8_t>();
    const auto size = reader.Get<uint64_t>();
    has_end = opcode == kMcapDataEnd || opcode == kMcapFooter;
    const uint64_t offset = at + kRecordStart;
    if (has_end || opcode == 0 || !file_.Contains(offset, size)) break;
    if (opcode >= kMcapSchema && opcode <= kMcapChunk) try {
        if (size > kMaxChunkBytes)
          throw InputError(fmt::format("larger than {} bytes", kMaxChunkBytes));
        ReadRecord(opcode, file_.Read(offset, size), -1, offset);
      } catch (const InputError& error) {
        visitor.remark(
            fmt::format("{}: the record at byte {} is damaged "
                        "({}) and was skipped",
                        file_.name(), at, error.what()));
      }
    at = offset + size;
    visitor.progress(static_cast<double>(at) /
                     static_cast<double>(file_.size()));
  }
  RemarkEnd(at, has_end);
}

std::string McapFile::Read(const MessagePlace& place) const {
  if (place.chunk < 0) return file_.Read(place.offset, place.size);
  const auto offset = static_cast<uint64_t>(place.chunk);
  const ChunkCache::Chunk chunk = chunks_.Get(place.chunk, [&] {
    const std::string size =
        file_.Read(offset - sizeof(uint64_t), sizeof(uint64_t));
    const std::string content =
        file_.Read(offset, ByteReader(size).Get<uint64_t>());
    return McapChunk(content).Records();
  });
  return ExtractMessage(*chunk, place);
}

}  // namespace

std::unique_ptr<BagFile> OpenMcapFile(const std::string& path,
                                      const std::string& name) {
  return std::make_unique<McapFile>(path, name);
}

}  // namespace raygrid
