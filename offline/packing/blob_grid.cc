#include "packing/blob_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "camera/stereographic.h"
#include "dataset/error.h"
#include "packing/blob_limits.h"

namespace raygrid {
namespace {

int32_t Q16(double value) {
  return static_cast<int32_t>(std::lround(value * 65536));
}

// Returns the largest area within camera's that the format can represent.
Area RepresentableArea(const Area& area) {
  constexpr double kUnit = 65536;
  return {
      std::ceil(area.x0 * kUnit) / kUnit, std::ceil(area.y0 * kUnit) / kUnit,
      std::floor(area.x1 * kUnit) / kUnit, std::floor(area.y1 * kUnit) / kUnit};
}

// Returns the largest coordinate of a control point.
double MaxControlPoint() {
  return std::ldexp(RG_CONTROL_POINT_LIMIT - 1.0, -RG_CONTROL_POINT_BITS);
}

// Returns the control points that affect the rays of regular pixels.
std::vector<bool> UsedControlPoints(const BSplineSurface& surface,
                                    const RegularRegion& region) {
  std::vector<bool> is_used(surface.num_points(), false);
  for (size_t k = 0; k < region.nodes().size(); ++k) {
    if (!region.nodes()[k].is_regular) continue;
    const SplineSupport support =
        surface.Support(region.GetPixel(static_cast<int>(k)));
    for (int m = 0; m < 16; ++m)
      is_used[(support.row + m / 4) * surface.columns() + support.column +
              m % 4] = true;
  }
  return is_used;
}

// Moves control points into the format's range, and those that affect no
// regular pixels close to the others, so that 16 bits have a finer resolution.
// Both occur outside a fisheye's image circle.
void MoveIntoRange(const RegularRegion& region, bool is_fitted,
                   BSplineSurface* surface) {
  constexpr double kNear = 1.25;
  double reach = 0;
  for (const RegularRegion::Node& node : region.nodes())
    if (node.is_regular) reach = std::max(reach, ToChart(node.ray).norm());
  const double limit = MaxControlPoint();
  const double others_limit =
      is_fitted ? std::min(limit, kNear * reach) : limit;
  const std::vector<bool> is_used = UsedControlPoints(*surface, region);
  for (int k = 0; k < surface->num_points(); ++k) {
    Eigen::Vector2d& point = surface->points()[k];
    const double largest = point.cwiseAbs().maxCoeff();
    const double allowed = is_used[k] ? limit : others_limit;
    if (!std::isfinite(largest))
      point.setZero();
    else if (largest > allowed)
      point *= allowed / largest;
  }
}

// Searches for a grid that fits a camera in its regular region.
class GridSearch {
 public:
  GridSearch(const CameraModel& camera, const RegularRegion& region,
             const ValidityMask* valid_region, double max_error_px)
      : camera_(camera), region_(region), max_error_px_(max_error_px) {
    double min_px_per_radian = INFINITY;
    for (const RegularRegion::Node& node : region.nodes())
      if (node.is_regular && !node.J_ray.isZero(0))
        min_px_per_radian = std::min(min_px_per_radian, node.J_ray.norm());
    min_px_per_radian *= kNegligibleRotation;
    for (size_t k = 0; k < region.nodes().size(); ++k) {
      const RegularRegion::Node& node = region.nodes()[k];
      const bool counts =
          node.is_regular && node.J_ray.norm() < min_px_per_radian &&
          (!valid_region ||
           valid_region->IsValidAt(region.GetPixel(static_cast<int>(k))));
      counts_.push_back(counts);
      num_counting_ += counts;
    }
  }

  // Returns whether the fit error is within the limit at each relevant node.
  std::vector<bool> FindReproducedNodes(const BSplineSurface& surface) const {
    std::vector<bool> is_reproduced(counts_.size(), true);
    for (size_t k = 0; k < counts_.size(); ++k) {
      if (!counts_[k]) continue;
      const RegularRegion::Node& node = region_.nodes()[k];
      const Eigen::Vector3d ray =
          FromChart(surface.Evaluate(region_.GetPixel(static_cast<int>(k))));
      is_reproduced[k] =
          (node.J_ray * (ray - node.ray)).norm() <= max_error_px_;
    }
    return is_reproduced;
  }

  // Returns the fraction of relevant nodes at which the fit error exceeds the
  // limit.
  double ComputeLostFraction(const std::vector<bool>& is_reproduced) const {
    const auto num_unreproduced =
        std::count(is_reproduced.begin(), is_reproduced.end(), false);
    return num_counting_ == 0 ? 1
                              : static_cast<double>(num_unreproduced) /
                                    static_cast<double>(num_counting_);
  }

  bool HasLargeLoss(const BSplineSurface& surface) const {
    return ComputeLostFraction(FindReproducedNodes(surface)) >
           kNegligibleFraction;
  }

  // Returns the coarsest grid that fits everywhere; otherwise the coarsest one
  // that loses almost the minimum number of nodes.
  BSplineSurface Find() const {
    std::vector<Candidate> candidates;
    double least = INFINITY;
    const Area area = RepresentableArea(region_.area());
    const double longer = std::max(area.width(), area.height());
    for (int half_log2 = 2; half_log2 <= kFinestHalfLog2; ++half_log2) {
      const double knot_spacing_px = longer / std::exp2(half_log2 / 2.0);
      if (half_log2 > kUsualHalfLog2 &&
          (knot_spacing_px < kMinKnotSpacingPx || least <= kRoughFraction ||
           region_.Part() < kMinRegularFraction))
        break;
      candidates.push_back(FitTrimmed(area, knot_spacing_px));
      least = std::min(least, candidates.back().lost);
      if (least <= (region_.IsWhole() ? 0 : kNegligibleFraction))
        return candidates.back().surface;
    }
    const double enough = std::max(kNegligibleFraction, kMaxRatioToMin * least);
    return std::find_if(
               candidates.begin(), candidates.end(),
               [&](const Candidate& each) { return each.lost <= enough; })
        ->surface;
  }

 private:
  // 2 to 128 cells; more for cameras that are hard to fit, with a knot spacing
  // of at least 4 px. Near a fold, a finer grid would gain a few pixels for
  // four times the size.
  static constexpr int kUsualHalfLog2 = 14, kFinestHalfLog2 = 16;
  static constexpr double kMinKnotSpacingPx = 4, kRoughFraction = 0.01;
  static constexpr double kMinRegularFraction = 0.999;
  static constexpr double kNegligibleFraction = 0.002, kMaxRatioToMin = 1.25;
  // Rays that hardly change between pixels are ignored, since their errors in
  // pixels are ill-conditioned.
  static constexpr double kNegligibleRotation = 20;
  static constexpr int kSamplesPerCell = 4;
  // Regularization that extrapolates the grid smoothly outside the region.
  static constexpr double kExtrapolationSmoothness = 1e-7;

  struct Candidate {
    BSplineSurface surface;
    double lost = 1;
  };

  // Fits a grid to the rays of the regular pixels that a previous one fitted.
  BSplineSurface Fit(const Area& area, double knot_spacing_px,
                     const std::vector<bool>& is_good) const {
    const int columns = NumControlPoints(area.width(), knot_spacing_px),
              rows = NumControlPoints(area.height(), knot_spacing_px);
    const BSplineSurface grid(area, columns, rows);
    std::vector<SurfaceSample> samples;
    bool is_whole = true;
    for (const Eigen::Vector2d& pixel : grid.SamplePixels(kSamplesPerCell)) {
      const auto ray = region_.ContainsAmong(is_good, pixel)
                           ? camera_.Unproject(pixel)
                           : std::nullopt;
      if (ray)
        samples.push_back({pixel, ToChart(*ray)});
      else
        is_whole = false;
    }
    BSplineSurface surface = is_whole ? FitSurface(area, columns, rows, samples)
                                      : FitSurface(area, columns, rows, samples,
                                                   kExtrapolationSmoothness);
    MoveIntoRange(region_, true, &surface);
    return surface;
  }

  // Rays that cannot be fitted, for example near a fold, distort the grid next
  // to them: the grid is fitted again without them.
  Candidate FitTrimmed(const Area& area, double knot_spacing_px) const {
    Candidate best;
    std::vector<bool> is_good(counts_.size(), true);
    for (int round = 0; round < 2 && best.lost > kNegligibleFraction; ++round) {
      Candidate made = {Fit(area, knot_spacing_px, is_good)};
      const std::vector<bool> is_reproduced = FindReproducedNodes(made.surface);
      made.lost = ComputeLostFraction(is_reproduced);
      if (round == 0 || made.lost < best.lost) best = std::move(made);
      is_good = is_reproduced;
    }
    return best;
  }

  const CameraModel& camera_;
  const RegularRegion& region_;
  const double max_error_px_;
  std::vector<bool> counts_;
  int64_t num_counting_ = 0;
};

// Returns a valid mask with half the usual cell size, since the boundary of the
// regular region is precise.
ValidityMask FineMask(const ImageSize& size) {
  constexpr int kMinKnotSpacingPx = 4;
  ValidityMask mask = ValidityMask::Over(size);
  mask.knot_spacing_px = std::max(kMinKnotSpacingPx, mask.knot_spacing_px / 2);
  mask.columns = ValidityMask::NumCells(size.width, mask.knot_spacing_px);
  mask.rows = ValidityMask::NumCells(size.height, mask.knot_spacing_px);
  mask.is_valid.assign(mask.columns * mask.rows, true);
  return mask;
}

// Invalidates the cells that overlap an area.
void ExcludeCells(const Area& area, ValidityMask* mask) {
  const int first = mask->CellIndex({area.x0, area.y0}),
            last = mask->CellIndex({area.x1, area.y1});
  for (int j = first / mask->columns; j <= last / mask->columns; ++j)
    for (int i = first % mask->columns; i <= last % mask->columns; ++i)
      mask->is_valid[j * mask->columns + i] = false;
}

}  // namespace

bool IsBlobGrid(const CameraModel& camera) {
  const BSplineSurface* grid = camera.DirectionGrid();
  if (!grid || !camera.IsCentral() ||
      !(RepresentableArea(camera.area()) == camera.area()))
    return false;
  const std::vector<Eigen::Vector2d>& points = grid->points();
  return std::all_of(points.begin(), points.end(),
                     [](const Eigen::Vector2d& point) {
                       return point.cwiseAbs().maxCoeff() <= MaxControlPoint();
                     });
}

BlobGrid MakeBlobGrid(const CameraModel& camera, const RegularRegion* region,
                      const ValidityMask* valid_region, double max_error_px) {
  if (!region) return {MakeCentral(camera), std::nullopt, true};
  const GridSearch search(camera, *region, valid_region, max_error_px / 2);
  BSplineSurface surface;
  const BSplineSurface* own = camera.DirectionGrid();
  if (own && RepresentableArea(camera.area()) == camera.area()) {
    surface = *own;
    MoveIntoRange(*region, false, &surface);
  }
  // With a wide knot spacing, clamped control points distort most of the image.
  if (surface.num_points() == 0 || search.HasLargeLoss(surface)) {
    BSplineSurface fitted = search.Find();
    if (surface.num_points() == 0 ||
        search.ComputeLostFraction(search.FindReproducedNodes(fitted)) <
            search.ComputeLostFraction(search.FindReproducedNodes(surface)))
      surface = std::move(fitted);
  }
  const std::vector<bool> is_reproduced = search.FindReproducedNodes(surface);
  BlobGrid made = {CentralGeneric(camera.image_size(), surface), std::nullopt,
                   true};
  made.is_reproduced_everywhere =
      search.ComputeLostFraction(is_reproduced) == 0;
  ValidityMask valid =
      valid_region ? *valid_region : FineMask(camera.image_size());
  const std::vector<bool> before = valid.is_valid;
  region->ForEachIrregularCell(
      is_reproduced, [&](const Area& cell) { ExcludeCells(cell, &valid); });
  if (valid.is_valid != before) made.valid = valid;
  if (!valid.HasValidCells())
    throw Error(
        ExitCode::kQualityTooLow,
        fmt::format(
            "no part of this {} camera can be represented by a grid within {} "
            "px; check that its parameters match the model and image size",
            camera.Name(), max_error_px));
  return made;
}

GridSection QuantizeGrid(const CentralGeneric& camera) {
  GridSection grid;
  rg_grid_section& s = grid.section;
  const Area& area = camera.area();
  s.x0_q16 = Q16(area.x0);
  s.y0_q16 = Q16(area.y0);
  s.x1_q16 = Q16(area.x1);
  s.y1_q16 = Q16(area.y1);
  s.columns = static_cast<uint16_t>(camera.surface().columns());
  s.rows = static_cast<uint16_t>(camera.surface().rows());
  grid.control_points.columns = s.columns;
  grid.control_points.rows = s.rows;
  if (camera.surface().cell_width() <= 1.01 ||
      camera.surface().cell_height() <= 1.01)
    ThrowDoesNotFitBlob(
        "its knot spacing must be greater than 1 px; calibrate with a larger "
        "--knot-spacing-px");
  s.scale_x_q32 = rg_grid_scale_q32(s.columns - 3u, s.x1_q16 - s.x0_q16);
  s.scale_y_q32 = rg_grid_scale_q32(s.rows - 3u, s.y1_q16 - s.y0_q16);
  for (const Eigen::Vector2d& point : camera.surface().points()) {
    for (int c = 0; c < 2; ++c)
      grid.control_points.values.push_back(static_cast<int32_t>(
          std::lround(std::ldexp(point[c], RG_CONTROL_POINT_BITS))));
  }
  return grid;
}

std::vector<int32_t> QuantizeLinePoints(const NonCentralGeneric& camera,
                                        const BSplineSurface& grid) {
  const BSplineSurface& own = camera.directions();
  const bool is_same =
      own.columns() == grid.columns() && own.rows() == grid.rows() &&
      own.area().x0 == grid.area().x0 && own.area().y0 == grid.area().y0 &&
      own.area().x1 == grid.area().x1 && own.area().y1 == grid.area().y1;
  const std::vector<Eigen::Vector3d> points =
      is_same ? camera.points()
              : FitNonCentralGeneric(camera, grid.area(), grid.columns(),
                                     grid.rows())
                    .points();
  std::vector<int32_t> quantized;
  for (const Eigen::Vector3d& point : points) {
    for (int c = 0; c < 3; ++c) {
      const double value = std::ldexp(point[c], RG_LINE_POINT_BITS);
      if (!(std::abs(value) <= RG_LINE_POINT_LIMIT))
        ThrowDoesNotFitBlob(
            "some ray origins are more than 7.9 m from the centre of the "
            "camera");
      quantized.push_back(static_cast<int32_t>(std::lround(value)));
    }
  }
  return quantized;
}

}  // namespace raygrid
