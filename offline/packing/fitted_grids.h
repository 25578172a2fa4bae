#ifndef RAYGRID_PACKING_FITTED_GRIDS_H
#define RAYGRID_PACKING_FITTED_GRIDS_H

#include <memory>
#include <optional>
#include <vector>

#include "packing/blob_grid.h"
#include "packing/pack.h"
#include "packing/packed_grids.h"
#include "packing/regular_region.h"
#include "packing/unprojection_error.h"

namespace raygrid {

/// Throws unless the samples are valid: central cameras with equal grids and
/// the image size of `camera`, at ascending operating points.
void RequireSimilarSamples(const OperatingPointSamples& stack,
                           const CameraModel& camera);

/// A camera, and the constraints on the grids that are fitted to it.
struct GridTask {
  const CameraModel& camera;
  const RegularRegion* region;         ///< NULL: the format is exact
  const ValidityMask* valid_region;    ///< NULL: all pixels are valid
  const OperatingPointSamples* stack;  ///< NULL: no samples
  bool is_int16_allowed = true;
  int num_threads = 0;
};

/// The grid of a camera, followed by those of its operating-point samples, if
/// any, which have the same area and size.
struct GridsToPack {
  std::vector<CentralGeneric> models;
  std::optional<ValidityMask> valid;  ///< as BlobGrid::valid, for all grids
  bool is_reproduced_everywhere = true;

  const ValidityMask* ValidOr(const ValidityMask* valid_region) const {
    return valid ? &*valid : valid_region;
  }
  void Add(const BlobGrid& grid) {
    models.push_back(grid.grid);
    if (grid.valid) valid = grid.valid;
    is_reproduced_everywhere &= grid.is_reproduced_everywhere;
  }
};

/// Grids quantized to the blob's integers such that the error of the
/// fixed-point runtime stays below a limit.
class BlobGrids {
 public:
  /// Fits and quantizes the grids, and stores the section of the first grid in
  /// *contents. Throws Error(kQualityTooLow).
  BlobGrids(const GridTask& task, double max_error_px,
            rg_blob_contents* contents);
  BlobGrids(const BlobGrids&) = delete;
  BlobGrids& operator=(const BlobGrids&) = delete;

  const rg_grid_section& section() const { return sections_[0].section; }
  std::vector<const BSplineSurface*> Surfaces() const;

  GridsToPack made;
  std::optional<GridPoints> points;

 private:
  std::vector<PackingTruth> Truths(const GridTask& task) const;

  std::vector<GridSection> sections_;
};

/// Fits grids with the error limit kMaxPackingErrorPx, or with a larger
/// max_error_px if some regular pixels cannot reach that limit.
std::unique_ptr<BlobGrids> FitBlobGrids(const GridTask& task,
                                        double max_error_px,
                                        rg_blob_contents* contents);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_FITTED_GRIDS_H
