#ifndef RAYGRID_CAMERA_FRAME_NUMBERS_H
#define RAYGRID_CAMERA_FRAME_NUMBERS_H

#include <cstdint>
#include <optional>

namespace raygrid {

/// Numbers of output frames: the first is 0, and frames of the source that are
/// not output leave a gap.
class FrameNumbers {
 public:
  /// sequence  number of the next frame in the source. Drivers that do not
  ///           count frames, or restart counting, cause no gap.
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
