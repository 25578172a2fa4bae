#include "packing/packed_grids.h"

#include <fmt/format.h>

#include <algorithm>

#include "dataset/error.h"
#include "packing/blob_camera.h"
#include "packing/blob_limits.h"
#include "packing/projection_error.h"
#include "rg_status.h"

namespace raygrid {
namespace {

// Whether the format can represent the contents with these control points.
bool IsWritable(const rg_blob_contents& contents) {
  std::vector<uint32_t> words((rg_blob_size(&contents) + 3) / 4);
  return rg_blob_write(&contents, words.data(),
                       static_cast<uint32_t>(4 * words.size())) == RG_OK;
}

rg_narrow_grid MakeControlPoints(const InverseGrid& grid) {
  rg_narrow_grid points = grid.points.section;
  points.residuals = grid.points.residuals.data();
  return points;
}

}  // namespace

std::string WriteBlob(const rg_blob_contents& contents) {
  const uint32_t size = rg_blob_size(&contents);
  std::vector<uint32_t> words((size + 3) / 4);
  const rg_status status = rg_blob_write(&contents, words.data(), size);
  if (status != RG_OK) ThrowDoesNotFitBlob(rg_status_text(status));
  return std::string(reinterpret_cast<const char*>(words.data()), size);
}

GridPoints::GridPoints(const std::vector<GridSection>& grids, bool is_allowed,
                       const std::vector<PackingTruth>& truths,
                       double max_error_px, int num_threads,
                       rg_blob_contents* contents)
    : grids_(grids) {
  std::vector<ControlPoints> points;
  for (const GridSection& grid : grids) points.push_back(grid.control_points);
  if (is_allowed) narrow_ = QuantizeToInt16Together(points);
  if (narrow_)
    for (Int16Grid& narrow : *narrow_)
      narrow.section.residuals = narrow.residuals.data();
  if (!narrow_ || !Measure(truths, num_threads, contents) ||
      error_.px > max_error_px || error_.rad > kMaxInt16ErrorRad) {
    narrow_.reset();
    Measure(truths, num_threads, contents);
  }
  Point(0, contents);
}

bool GridPoints::Measure(const std::vector<PackingTruth>& truths,
                         int num_threads, rg_blob_contents* contents) {
  error_ = {};
  for (size_t k = 0; k < truths.size(); ++k) {
    Point(k, contents);
    if (narrow_ && !IsWritable(*contents)) return false;
    const UnprojectionError error =
        MeasureUnprojection(truths[k], WriteBlob(*contents), num_threads);
    error_.px = std::max(error_.px, error.px);
    error_.rad = std::max(error_.rad, error.rad);
  }
  return true;
}

InverseSections::InverseSections(
    const std::vector<const BSplineSurface*>& surfaces,
    const GridPoints& points, const ValidityMask* valid_region, int num_threads,
    const std::function<void()>& go_on, rg_blob_contents* contents) {
  const auto measure = [&](size_t k, const InverseGrid& grid,
                           double max_pixels) {
    go_on();
    rg_blob_contents measured = *contents;
    points.Point(k, &measured);
    const rg_narrow_grid inverse_points = MakeControlPoints(grid);
    measured.inverse = &grid.section;
    measured.inverse_points = &inverse_points;
    return IsWritable(measured) ? std::optional(MeasureProjection(
                                      BlobCamera("blob", WriteBlob(measured)),
                                      valid_region, max_pixels, num_threads))
                                : std::nullopt;
  };
  if (surfaces.size() == 1) {
    if (auto inverse =
            FitInverseGrid(*surfaces[0], valid_region,
                           [&](const InverseGrid& grid, double max_pixels) {
                             return measure(0, grid, max_pixels);
                           }))
      inverses_.push_back(*std::move(inverse));
  } else if (auto inverses =
                 FitInverseGridsJointly(surfaces, valid_region, measure)) {
    inverses_ = *std::move(inverses);
  }
  for (const EvaluatedInverseGrid& inverse : inverses_)
    points_.push_back(MakeControlPoints(inverse.grid));
  if (inverses_.empty()) return;
  contents->inverse = &inverses_[0].grid.section;
  contents->inverse_points = &points_[0];
}
std::optional<ProjectionError> InverseSections::error() const {
  if (inverses_.empty()) return std::nullopt;
  return std::max_element(inverses_.begin(), inverses_.end(),
                          [](const auto& a, const auto& b) {
                            return a.error.valid_region.FailedFraction() <
                                   b.error.valid_region.FailedFraction();
                          })
      ->error;
}

}  // namespace raygrid
