/// Recordings of robots: MCAP, rosbag2 and ROS 1 bags.
#ifndef RAYGRID_BAGS_BAG_H
#define RAYGRID_BAGS_BAG_H

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace raygrid {

/// How the messages of a topic are serialized. kOther: not decoded here.
enum class MessageEncoding { kRos1, kCdr, kProtobuf, kJson, kOther };

struct BagTopic {
  std::string name;           ///< "/cam0/image_raw"
  std::string type;           ///< "sensor_msgs/Image", without "/msg/"
  std::string encoding_name;  ///< as in the file: "cdr", "ros1"
  MessageEncoding encoding = MessageEncoding::kOther;
  // Of the messages read so far. Times are log times in nanoseconds.
  uint64_t num_messages = 0, num_bytes = 0;
  int64_t first_ns = 0, last_ns = 0;
};

/// Where a message is: in a file of the bag, in the chunk at a byte (-1:
/// outside chunks) or in the row of a database.
struct MessagePlace {
  uint32_t file = 0;
  int64_t chunk = -1;
  uint64_t offset = 0, size = 0;
};

struct BagMessage {
  size_t topic = 0;    ///< index of Bag::topics()
  int64_t log_ns = 0;  ///< when the message was recorded
  MessagePlace place;
  std::string_view data;  ///< valid until the next message is read
};

class BagFile;

/// A bag: one file, or a folder with metadata.yaml. Memory is bounded by the
/// largest chunk or message. The size of each file is that at the time of
/// opening: a bag may grow while it is read.
class Bag {
 public:
  /// Opens a bag. Throws InputError if it is unreadable, empty, or of an
  /// unsupported kind or version.
  explicit Bag(const std::string& path);
  ~Bag();

  /// Returns whether a path is meant as a bag, by its first bytes or its name.
  /// The bag may be damaged.
  static bool Recognizes(const std::string& path);

  const std::string& path() const { return path_; }
  /// "MCAP", "rosbag2 (SQLite)", "ROS 1"
  const std::string& kind() const { return kind_; }
  /// The files of the bag.
  const std::vector<std::string>& files() const { return file_names_; }

  /// Reads all messages once, in the order of the files. Damaged parts are
  /// skipped, truncated files read up to the last complete chunk; remarks()
  /// says so. progress: 0 to 1.
  void Scan(const std::function<void(const BagMessage&)>& visit,
            const std::function<void(double)>& progress = {});
  /// Returns the data of a message. Thread-safe. Throws InputError if the file
  /// was changed.
  std::string Read(const MessagePlace& place) const;

  /// After Scan(); those of messages also while scanning.
  const std::vector<BagTopic>& topics() const { return topics_; }
  const std::vector<std::string>& remarks() const { return remarks_; }

 private:
  void OpenFolder();
  void OpenFile(const std::string& path);
  void Count(const BagMessage& message);

  std::string path_, kind_;
  std::vector<std::string> file_names_, remarks_;
  std::vector<std::unique_ptr<BagFile>> files_;
  std::vector<BagTopic> topics_;
};

}  // namespace raygrid

#endif  // RAYGRID_BAGS_BAG_H
