#ifndef RAYGRID_CAPTURE_CAPTURE_JSON_H
#define RAYGRID_CAPTURE_CAPTURE_JSON_H

#include <string>

#include "capture_state.h"

namespace raygrid {

/// Formats a state as one line of JSON (formats/json/capture.schema.json). Non-
/// finite numbers become null; pixels are rounded to a tenth.
std::string CaptureJson(const CaptureState& state);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_JSON_H
