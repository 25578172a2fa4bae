#ifndef RAYGRID_CAPTURE_CAPTURE_JSON_H
#define RAYGRID_CAPTURE_CAPTURE_JSON_H

#include <string>

#include "capture_state.h"

namespace raygrid {

/// A state as one line of JSON. Numbers that are none become null; pixels are
/// rounded to a tenth. Its keys:
///
///   width, height, camera, word, hint, is_done, is_paused, deviation_px,
///   deviation_is_floor, target_px, kept, num_expected, sharpness_px,
///   brightness, frames_per_second, remarks   the fields of the state cameras
///   [{"name", "word", "deviation_px"}] of a rig; else [] links [{"cameras":
///   [FIRST, SECOND], "deviation_px"}] features   [x, y, x, y, ...] next
///   [{"outline": [x, y, ...], "top": [x, y, ...]}] arrow      [x, y, x, y] or
///   [] places     [x, y, deviation_px, ...]
std::string CaptureJson(const CaptureState& state);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_JSON_H
