#ifndef RAYGRID_CAMERA_FRAME_NUMBERS_H
#define RAYGRID_CAMERA_FRAME_NUMBERS_H

#include <cstdint>
#include <optional>

namespace raygrid {

/// Numbers of frames that are written: 0 is the first one, and a gap is where
/// the source had frames that are not.
class FrameNumbers {
 public:
  /// sequence  the source's number of the next frame. Those of drivers that do
  ///           not count, or begin again, leave no gap.
  uint64_t Next(uint32_t sequence) {
    if (last_) {
      const uint32_t step = sequence - *last_;
      number_ += step != 0 && step <= INT32_MAX ? step : 1;
    }
    last_ = sequence;
    return number_;
  }

 private:
  std::optional<uint32_t> last_;
  uint64_t number_ = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_FRAME_NUMBERS_H
