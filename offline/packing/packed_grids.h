#ifndef RAYGRID_PACKING_PACKED_GRIDS_H
#define RAYGRID_PACKING_PACKED_GRIDS_H

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "camera/bspline_surface.h"
#include "camera/camera_uncertainty.h"
#include "packing/blob_grid.h"
#include "packing/int16_grid.h"
#include "packing/inverse_grid.h"
#include "packing/unprojection_error.h"
#include "rg_blob.h"

namespace raygrid {

/// Writes a blob with these contents. Throws Error(kQualityTooLow) if the
/// format cannot represent them.
std::string WriteBlob(const rg_blob_contents& contents);

/// Control points of grids with equal layout, the first in the blob itself and
/// the others in samples: 16 bits if all are within the limits.
class GridPoints {
 public:
  /// Sets the control points of the first grid in contents. truths: one per
  /// grid; the grids must outlive this object. Control points have 32 bits if
  /// 16 are not allowed or exceed the limit.
  GridPoints(const std::vector<GridSection>& grids, bool is_allowed,
             const std::vector<PackingTruth>& truths, double max_error_px,
             int num_threads, rg_blob_contents* contents);
  GridPoints(const GridPoints&) = delete;
  GridPoints& operator=(const GridPoints&) = delete;

  /// Maximum error over all grids.
  const UnprojectionError& error() const { return error_; }

  /// Sets a grid's control points in the contents of a blob or sample.
  template <typename Contents>
  void Point(size_t k, Contents* contents) const {
    contents->control_points_q29 = grids_[k].control_points.values.data();
    contents->narrow = narrow_ ? &(*narrow_)[k].section : nullptr;
  }

 private:
  // Measures all grids; false if the format cannot represent one of them.
  bool Measure(const std::vector<PackingTruth>& truths, int num_threads,
               rg_blob_contents* contents);

  const std::vector<GridSection>& grids_;
  std::optional<std::vector<Int16Grid>> narrow_;
  UnprojectionError error_ = {INFINITY, INFINITY};
};

/// Inverse grids of the blob's grids, for projection.
class InverseSections {
 public:
  /// Sets the first inverse grid in contents, which already have the other
  /// sections needed for projection. surfaces: one per grid. go_on is called
  /// regularly, and may throw.
  InverseSections(const std::vector<const BSplineSurface*>& surfaces,
                  const GridPoints& points, const ValidityMask* valid_region,
                  int num_threads, const std::function<void()>& go_on,
                  rg_blob_contents* contents);
  InverseSections(const InverseSections&) = delete;
  InverseSections& operator=(const InverseSections&) = delete;

  /// Returns the maximum error over all inverse grids; nullopt without any.
  std::optional<ProjectionError> error() const;

  /// Returns NULL without inverse grids.
  const rg_narrow_grid* points(size_t k) const {
    return inverses_.empty() ? nullptr : &points_[k];
  }

 private:
  std::vector<EvaluatedInverseGrid> inverses_;
  std::vector<rg_narrow_grid> points_;
};

}  // namespace raygrid

#endif  // RAYGRID_PACKING_PACKED_GRIDS_H
