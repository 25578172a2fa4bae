/// Blocks of undistorted frames that show nothing to be trusted.
#ifndef RAYGRID_LIBCAMERA_UNTRUSTED_BLOCKS_H
#define RAYGRID_LIBCAMERA_UNTRUSTED_BLOCKS_H

#include <cstdint>
#include <vector>

#include "raygrid.h"
#include "stream_format.h"

namespace raygrid {

/// The blocks of 8 x 8 pixels of the undistorted image in which no pixel's
/// source is valid, by rg_is_valid().
class UntrustedBlocks {
 public:
  /// A table of the camera is in use, and its frames have the format.
  ///
  /// target  with the values of the border
  UntrustedBlocks(const rg_camera& camera, const StreamFormat& format,
                  const rg_target& target);

  /// There is no other block.
  bool are_all() const { return are_all_; }
  /// Gives their pixels the values of the border, in a whole frame.
  void FillWithBorder(const rg_target& target) const;

 private:
  // Pixels [x0, x1) of rows [y0, y1).
  struct Run {
    uint32_t x0, x1, y0, y1;
  };

  // validity: of the undistorted image's pixels, 1 or 0.
  bool HasOne(const std::vector<uint8_t>& validity, const Run& block) const;
  void FindRuns(const std::vector<uint8_t>& validity);
  void MakeBorderRows(const rg_target& target);

  const StreamFormat format_;
  std::vector<Run> runs_;  // blocks beside each other
  bool are_all_ = true;
  // Two rows of border of each plane: Bayer frames have two kinds of rows.
  std::vector<uint8_t> border_rows_[3];
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_UNTRUSTED_BLOCKS_H
