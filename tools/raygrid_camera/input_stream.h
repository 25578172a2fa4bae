#ifndef RAYGRID_CAMERA_INPUT_STREAM_H
#define RAYGRID_CAMERA_INPUT_STREAM_H

#include <cstdint>
#include <functional>
#include <vector>

namespace raygrid {

/// Bytes of a pipe, as they come; whoever waits for them can be stopped.
class InputStream {
 public:
  /// is_stopped  is asked while nothing comes
  InputStream(int fd, std::function<bool()> is_stopped);

  /// The next bytes, at least so many, without taking them: fewer at the end,
  /// or when stopped.
  size_t Await(size_t number);
  /// The bytes that were awaited and not taken.
  const uint8_t* data() const { return bytes_.data() + begin_; }
  void Take(size_t number) { begin_ += number; }
  /// Takes bytes to a place; returns how many came until the end.
  size_t Read(uint8_t* to, size_t number);

 private:
  size_t ReadSome(uint8_t* to, size_t number);
  size_t size() const { return end_ - begin_; }

  const int fd_;
  const std::function<bool()> is_stopped_;
  std::vector<uint8_t> bytes_;
  size_t begin_ = 0, end_ = 0;
  bool is_over_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_INPUT_STREAM_H
