#include "invalid_blocks.h"

#include <algorithm>
#include <cstring>

#include "frames/pixel_formats.h"

namespace raygrid {
namespace {

// Pixels; a multiple of the sample groups of every format.
constexpr uint32_t kBlockSize = 8;

// Returns the calibrated position of each column or row of a mode's frames.
std::vector<int32_t> FindPositions(const rg_mode& mode, int axis) {
  std::vector<int32_t> positions_q16;
  const int size = axis == 0 ? mode.width : mode.height;
  for (int k = 0; k < size; ++k) {
    rg_pixel place = {axis == 0 ? RG_PIXEL(k) : 0, axis == 0 ? 0 : RG_PIXEL(k)};
    if (rg_mode_to_calibrated(&mode, place, &place) != RG_OK)
      place = {RG_NO_PIXEL, RG_NO_PIXEL};
    positions_q16.push_back(axis == 0 ? place.x_q16 : place.y_q16);
  }
  return positions_q16;
}

// Returns a grey frame of the mode: 1 where the camera is valid, otherwise 0.
std::vector<uint8_t> MakeValidityFrame(const rg_camera& camera,
                                       const rg_mode& mode) {
  const std::vector<int32_t> columns_q16 = FindPositions(mode, 0);
  std::vector<uint8_t> frame;
  frame.reserve(size_t{mode.width} * mode.height);
  for (const int32_t y_q16 : FindPositions(mode, 1))
    for (const int32_t x_q16 : columns_q16)
      frame.push_back(rg_is_valid(&camera, {x_q16, y_q16}) != 0);
  return frame;
}

// Returns the undistorted validity frame: 1 where sources are valid. The mask's
// cells begin between calibrated pixels, so the nearest pixel is in the cell of
// the source.
std::vector<uint8_t> UndistortValidity(const rg_camera& camera,
                                       const StreamFormat& format) {
  rg_mode mode = {};
  rg_remap_mode(&camera, &mode);
  const std::vector<uint8_t> frame = MakeValidityFrame(camera, mode);
  std::vector<uint8_t> undistorted(size_t{format.width} * format.height);
  rg_image image = {};
  image.format = RG_FORMAT_GREY8;
  image.width = mode.width;
  image.height = mode.height;
  image.planes[0].data = frame.data();
  image.planes[0].stride = mode.width;
  rg_target target = {};
  target.planes[0].data = undistorted.data();
  target.planes[0].stride = format.width;
  target.num_rows = format.height;
  target.sampling = RG_SAMPLING_NEAREST;
  rg_remap(&camera, &image, &target);
  return undistorted;
}

}  // namespace

InvalidBlocks::InvalidBlocks(const rg_camera& camera,
                             const StreamFormat& format,
                             const rg_target& target)
    : format_(format) {
  FindRuns(UndistortValidity(camera, format));
  MakeBorderRows(target);
}

bool InvalidBlocks::HasOne(const std::vector<uint8_t>& validity,
                           const Run& block) const {
  for (uint32_t y = block.y0; y < block.y1; ++y) {
    const auto row = validity.begin() + size_t{y} * format_.width;
    if (std::find(row + block.x0, row + block.x1, 1) != row + block.x1)
      return true;
  }
  return false;
}

void InvalidBlocks::FindRuns(const std::vector<uint8_t>& validity) {
  const uint32_t width = format_.width, height = format_.height;
  for (uint32_t y = 0; y < height; y += kBlockSize) {
    for (uint32_t x = 0; x < width; x += kBlockSize) {
      const Run block = {x, std::min(x + kBlockSize, width), y,
                         std::min(y + kBlockSize, height)};
      if (HasOne(validity, block))
        are_all_ = false;
      else if (!runs_.empty() && runs_.back().y0 == y && runs_.back().x1 == x)
        runs_.back().x1 = block.x1;
      else
        runs_.push_back(block);
    }
  }
}

void InvalidBlocks::MakeBorderRows(const rg_target& target) {
  rg_component component;
  for (uint32_t i = 0;
       rg_get_component(format_.pixel_format->format, i, &component); ++i) {
    const size_t row_bytes = format_.planes[component.plane].row_bytes;
    std::vector<uint8_t>& rows = border_rows_[component.plane];
    rows.resize(2 * row_bytes);
    for (uint32_t y = component.first_row; y < 2; y += component.row_step)
      for (uint32_t x = 0; x < uint32_t{format_.width} >> component.log2[0];
           ++x)
        for (uint32_t c = 0; c < component.num_channels; ++c)
          rg_store_sample(component.kind, &rows[y * row_bytes],
                          rg_first_sample(&component, x) + c,
                          target.border_values[component.index + c]);
  }
}

void InvalidBlocks::FillWithBorder(const rg_target& target) const {
  for (int i = 0; i < format_.num_planes; ++i) {
    const PlaneLayout& plane = format_.planes[i];
    for (const Run& run : runs_) {
      const uint32_t begin = plane.row_bytes * run.x0 / format_.width;
      const uint32_t end = plane.row_bytes * run.x1 / format_.width;
      const uint32_t end_row = plane.rows * run.y1 / format_.height;
      for (uint32_t y = plane.rows * run.y0 / format_.height; y < end_row; ++y)
        std::memcpy(
            target.planes[i].data + size_t{y} * target.planes[i].stride + begin,
            &border_rows_[i][(y & 1) * plane.row_bytes + begin], end - begin);
    }
  }
}

}  // namespace raygrid
