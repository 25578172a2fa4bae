/// Blocks of undistorted frames outside the valid region.
#ifndef RAYGRID_LIBCAMERA_INVALID_BLOCKS_H
#define RAYGRID_LIBCAMERA_INVALID_BLOCKS_H

#include <cstdint>
#include <vector>

#include "raygrid.h"
#include "stream_format.h"

namespace raygrid {

/// The blocks of 8 x 8 pixels of the undistorted image that have no valid
/// source pixel (rg_is_valid()).
class InvalidBlocks {
 public:
  /// A table of the camera for frames of this format must be selected.
  /// target: provides the border values
  InvalidBlocks(const rg_camera& camera, const StreamFormat& format,
                const rg_target& target);

  /// Whether all blocks are outside the valid region.
  bool are_all() const { return are_all_; }
  /// Sets the pixels of these blocks to the border values, in a whole frame.
  void FillWithBorder(const rg_target& target) const;

 private:
  // Pixels [x0, x1) of rows [y0, y1).
  struct Run {
    uint32_t x0, x1, y0, y1;
  };

  // validity: 1 or 0 for each pixel of the undistorted image
  bool HasOne(const std::vector<uint8_t>& validity, const Run& block) const;
  void FindRuns(const std::vector<uint8_t>& validity);
  void MakeBorderRows(const rg_target& target);

  const StreamFormat format_;
  std::vector<Run> runs_;  // adjacent blocks, merged
  bool are_all_ = true;
  // Two border rows for each plane: rows of Bayer frames alternate.
  std::vector<uint8_t> border_rows_[3];
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_INVALID_BLOCKS_H
