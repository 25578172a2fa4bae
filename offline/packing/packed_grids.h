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
#include "packing/inverse_grid.h"
#include "packing/narrow_grid.h"
#include "packing/unprojection_error.h"
#include "rg_blob.h"

namespace raygrid {

/// The blob with these contents. Throws Error(kQuality) if the format does not
/// hold them.
std::string WriteBlob(const rg_blob_contents& contents);

/// The control points of grids that are alike, of which the first is the blob's
/// own and others are of knots: of 16 bits where all keep the bounds.
class GridPoints {
 public:
  /// Makes contents those of the first grid. truths: of each grid; the grids
  /// are referred to. Control points are of 32 bits where those of 16 are not
  /// allowed, or do not keep the bound.
  GridPoints(const std::vector<GridSection>& grids, bool is_allowed,
             const std::vector<PackingTruth>& truths, double max_error_px,
             int num_threads, rg_blob_contents* contents);
  GridPoints(const GridPoints&) = delete;
  GridPoints& operator=(const GridPoints&) = delete;

  /// The worst of all grids.
  const UnprojectionError& error() const { return error_; }

  /// Makes contents of a blob, or of a knot, those of a grid.
  template <typename Contents>
  void Point(size_t k, Contents* contents) const {
    contents->control_points_q29 = grids_[k].control_points.values.data();
    contents->narrow = narrow_ ? &(*narrow_)[k].section : nullptr;
  }

 private:
  // Measures all; false if the format does not hold one of them.
  bool Measure(const std::vector<PackingTruth>& truths, int num_threads,
               rg_blob_contents* contents);

  const std::vector<GridSection>& grids_;
  std::optional<std::vector<NarrowGrid>> narrow_;
  UnprojectionError error_ = {INFINITY, INFINITY};
};

/// The inverse grids that lead back to the pixels of grids.
class InverseSections {
 public:
  /// Makes the first one that of contents, which has the other sections that
  /// projection needs. surfaces: of each grid. go_on is called now and then,
  /// and may throw.
  InverseSections(const std::vector<const BSplineSurface*>& surfaces,
                  const GridPoints& points, const TrustMask* trusted,
                  int num_threads, const std::function<void()>& go_on,
                  rg_blob_contents* contents);
  InverseSections(const InverseSections&) = delete;
  InverseSections& operator=(const InverseSections&) = delete;

  /// The worst of them; nothing if there are none.
  std::optional<ProjectionError> error() const;

  /// NULL if there are none.
  const rg_narrow_grid* points(size_t k) const {
    return inverses_.empty() ? nullptr : &points_[k];
  }

 private:
  std::vector<MeasuredInverse> inverses_;
  std::vector<rg_narrow_grid> points_;
};

}  // namespace raygrid

#endif  // RAYGRID_PACKING_PACKED_GRIDS_H
