#ifndef RAYGRID_PACKING_BLOB_LIMITS_H
#define RAYGRID_PACKING_BLOB_LIMITS_H

#include <string>

#include "dataset/error.h"

namespace raygrid {

/// Maximum unprojection error that packing may add.
constexpr double kMaxPackingErrorPx = 0.002;
/// Maximum unprojection error that 16-bit control points may add.
constexpr double kMaxInt16ErrorRad = 1e-6;

/// Throws Error(kQualityTooLow): a blob cannot represent the camera. what: the
/// reason.
[[noreturn]] inline void ThrowDoesNotFitBlob(const std::string& what) {
  throw Error(ExitCode::kQualityTooLow,
              "this camera cannot be stored in a blob: " + what);
}

/// Throws Error(kUsage) for a text that a blob cannot store. what: the name of
/// the option or argument, for the message.
void RequireBlobText(const char* what, const std::string& text);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_BLOB_LIMITS_H
