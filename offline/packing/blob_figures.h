#ifndef RAYGRID_PACKING_BLOB_FIGURES_H
#define RAYGRID_PACKING_BLOB_FIGURES_H

#include <cstdint>
#include <vector>

#include "dataset/camera_file.h"
#include "packing/unprojection_error.h"
#include "rg_blob.h"

namespace raygrid {

/// The sections that say how well a camera is known, from its file, in the
/// format's integers.
struct UncertaintySections {
  rg_uncertainty_section uncertainty = {};
  rg_mask_section mask = {};
  std::vector<uint16_t> values_q12;
  std::vector<uint8_t> bits;

  /// Adds the mask to contents, and the deviations if there are any. They point
  /// to memory that lives as long as this.
  void AddTo(rg_blob_contents* contents);
};

/// known: over the area of the blob's grid.
UncertaintySections QuantizeUncertainty(const CameraUncertainty& known,
                                        const rg_grid_section& grid);

/// How the camera stood while it was calibrated, in the format's integers.
rg_capture_section QuantizeCapture(const Capture& capture);

/// The time of a row in the format's integers.
rg_row_time_section QuantizeRowTime(const RowTime& row_time);

/// The errors of calibration, as the file has them, and of packing; rounded up.
rg_quality_section QualityOf(const CameraFile& file,
                             const UnprojectionError& packing);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_BLOB_FIGURES_H
