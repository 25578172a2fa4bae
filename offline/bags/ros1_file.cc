// ROS 1 bags, version 2.0 (wiki.ros.org/Bags/Format/2.0), read forward, without
// their index: that of an interrupted recording is missing.
#include <fmt/format.h>

#include <map>

#include "bags/bag_file.h"
#include "bags/compression.h"
#include "bags/random_access_file.h"
#include "dataset/byte_reader.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

enum Ros1Opcode : uint8_t {
  kRos1Message = 2,
  kRos1BagHeader = 3,
  kRos1Chunk = 5,
  kRos1Connection = 7
};

constexpr uint64_t kMaxRos1HeaderBytes = 1 << 20;

// The fields of a record's header, or of a connection.
class Ros1Fields {
 public:
  explicit Ros1Fields(std::string_view header) {
    ByteReader reader(header);
    while (reader.remaining() > 0) {
      const std::string_view field = reader.View(reader.Get<uint32_t>());
      const size_t equals = field.find('=');
      if (equals == std::string_view::npos)
        throw InputError("a field of the header lacks '='");
      values_.emplace(field.substr(0, equals), field.substr(equals + 1));
    }
  }
  std::string Text(const char* name) const {
    const auto found = values_.find(name);
    if (found == values_.end())
      throw InputError(fmt::format("the header lacks '{}'", name));
    return std::string(found->second);
  }
  template <typename Number>
  Number Get(const char* name) const {
    const std::string text = Text(name);
    return ByteReader(text).Get<Number>();
  }
  uint8_t Opcode() const {
    return values_.count("op") ? Get<uint8_t>("op") : 0;
  }

 private:
  std::map<std::string_view, std::string_view> values_;
};

int64_t GetRos1Time(const Ros1Fields& fields) {
  const auto time = fields.Get<uint64_t>("time");
  return static_cast<int64_t>(time & 0xffffffff) * 1000000000 +
         static_cast<int64_t>(time >> 32);
}

class Ros1File : public BagFile {
 public:
  Ros1File(const std::string& path, const std::string& name)
      : file_(path, name) {}

  void Scan(const BagVisitor& visitor) override;
  std::string Read(const MessagePlace& place) const override;

 private:
  struct Record {
    std::string header;
    uint64_t offset = 0, size = 0;  // of its data
  };
  // Reads the header of a record; false at the end, or if it is incomplete.
  bool ReadHeader(uint64_t at, Record* record) const;
  void ReadRecord(const Record& record);
  void ReadConnection(const Ros1Fields& fields, std::string_view data);
  void ReadMessage(const Ros1Fields& fields, std::string_view data,
                   int64_t chunk, uint64_t offset);
  void ReadChunk(const Ros1Fields& fields, const Record& record);
  std::string LoadChunk(const Ros1Fields& fields, const Record& record) const;

  RandomAccessFile file_;
  mutable ChunkCache chunks_;
  // While scanning.
  const BagVisitor* visitor_ = nullptr;
  std::map<uint32_t, size_t> topics_;  // by connection
  uint64_t num_unknown_ = 0;           // messages of unknown connections
  bool is_indexed_ = false;
};

bool Ros1File::ReadHeader(uint64_t at, Record* record) const {
  if (!file_.Contains(at, 4)) return false;
  const std::string size = file_.Read(at, 4);
  const uint64_t num_bytes = ByteReader(size).Get<uint32_t>();
  if (num_bytes > kMaxRos1HeaderBytes || !file_.Contains(at + 4, num_bytes + 4))
    return false;
  record->header = file_.Read(at + 4, num_bytes);
  const std::string data = file_.Read(at + 4 + num_bytes, 4);
  record->size = ByteReader(data).Get<uint32_t>();
  record->offset = at + 8 + num_bytes;
  return file_.Contains(record->offset, record->size);
}

void Ros1File::ReadConnection(const Ros1Fields& fields, std::string_view data) {
  const auto id = fields.Get<uint32_t>("conn");
  if (!topics_.count(id))
    topics_[id] = visitor_->add_topic(fields.Text("topic"),
                                      Ros1Fields(data).Text("type"), "ros1");
}

void Ros1File::ReadMessage(const Ros1Fields& fields, std::string_view data,
                           int64_t chunk, uint64_t offset) {
  const auto topic = topics_.find(fields.Get<uint32_t>("conn"));
  BagMessage message;
  message.log_ns = GetRos1Time(fields);
  if (topic == topics_.end()) {
    ++num_unknown_;
    return;
  }
  message.topic = topic->second;
  message.data = data;
  message.place = {0, chunk, offset, data.size()};
  visitor_->visit(message);
}

std::string Ros1File::LoadChunk(const Ros1Fields& fields,
                                const Record& record) const {
  return Decompress(fields.Text("compression"),
                    file_.Read(record.offset, record.size),
                    fields.Get<uint32_t>("size"));
}

void Ros1File::ReadChunk(const Ros1Fields& chunk, const Record& record) {
  const std::string records = LoadChunk(chunk, record);
  // Chunks are found again by their header.
  const uint64_t place = record.offset - 8 - record.header.size();
  ByteReader reader(records);
  while (reader.remaining() > 0) {
    const Ros1Fields fields(reader.View(reader.Get<uint32_t>()));
    const std::string_view data = reader.View(reader.Get<uint32_t>());
    if (fields.Opcode() == kRos1Connection)
      ReadConnection(fields, data);
    else if (fields.Opcode() == kRos1Message)
      ReadMessage(fields, data, static_cast<int64_t>(place),
                  reader.at() - data.size());
  }
}

void Ros1File::ReadRecord(const Record& record) {
  const Ros1Fields fields(record.header);
  const uint8_t opcode = fields.Opcode();
  if (opcode == kRos1BagHeader)
    is_indexed_ = fields.Get<uint64_t>("index_pos") > 0;
  else if (opcode == kRos1Chunk)
    ReadChunk(fields, record);
  else if (opcode == kRos1Connection)
    ReadConnection(fields, file_.Read(record.offset, record.size));
  else if (opcode == kRos1Message)
    ReadMessage(fields, file_.Read(record.offset, record.size), -1,
                record.offset);
}

void Ros1File::Scan(const BagVisitor& visitor) {
  visitor_ = &visitor;
  topics_.clear();
  num_unknown_ = 0;
  is_indexed_ = false;
  uint64_t at = sizeof(kRos1Magic) - 1;
  for (Record record; ReadHeader(at, &record);) {
    try {
      ReadRecord(record);
    } catch (const InputError& error) {
      visitor.remark(fmt::format(
          "{}: the record at byte {} is damaged ({}) and was skipped",
          file_.name(), at, error.what()));
    }
    at = record.offset + record.size;
    visitor.progress(static_cast<double>(at) /
                     static_cast<double>(file_.size()));
  }
  if (at < file_.size())
    visitor.remark(fmt::format(
        "{}: ends within a record at byte {}; it is truncated or still being "
        "recorded, and was read up to there",
        file_.name(), at));
  else if (!is_indexed_)
    visitor.remark(file_.name() +
                   ": has no index; the recording was interrupted, and was "
                   "read as far as it goes");
  if (num_unknown_ > 0)
    visitor.remark(
        fmt::format("{}: {} messages of undeclared connections were skipped",
                    file_.name(), num_unknown_));
}

std::string Ros1File::Read(const MessagePlace& place) const {
  if (place.chunk < 0) return file_.Read(place.offset, place.size);
  const ChunkCache::Chunk chunk = chunks_.Get(place.chunk, [&] {
    Record record;
    if (!ReadHeader(static_cast<uint64_t>(place.chunk), &record))
      throw InputError(file_.name() + ": was changed");
    return LoadChunk(Ros1Fields(record.header), record);
  });
  return ExtractMessage(*chunk, place);
}

}  // namespace

std::unique_ptr<BagFile> OpenRos1File(const std::string& path,
                                      const std::string& name) {
  return std::make_unique<Ros1File>(path, name);
}

}  // namespace raygrid
