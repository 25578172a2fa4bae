#ifndef RAYGRID_PACKING_BLOB_UNCERTAINTY_H
#define RAYGRID_PACKING_BLOB_UNCERTAINTY_H

#include <cstdint>
#include <string>
#include <vector>

#include "camera/sensor_mode.h"
#include "dataset/camera_file.h"
#include "packing/unprojection_error.h"
#include "rg_blob.h"

namespace raygrid {

/// Sections with a camera's predicted uncertainty, from its file, in the
/// format's integers.
struct UncertaintySections {
  rg_uncertainty_section uncertainty = {};
  rg_mask_section mask = {};
  std::vector<uint16_t> values_q12;
  std::vector<uint8_t> bits;

  /// Adds the mask to contents, and the standard deviations if there are any.
  /// They point to memory owned by this object.
  void AddTo(rg_blob_contents* contents);
};

/// Converts the uncertainty, sampled over the area of the blob's grid.
UncertaintySections QuantizeUncertainty(const CameraUncertainty& known,
                                        const rg_grid_section& grid);

/// Converts the capture settings at calibration to the format's integers.
rg_capture_section QuantizeCapture(const Capture& capture);

/// Returns a zero-padded text of RG_TEXT_SIZE bytes. Throws like
/// RequireBlobText().
std::string FormatPadded(const char* what, const std::string& text);

/// Converts a mode, without its name.
rg_mode_section QuantizeMode(const SensorMode& mode);

/// Converts the line delay to the format's integers.
rg_row_time_section QuantizeLineDelay(const LineDelay& line_delay);

/// Converts the errors of calibration and of packing; rounded up.
rg_quality_section QuantizeQuality(const CameraFile& file,
                                   const UnprojectionError& packing);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_BLOB_UNCERTAINTY_H
