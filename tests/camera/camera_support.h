/// An open camera, and frames, for the tests of the frame pipeline.
#ifndef RAYGRID_TEST_CAMERA_SUPPORT_H
#define RAYGRID_TEST_CAMERA_SUPPORT_H

#include <stdlib.h>

#include <cstdint>
#include <string>
#include <vector>

#include "golden_blobs.h"
#include "raygrid.h"
#include "stream_format.h"

namespace raygrid {

/// The golden lens: 160 x 120 pixels, with a remap table.
inline rg_camera OpenLens() {
  rg_camera camera;
  if (rg_camera_open(&camera, kLensBlob, sizeof(kLensBlob)) != RG_OK ||
      rg_select_remap(&camera, 0) != RG_OK)
    abort();
  return camera;
}

inline StreamFormat LensFormat(const char* name) {
  return MakeStreamFormat(*FindPixelFormat(name), 160, 120, 0);
}

/// Frames that all differ.
inline std::vector<uint8_t> MakeRecording(const StreamFormat& format,
                                          uint32_t num_frames) {
  std::vector<uint8_t> recording(size_t{format.packed_size()} * num_frames);
  uint32_t state = 1;
  for (uint8_t& byte : recording) {
    state = state * 1664525u + 1013904223u;
    byte = static_cast<uint8_t>(state >> 24);
  }
  return recording;
}

}  // namespace raygrid

#endif  // RAYGRID_TEST_CAMERA_SUPPORT_H
