#ifndef RAYGRID_CAPTURE_CAPTURE_JSON_H
#define RAYGRID_CAPTURE_CAPTURE_JSON_H

#include <string>

#include "capture_state.h"

namespace raygrid {

/// A state as one line of JSON, by formats/json/capture.schema.json. Numbers
/// that are none become null; pixels are rounded to a tenth.
std::string CaptureJson(const CaptureState& state);

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_JSON_H
