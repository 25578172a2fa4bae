/// Readers of the kinds of files of which bags consist.
#ifndef RAYGRID_BAGS_BAG_FILE_H
#define RAYGRID_BAGS_BAG_FILE_H

#include <functional>
#include <memory>
#include <string>

#include "bags/bag.h"

namespace raygrid {

/// Receives what a file contains, in the file's order.
struct BagVisitor {
  /// Returns the index of a topic, which a channel or connection declares. Type
  /// and encoding are as in the file.
  std::function<size_t(const std::string& name, const std::string& type,
                       const std::string& encoding)>
      add_topic;
  std::function<void(const BagMessage&)> visit;
  std::function<void(const std::string&)> remark;
  std::function<void(double)> progress;
};

class BagFile {
 public:
  virtual ~BagFile() = default;
  virtual void Scan(const BagVisitor& visitor) = 0;
  /// Thread-safe. Throws InputError.
  virtual std::string Read(const MessagePlace& place) const = 0;
};

// Throw InputError if the file is not readable; name: used in errors.
std::unique_ptr<BagFile> OpenMcapFile(const std::string& path,
                                      const std::string& name);
std::unique_ptr<BagFile> OpenRos1File(const std::string& path,
                                      const std::string& name);
std::unique_ptr<BagFile> OpenDatabaseFile(const std::string& path,
                                          const std::string& name);

/// The first bytes of these kinds.
constexpr char kMcapMagic[] = "\x89MCAP0\r\n", kRos1Magic[] = "#ROSBAG V2.0\n",
               kDatabaseMagic[] = "SQLite format 3";

}  // namespace raygrid

#endif  // RAYGRID_BAGS_BAG_FILE_H
