#include "bags/bag.h"

#include <fmt/format.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <optional>

#include "bags/bag_file.h"
#include "bags/compression.h"
#include "bags/random_access_file.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

// Differences of times are in the range of their type.
constexpr int64_t kMaxTimeNs = 9000000000000000000;
// Damaged files could fill the memory.
constexpr size_t kMaxRemarks = 10, kMaxTopics = 10000;
constexpr char kMetadata[] = "metadata.yaml";

std::string FirstBytes(const std::string& path) {
  std::string bytes(16, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(
      static_cast<size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return bytes;
}

bool HasStart(const std::string& bytes, const char* magic) {
  return bytes.compare(0, std::strlen(magic), magic) == 0;
}

bool IsMcapName(const fs::path& path) { return path.extension() == ".mcap"; }
bool IsDatabaseName(const fs::path& path) { return path.extension() == ".db3"; }
bool IsBagName(fs::path path) {
  if (path.extension() == ".zstd") path = path.stem();
  return IsMcapName(path) || IsDatabaseName(path) || path.extension() == ".bag";
}

// Folders of rosbag2 have metadata.yaml, or nothing but the bag's files if the
// recording was interrupted.
bool IsBagFolder(const std::string& folder) {
  bool has_bags = false, has_others = false, has_metadata = false;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    has_bags |= IsBagName(entry.path());
    has_others |= !IsBagName(entry.path());
    has_metadata |= entry.path().filename() == kMetadata;
  }
  return has_bags && (has_metadata || !has_others);
}

MessageEncoding ParseMessageEncoding(const std::string& name) {
  return name == "ros1"       ? MessageEncoding::kRos1
         : name == "cdr"      ? MessageEncoding::kCdr
         : name == "protobuf" ? MessageEncoding::kProtobuf
         : name == "json"     ? MessageEncoding::kJson
                              : MessageEncoding::kOther;
}

// "sensor_msgs/msg/Image" is "sensor_msgs/Image" in ROS 1.
std::string TypeWithoutMsg(std::string type) {
  const size_t at = type.find("/msg/");
  return at == std::string::npos ? type : type.replace(at, 5, "/");
}

// A file that is removed when the bag was opened, or the program fails.
class TemporaryFile {
 public:
  TemporaryFile() {
    std::error_code error;
    path_ = (fs::temp_directory_path(error) / "raygrid-bag-XXXXXX").string();
    const int number = error ? -1 : mkstemp(path_.data());
    if (number < 0) ThrowWriteError(path_, error ? error.value() : errno);
    number_ = number;
  }
  ~TemporaryFile() {
    Unlink();
    close(number_);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  // Makes the file anonymous, so that it does not outlive a killed program.
  void Unlink() {
    if (is_linked_) unlink(path_.c_str());
    is_linked_ = false;
  }
  std::string path() const {
    return is_linked_ ? path_ : fmt::format("/proc/self/fd/{}", number_);
  }

 private:
  std::string path_;
  int number_ = -1;
  bool is_linked_ = true;
};

// Throws if the first bytes of a file are not those of a supported bag.
void RequireBag(const std::string& name, const std::string& bytes) {
  for (const char* magic : {kMcapMagic, kRos1Magic, kDatabaseMagic})
    if (HasStart(bytes, magic)) return;
  if (HasStart(bytes, "#ROSBAG V"))
    throw InputError(name +
                     ": a ROS 1 bag of an old version; convert it with "
                     "'rosbag migrate'");
  throw InputError(
      bytes.empty()
          ? name + ": is empty; the recording was interrupted at its start"
          : name + ": not a bag (MCAP, rosbag2 SQLite, ROS 1 version 2.0)");
}

std::unique_ptr<BagFile> OpenByMagic(const std::string& path,
                                     const std::string& name,
                                     const std::string& bytes) {
  RequireBag(name, bytes);
  if (HasStart(bytes, kMcapMagic)) return OpenMcapFile(path, name);
  if (HasStart(bytes, kRos1Magic)) return OpenRos1File(path, name);
  return OpenDatabaseFile(path, name);
}

// The files of a folder, as metadata.yaml lists them.
std::vector<std::string> ReadMetadata(const std::string& folder) {
  const std::string path = (fs::path(folder) / kMetadata).string();
  const std::string text = ReadFile(path);
  RequireSmallTree(path, text);
  return ReadNamingFile(path, [&] {
    const YAML::Node root = YAML::Load(text);
    const YAML::Node information = root["rosbag2_bagfile_information"];
    if (!information || !information.IsMap())
      throw InputError(
          "lacks rosbag2_bagfile_information; not a rosbag2 folder");
    const YAML::Node listed = information["relative_file_paths"];
    if (!listed || !listed.IsSequence() || listed.size() == 0)
      throw InputError("lists no files; the recording is empty");
    std::vector<std::string> files;
    for (const YAML::Node& file : listed)
      files.push_back(
          (fs::path(folder) / fs::path(file.as<std::string>()).filename())
              .string());
    return files;
  });
}

// Returns the message in data of a topic whose messages are compressed one by
// one; corrupt data as they are; they are not decoded either.
std::string DecompressIfPossible(std::string_view data) {
  try {
    return Decompress("zstd", data, kUnknownSize);
  } catch (const InputError&) {
    return std::string(data);
  }
}

}  // namespace

bool Bag::Recognizes(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return IsBagFolder(path);
  if (!fs::is_regular_file(path, error)) return false;
  const std::string bytes = FirstBytes(path);
  return IsBagName(path) || HasStart(bytes, kMcapMagic) ||
         HasStart(bytes, "#ROSBAG V") || HasStart(bytes, kDatabaseMagic);
}

Bag::Bag(const std::string& path) : path_(path) {
  std::error_code error;
  if (fs::is_directory(path, error))
    OpenFolder();
  else
    OpenFile(path);
}

Bag::~Bag() = default;

void Bag::OpenFolder() {
  std::error_code error;
  if (!IsBagFolder(path_)) throw InputError(path_ + ": contains no bag");
  if (!fs::exists(fs::path(path_) / kMetadata, error))
    throw InputError(fmt::format(
        "{}: has no metadata.yaml, which an interrupted recording lacks; pass "
        "its .mcap or .db3 file instead of the folder",
        path_));
  for (const std::string& file : ReadMetadata(path_)) OpenFile(file);
  kind_ = "rosbag2, " + kind_;
}

void Bag::OpenFile(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::is_regular_file(status))
    throw InputError(path + (fs::exists(status)
                                 ? ": is not a file; a bag is read twice"
                                 : ": does not exist; check the name"));
  const RandomAccessFile is_readable(path, path);  // or throws
  std::string bytes = FirstBytes(path);
  std::optional<TemporaryFile> temporary;
  std::string readable = path;
  if (IsZstd(bytes)) {
    temporary.emplace();
    DecompressZstdFile(path, temporary->path(), [&](const std::string& first) {
      RequireBag(path, first);
      // SQLite needs a name to open a file.
      if (!HasStart(first, kDatabaseMagic)) temporary->Unlink();
    });
    readable = temporary->path();
    bytes = FirstBytes(readable);
  }
  files_.push_back(OpenByMagic(readable, path, bytes));
  file_names_.push_back(path);
  kind_ = HasStart(bytes, kMcapMagic)   ? "MCAP"
          : HasStart(bytes, kRos1Magic) ? "ROS 1"
                                        : "SQLite";
}

void Bag::Scan(const std::function<void(const BagMessage&)>& visit,
               const std::function<void(double)>& progress) {
  // Different types may have one name, also by mistake.
  std::map<std::array<std::string, 3>, size_t> index_by_name;
  topics_.clear();
  remarks_.clear();
  size_t file = 0, num_remarks = 0;
  BagVisitor visitor;
  visitor.add_topic = [&](const std::string& name, const std::string& type,
                          const std::string& encoding) {
    const auto [place, is_new] = index_by_name.emplace(
        std::array<std::string, 3>{name, type, encoding}, topics_.size());
    if (is_new && topics_.size() == kMaxTopics)
      throw Error(ExitCode::kInvalidInput,
                  fmt::format("{}: has more than {} topics; it is damaged",
                              path_, kMaxTopics));
    if (is_new)
      topics_.push_back({Printable(name), Printable(TypeWithoutMsg(type)),
                         Printable(encoding), ParseMessageEncoding(encoding)});
    return place->second;
  };
  visitor.visit = [&](BagMessage message) {
    message.place.file = static_cast<uint32_t>(file);
    message.log_ns = std::clamp<int64_t>(message.log_ns, 0, kMaxTimeNs);
    Count(message);
    std::string data;
    if (IsZstd(message.data)) {
      data = DecompressIfPossible(message.data);
      message.data = data;
    }
    if (visit) visit(message);
  };
  visitor.remark = [&](const std::string& remark) {
    if (num_remarks++ < kMaxRemarks) remarks_.push_back(remark);
  };
  visitor.progress = [&](double done) {
    if (progress)
      progress((static_cast<double>(file) + done) /
               static_cast<double>(files_.size()));
  };
  for (; file < files_.size(); ++file) files_[file]->Scan(visitor);
  if (num_remarks > kMaxRemarks)
    remarks_.push_back(fmt::format("{}: {} more remarks like these", path_,
                                   num_remarks - kMaxRemarks));
}

void Bag::Count(const BagMessage& message) {
  BagTopic& topic = topics_[message.topic];
  const bool is_first = topic.num_messages++ == 0;
  topic.num_bytes += message.data.size();
  topic.first_ns =
      is_first ? message.log_ns : std::min(topic.first_ns, message.log_ns);
  topic.last_ns =
      is_first ? message.log_ns : std::max(topic.last_ns, message.log_ns);
}

std::string Bag::Read(const MessagePlace& place) const {
  try {
    std::string data = files_.at(place.file)->Read(place);
    return IsZstd(data) ? DecompressIfPossible(data) : data;
  } catch (const InputError& error) {
    const std::string& name = file_names_[place.file];
    const std::string what = error.what();
    if (what.rfind(name, 0) == 0) throw;
    throw InputError(name + ": " + what);
  }
}

}  // namespace raygrid
