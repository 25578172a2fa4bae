#include "bags/random_access_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "dataset/error.h"

namespace raygrid {

RandomAccessFile::RandomAccessFile(const std::string& path,
                                   const std::string& name)
    : name_(name) {
  number_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status = {};
  if (number_ < 0 || fstat(number_, &status) != 0)
    throw InputError(
        fmt::format("{}: cannot be read ({}); check name and permissions", name,
                    std::strerror(errno)));
  if (!S_ISREG(status.st_mode)) {
    close(number_);
    throw InputError(name + ": is not a file; a bag is read several times");
  }
  size_ = static_cast<uint64_t>(status.st_size);
}

RandomAccessFile::~RandomAccessFile() { close(number_); }

std::string RandomAccessFile::Read(uint64_t offset, uint64_t count) const {
  std::string bytes;
  if (Contains(offset, count)) bytes.resize(count);
  size_t num_read = 0;
  while (num_read < bytes.size()) {
    const ssize_t more =
        pread(number_, &bytes[num_read], bytes.size() - num_read,
              static_cast<off_t>(offset + num_read));
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) break;
    num_read += static_cast<size_t>(more);
  }
  if (num_read < count)
    throw InputError(fmt::format(
        "{}: {} bytes at byte {} cannot be read; the file was changed, or the "
        "disk is damaged",
        name_, count, offset));
  return bytes;
}

ChunkCache::Chunk ChunkCache::Get(int64_t offset,
                                  const std::function<std::string()>& load) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found =
      std::find_if(chunks_.begin(), chunks_.end(),
                   [&](const auto& chunk) { return chunk.first == offset; });
  if (found != chunks_.end()) {
    chunks_.splice(chunks_.begin(), chunks_, found);
  } else {
    if (chunks_.size() == kMaxChunks) chunks_.pop_back();
    chunks_.emplace_front(offset, std::make_shared<const std::string>(load()));
  }
  return chunks_.front().second;
}

std::string ExtractMessage(const std::string& chunk,
                           const MessagePlace& place) {
  if (place.offset > chunk.size() || place.size > chunk.size() - place.offset)
    throw InputError("the file was changed");
  return chunk.substr(place.offset, place.size);
}

}  // namespace raygrid
