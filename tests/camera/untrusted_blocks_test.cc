#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>

#include "blob_layout.h"
#include "camera_support.h"
#include "invalid_blocks.h"
#include "rg_blob.h"

namespace raygrid {
namespace {

using BorderValues = std::array<uint16_t, 4>;

void SetBit(uint8_t* bits, uint32_t index, bool value) {
  bits[index / 8] = static_cast<uint8_t>((bits[index / 8] & ~(1 << index % 8)) |
                                         value << index % 8);
}

// The golden wide camera and its first remap table, which tests change after
// the check of the CRCs.
class WideCamera {
 public:
  WideCamera() : bytes_(std::begin(kWideBlob), std::end(kWideBlob)) {
    if (rg_camera_open(&camera_, bytes_.data(), sizeof(kWideBlob)) != RG_OK)
      abort();
    Select();
  }
  WideCamera(const WideCamera&) = delete;
  WideCamera& operator=(const WideCamera&) = delete;

  // Cells of the mask: 32 x 32 pixels of the image, 10 x 8 of them.
  void SetMask(const std::function<bool(uint32_t x, uint32_t y)>& is_valid) {
    uint8_t* const section = Section(RG_SECTION_MASK);
    uint8_t* const bits = section + section[RG_MASK_DATA_OFFSET];
    for (uint32_t k = 0; k < 80; ++k) SetBit(bits, k, is_valid(k % 10, k / 10));
  }

  // Cuts the view, so that the last blocks are not whole.
  void SetSize(uint8_t width, uint8_t height) {
    uint8_t* const section = Section(RG_SECTION_REMAP);
    section[RG_REMAP_WIDTH] = width;
    section[RG_REMAP_HEIGHT] = height;
    Select();
  }

  // Leaves blocks of the table, of 8 x 8 pixels, without a source.
  void SetEmptyBlocks(const std::vector<bool>& blocks) {
    rg_remap_section table;
    rg_read_remap(Section(RG_SECTION_REMAP), &table);
    uint8_t* const bits = bytes_.data() + (table.empty_blocks - bytes_.data());
    for (uint32_t k = 0; k < blocks.size(); ++k)
      if (blocks[k]) SetBit(bits, k, true);
    Select();
  }

  const rg_camera& camera() const { return camera_; }

 private:
  uint8_t* Section(uint32_t type) {
    return bytes_.data() +
           (rg_find_section(bytes_.data(), type, 0) - bytes_.data());
  }
  void Select() {
    if (rg_select_remap(&camera_, 0) != RG_OK) abort();
  }

  std::vector<uint8_t> bytes_;
  rg_camera camera_;
};

// A whole frame that the runtime makes.
struct Output {
  StreamFormat format;
  std::vector<uint8_t> bytes;
  rg_target target;
};

Output Undistort(const rg_camera& camera, const PixelFormatInfo& pixel_format,
                 const uint8_t* frame, const BorderValues& border) {
  const StreamFormat source = MakeStreamFormat(pixel_format, 320, 240, 0);
  Output output = {};
  uint16_t width, height;
  rg_remap_size(&camera, &width, &height);
  output.format = MakeStreamFormat(pixel_format, width, height, 0);
  output.bytes.resize(output.format.packed_size());
  const uint8_t* planes[3] = {};
  uint8_t* out = output.bytes.data();
  for (int i = 0; i < source.num_planes; ++i) {
    planes[i] = frame;
    frame += source.planes[i].row_bytes * source.planes[i].rows;
    output.target.planes[i].data = out;
    output.target.planes[i].stride = output.format.planes[i].stride;
    out += output.format.planes[i].row_bytes * output.format.planes[i].rows;
  }
  output.target.num_rows = height;
  std::copy(border.begin(), border.end(), output.target.border_values);
  const rg_image image = MakeImage(source, planes);
  EXPECT_EQ(rg_remap(&camera, &image, &output.target), RG_OK);
  return output;
}

// The frame of camera_support.h, undistorted, with another value of the border
// for each channel; all fit the fields of RGB565.
Output UndistortRecording(const rg_camera& camera, const std::string& name) {
  const PixelFormatInfo& info = *FindPixelFormat(name);
  const std::vector<uint8_t> frame =
      MakeRecording(MakeStreamFormat(info, 320, 240, 0), 1);
  return Undistort(camera, info, frame.data(), {11, 50, 29, 7});
}

// A coordinate of each undistorted pixel's source in q7: a frame that holds its
// own coordinates, undistorted. INT32_MIN without a source.
std::vector<int32_t> SourceCoordinates(const rg_camera& camera, bool is_x) {
  constexpr uint16_t kNone = 0xffff;
  std::vector<uint8_t> frame;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const int q7 = 128 * (is_x ? x : y);
      frame.push_back(static_cast<uint8_t>(q7));
      frame.push_back(static_cast<uint8_t>(q7 >> 8));
    }
  }
  const Output output = Undistort(camera, *FindPixelFormat("R16"), frame.data(),
                                  {kNone, 0, 0, 0});
  std::vector<int32_t> coordinates;
  for (size_t k = 0; k < output.bytes.size(); k += 2) {
    const int q7 = output.bytes[k] | output.bytes[k + 1] << 8;
    coordinates.push_back(q7 == kNone ? INT32_MIN : q7);
  }
  return coordinates;
}

// Whether each block has no pixel with a valid source.
std::vector<bool> FindUntrusted(const rg_camera& camera) {
  uint16_t width, height;
  rg_remap_size(&camera, &width, &height);
  const std::vector<int32_t> x_q7 = SourceCoordinates(camera, true);
  const std::vector<int32_t> y_q7 = SourceCoordinates(camera, false);
  const size_t columns = (width + 7) / 8;
  std::vector<bool> blocks(columns * ((height + 7) / 8), true);
  for (size_t k = 0; k < x_q7.size(); ++k) {
    if (x_q7[k] == INT32_MIN) continue;
    const rg_pixel source = {x_q7[k] * 512, y_q7[k] * 512};
    if (rg_is_valid(&camera, source))
      blocks[k / width / 8 * columns + k % width / 8] = false;
  }
  return blocks;
}

// Frames of every format in which InvalidBlocks became border.
std::vector<Output> HideInvalidBlocks(const rg_camera& camera) {
  std::vector<Output> outputs;
  for (const PixelFormatInfo& format : PixelFormats()) {
    outputs.push_back(UndistortRecording(camera, format.name));
    const Output& output = outputs.back();
    const InvalidBlocks blocks(camera, output.format, output.target);
    EXPECT_FALSE(blocks.are_all());
    blocks.FillWithBorder(output.target);
  }
  return outputs;
}

void ExpectFramesOfATableThatLeavesThemOut(WideCamera* wide) {
  const std::vector<bool> untrusted = FindUntrusted(wide->camera());
  EXPECT_GE(std::count(untrusted.begin(), untrusted.end(), true), 3);
  EXPECT_GE(std::count(untrusted.begin(), untrusted.end(), false), 3);
  const std::vector<Output> outputs = HideInvalidBlocks(wide->camera());
  wide->SetEmptyBlocks(untrusted);
  for (const Output& output : outputs) {
    const std::string name = output.format.pixel_format->name;
    EXPECT_EQ(output.bytes, UndistortRecording(wide->camera(), name).bytes)
        << name;
  }
}

TEST(InvalidBlocks, BecomeBorderAsByATableThatLeavesThemOut) {
  WideCamera wide;
  wide.SetMask([](uint32_t x, uint32_t y) { return x == 5 && y > 2; });
  ExpectFramesOfATableThatLeavesThemOut(&wide);
}

TEST(InvalidBlocks, AtTheEndOfRowsAreNotWhole) {
  WideCamera wide;
  wide.SetSize(44, 34);
  wide.SetMask([](uint32_t x, uint32_t y) { return x < 5 && y < 4; });
  ExpectFramesOfATableThatLeavesThemOut(&wide);
}

TEST(InvalidBlocks, AreAllWhereNothingIsTrusted) {
  WideCamera wide;
  wide.SetMask([](uint32_t, uint32_t) { return false; });
  const StreamFormat format =
      MakeStreamFormat(*FindPixelFormat("NV12"), 48, 36, 0);
  EXPECT_TRUE(InvalidBlocks(wide.camera(), format, {}).are_all());
}

}  // namespace
}  // namespace raygrid
