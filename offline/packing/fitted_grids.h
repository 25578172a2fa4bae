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

/// Throws unless the knots are alike, and fit the camera.
void RequireSimilarSamples(const OperatingPointSamples& stack,
                           const CameraModel& camera);

/// A camera and what its grids are fitted to.
struct GridTask {
  const CameraModel& camera;
  const RegularRegion* region;  ///< NULL: the format holds the camera as it is
  const ValidityMask* valid_region;    ///< NULL: all
  const OperatingPointSamples* stack;  ///< NULL: none
  bool is_narrow_allowed = true;
  int num_threads = 0;
};

/// The camera's own grid, and of a stack those of its knots, with which it then
/// has area and size in common.
struct GridsToPack {
  std::vector<CentralGeneric> models;
  std::optional<ValidityMask> valid;  ///< as BlobGrid's, of all of them
  bool follows_all = true;

  const ValidityMask* ValidOr(const ValidityMask* valid_region) const {
    return valid ? &*valid : valid_region;
  }
  void Add(const BlobGrid& grid) {
    models.push_back(grid.grid);
    if (grid.valid) valid = grid.valid;
    follows_all &= grid.follows_all;
  }
};

/// Grids in the format's integers, which keep a bound in the runtime's
/// arithmetic.
class BlobGrids {
 public:
  /// Makes contents those of the first grid. Throws Error(kQuality).
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

/// Grids that follow the camera everywhere to what packing may add, or else as
/// far as is allowed.
std::unique_ptr<BlobGrids> FitBlobGrids(const GridTask& task,
                                        double max_error_px,
                                        rg_blob_contents* contents);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_FITTED_GRIDS_H
