#ifndef RAYGRID_CAMERA_INPUT_STREAM_H
#define RAYGRID_CAMERA_INPUT_STREAM_H

#include <cstdint>
#include <functional>
#include <vector>

namespace raygrid {

/// Buffered bytes of a pipe; waiting for them can be interrupted.
class InputStream {
 public:
  /// is_stopped  polled while waiting
  InputStream(int fd, std::function<bool()> is_stopped);

  /// Waits for at least `number` bytes without consuming them. Returns the
  /// number available, which is smaller at the end, or when stopped.
  size_t Await(size_t number);
  /// Available bytes that were not consumed.
  const uint8_t* data() const { return bytes_.data() + begin_; }
  void Take(size_t number) { begin_ += number; }
  /// Reads and consumes bytes. Returns their number, smaller at the end.
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
