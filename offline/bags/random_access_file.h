#ifndef RAYGRID_BAGS_RANDOM_ACCESS_FILE_H
#define RAYGRID_BAGS_RANDOM_ACCESS_FILE_H

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "bags/bag.h"

namespace raygrid {

/// A file of the size that it had when it was opened.
class RandomAccessFile {
 public:
  /// name: used in errors. Throws InputError.
  RandomAccessFile(const std::string& path, const std::string& name);
  ~RandomAccessFile();
  RandomAccessFile(const RandomAccessFile&) = delete;
  RandomAccessFile& operator=(const RandomAccessFile&) = delete;

  const std::string& name() const { return name_; }
  uint64_t size() const { return size_; }
  bool Contains(uint64_t offset, uint64_t count) const {
    return offset <= size_ && count <= size_ - offset;
  }
  /// Throws InputError outside the file, also if it has been truncated.
  std::string Read(uint64_t offset, uint64_t count) const;

 private:
  std::string name_;
  int number_ = -1;
  uint64_t size_ = 0;
};

/// Keeps the chunks read last. Thread-safe; chunks are loaded one at a time, so
/// that threads that need the same one do not load it twice.
class ChunkCache {
 public:
  using Chunk = std::shared_ptr<const std::string>;
  Chunk Get(int64_t offset, const std::function<std::string()>& load);

 private:
  static constexpr size_t kMaxChunks = 4;
  std::mutex mutex_;
  std::list<std::pair<int64_t, Chunk>> chunks_;  // the last used first
};

/// Returns a message in a chunk. Throws InputError outside it.
std::string ExtractMessage(const std::string& chunk, const MessagePlace& place);

}  // namespace raygrid

#endif  // RAYGRID_BAGS_RANDOM_ACCESS_FILE_H
