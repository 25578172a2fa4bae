#include "packing/fitted_grids.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/error.h"
#include "packing/blob_limits.h"

namespace raygrid {
namespace {

GridsToPack MakeGrids(const GridTask& task, double max_error_px) {
  GridsToPack made;
  if (!task.stack) {
    made.Add(MakeBlobGrid(task.camera, task.region, task.valid_region,
                          max_error_px));
    return made;
  }
  const BSplineSurface& reference = task.stack->cameras[0].surface();
  std::vector<CentralGeneric> cameras = {FitCentralGeneric(
      task.camera, reference.area(), reference.columns(), reference.rows())};
  cameras.insert(cameras.end(), task.stack->cameras.begin(),
                 task.stack->cameras.end());
  for (const CentralGeneric& camera : cameras) {
    std::optional<RegularRegion> region;
    if (!IsBlobGrid(camera)) region.emplace(camera, task.num_threads);
    made.Add(MakeBlobGrid(camera, region ? &*region : nullptr,
                          made.ValidOr(task.valid_region), max_error_px));
    const BSplineSurface& surface = made.models.back().surface();
    if (surface.columns() != reference.columns() ||
        surface.rows() != reference.rows())
      ThrowDoesNotFitBlob(
          "the calibrated areas of the operating points differ by less than "
          "1/65536 px");
  }
  return made;
}

}  // namespace

void RequireSimilarSamples(const OperatingPointSamples& stack,
                           const CameraModel& camera) {
  const auto require = [](bool is_good, const char* what) {
    if (!is_good) ThrowDoesNotFitBlob(what);
  };
  const size_t num = stack.values.size();
  require(camera.IsCentral(),
          "samples over the operating point must be central cameras");
  require(num == stack.cameras.size() && num >= RG_MIN_STACK_SAMPLES &&
              num <= RG_MAX_STACK_SAMPLES,
          "a blob has 2 to 64 samples over the operating point");
  for (size_t k = 0; k < num; ++k) {
    const BSplineSurface& a = stack.cameras[0].surface();
    const BSplineSurface& b = stack.cameras[k].surface();
    require(std::abs(stack.values[k]) <= 1024 &&
                (k == 0 || std::lround(stack.values[k] * 65536) >
                               std::lround(stack.values[k - 1] * 65536)),
            "operating points must be ascending and at most 1024");
    require(a.columns() == b.columns() && a.rows() == b.rows() &&
                a.area().x0 == b.area().x0 && a.area().y0 == b.area().y0 &&
                a.area().x1 == b.area().x1 && a.area().y1 == b.area().y1 &&
                stack.cameras[k].image_size() == camera.image_size(),
            "samples over the operating point must have grids of equal size "
            "and area");
  }
}

BlobGrids::BlobGrids(const GridTask& task, double max_error_px,
                     rg_blob_contents* contents) {
  constexpr int kTries = 3;
  double target_error_px = max_error_px;
  for (int k = 0; k < kTries; ++k, target_error_px /= 2) {
    made = MakeGrids(task, target_error_px);
    sections_.clear();
    for (const CentralGeneric& model : made.models)
      sections_.push_back(QuantizeGrid(model));
    contents->grid = &sections_[0].section;
    points.emplace(sections_, task.is_int16_allowed, Truths(task), max_error_px,
                   task.num_threads, contents);
    if (points->error().px <= max_error_px) return;
  }
  throw Error(ExitCode::kQualityTooLow,
              fmt::format("unprojection error of packing would be {:.2g} px, "
                          "above the limit of {}",
                          points->error().px, max_error_px));
}

std::vector<const BSplineSurface*> BlobGrids::Surfaces() const {
  std::vector<const BSplineSurface*> surfaces;
  for (const CentralGeneric& model : made.models)
    surfaces.push_back(&model.surface());
  return surfaces;
}

std::vector<PackingTruth> BlobGrids::Truths(const GridTask& task) const {
  const ValidityMask* valid = made.ValidOr(task.valid_region);
  std::vector<PackingTruth> exact_cameras = {
      {task.camera, made.models[0], valid}};
  for (size_t k = 1; k < made.models.size(); ++k)
    exact_cameras.push_back(
        {task.stack->cameras[k - 1], made.models[k], valid});
  return exact_cameras;
}

std::unique_ptr<BlobGrids> FitBlobGrids(const GridTask& task,
                                        double max_error_px,
                                        rg_blob_contents* contents) {
  auto grids = std::make_unique<BlobGrids>(
      task, std::min(kMaxPackingErrorPx, max_error_px), contents);
  if (!grids->made.is_reproduced_everywhere &&
      max_error_px > kMaxPackingErrorPx)
    grids = std::make_unique<BlobGrids>(task, max_error_px, contents);
  return grids;
}

}  // namespace raygrid
