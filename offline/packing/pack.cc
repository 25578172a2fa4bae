#include "packing/pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "camera/central_generic.h"
#include "camera/noncentral_generic.h"
#include "dataset/fixed_operating_point.h"
#include "dataset/parallel_for.h"
#include "packing/blob_limits.h"
#include "packing/blob_uncertainty.h"
#include "packing/fitted_grids.h"
#include "packing/inverse_grid.h"
#include "packing/remap_sections.h"

namespace raygrid {
namespace {

// Returns a warning if the projection error exceeds the guaranteed accuracy,
// otherwise nullopt. `error` is nullopt for a blob without an inverse grid.
std::optional<std::string> WarnAboutProjection(
    const std::optional<ProjectionError>& error, bool has_mask) {
  if (!error)
    return "no 16-bit inverse grid is accurate enough: the blob does not "
           "support projection";
  const ProjectedPixels& pixels = error->valid_region;
  const int64_t num_all = pixels.num_pixels + pixels.num_not_invertible;
  std::string faults;
  const auto add = [&](int64_t count, const std::string& what) {
    if (count > 0)
      faults += fmt::format("{}{:.2g} % {}", faults.empty() ? "" : ", ",
                            100.0 * count / num_all, what);
  };
  add(pixels.num_not_converged, "do not converge");
  add(pixels.num_inaccurate,
      fmt::format("have errors above {} px, up to {:.2g} px",
                  kMaxProjectionErrorPx, pixels.worst_px));
  add(pixels.num_not_invertible,
      "are ambiguous (folds of the distortion) or more than 151 degrees off "
      "axis");
  if (faults.empty()) return std::nullopt;
  return fmt::format(
      "projection is not accurate for all {} pixels: {}; add images with the "
      "target there, or increase --knot-spacing-px, for a smoother camera",
      has_mask ? "valid" : "calibrated", faults);
}

void RequirePackable(const CameraModel& camera) {
  if (!camera.IsCentral() && !camera.DirectionGrid())
    throw Error(ExitCode::kQualityTooLow,
                fmt::format("a {} camera cannot be packed; fit {} to it first",
                            camera.Name(), models::kNonCentralGeneric));
  if (camera.image_size().width > static_cast<int>(RG_MAX_IMAGE_SIZE) ||
      camera.image_size().height > static_cast<int>(RG_MAX_IMAGE_SIZE))
    ThrowDoesNotFitBlob(fmt::format(
        "the image exceeds {} px in width or height", RG_MAX_IMAGE_SIZE));
}

// Checked before tables are fitted, which takes time. A blob's other sections
// are camera, grid, inverse grid and quality, and optional ones, such as a mask
// if the camera may not be regular everywhere.
void CheckTableLimit(const CameraFile& file, const PackOptions& options) {
  const bool has_modes =
      std::any_of(options.remaps.begin(), options.remaps.end(),
                  [](const RemapRequest& remap) { return remap.mode; });
  const size_t num_others = size_t{4} + !file.camera->IsCentral() +
                            (file.uncertainty ? 2 : !IsBlobGrid(*file.camera)) +
                            has_modes + file.capture.has_value() +
                            options.stack.has_value() +
                            file.line_delay.has_value();
  const size_t max_tables = RG_MAX_SECTIONS - num_others;
  if (options.remaps.size() > max_tables)
    throw Error(ExitCode::kUsage,
                fmt::format("{} remap tables exceed the limit of {} for this "
                            "camera; pack several blobs",
                            options.remaps.size(), max_tables));
}

void ThrowIfStopped(const PackOptions& options) {
  if (options.should_stop && options.should_stop())
    throw Error(ExitCode::kNotConverged,
                "interrupted before packing; create the blob from camera.yaml "
                "with raygrid pack");
}

// Returns the fraction of the image that is calibrated and, if there is a mask,
// valid.
double ComputeValidFraction(const CameraModel& camera,
                            const ValidityMask* valid_region) {
  ValidityMask mask =
      valid_region ? *valid_region : ValidityMask::Over(camera.image_size());
  if (!valid_region) mask.is_valid.assign(mask.is_valid.size(), true);
  return CameraUncertainty::FromMask(mask).ValidFraction(camera.image_size(),
                                                         camera.area());
}

// Returns the uncertainty of a camera, restricted to the valid region. A camera
// without a valid region remains so.
std::optional<CameraUncertainty> UncertaintyWithin(
    const std::optional<CameraUncertainty>& known, const ValidityMask* valid) {
  if (!valid || (known && !known->mask.HasValidCells())) return known;
  CameraUncertainty within =
      known ? *known : CameraUncertainty::FromMask(*valid);
  within.mask = *valid;
  return within;
}

// Returns a warning about the region of the image that a blob excludes, with
// the reason; nullopt if no region is excluded.
std::optional<std::string> WarnAboutExcludedArea(const GridTask& task,
                                                 const GridsToPack& made,
                                                 double excluded_fraction,
                                                 double max_error_px) {
  if (excluded_fraction <= 0) return std::nullopt;
  std::string why;
  if (task.region && !task.region->IsWhole())
    why = fmt::format(
        "the distortion folds or ends there, or rays are more than 151 degrees "
        "off axis ({:.2g} % of the calibrated area)",
        100 * (1 - task.region->Part()));
  if (!made.is_reproduced_everywhere)
    why += fmt::format(
        "{}no grid represents the camera there within {} px (increase "
        "--max-error-px)",
        why.empty() ? "" : ", or ", max_error_px);
  return fmt::format(
      "{:.2g} % of the image is excluded by the validity mask: {}; remap "
      "tables contain the border value there",
      100 * excluded_fraction, why);
}

// Packs a camera calibrated over several conditions. The operating-point model
// of a blob varies with one condition only, the first one.
PackedCamera PackOperatingPoints(const CameraFile& file,
                                 const PackOptions& options) {
  CameraFile along = file;
  along.stack = SliceOperatingPointModel(*file.stack, 0);
  PackedCamera packed = PackCamera(along, options);
  const std::vector<OperatingRange>& ranges = file.stack->cameras.ranges();
  const std::string other = OperatingParameterName(ranges[1].condition);
  packed.warnings.push_back(fmt::format(
      "a blob can vary with one quantity only: it varies with {}, at {} {:g} "
      "(centre of the range); select another value with pack --at {}=VALUE",
      OperatingParameterName(ranges[0].condition), other, ranges[1].Center(),
      other));
  return packed;
}

// The sections with data of the camera file; contents point to them.
class FileSections {
 public:
  void AddTo(const CameraFile& file, const NonCentralGeneric* lines,
             const BlobGrids& grids, const ValidityMask* valid_region,
             rg_blob_contents* contents) {
    quality_ = QuantizeQuality(file, grids.points->error());
    contents->quality = &quality_;
    if (lines) {
      line_points_ = QuantizeLinePoints(*lines, grids.made.models[0].surface());
      contents->line_points_q28 = line_points_.data();
    }
    if (const auto known = UncertaintyWithin(file.uncertainty, valid_region)) {
      uncertainty_ = QuantizeUncertainty(*known, grids.section());
      uncertainty_.AddTo(contents);
    }
    if (file.capture) {
      capture_ = QuantizeCapture(*file.capture);
      contents->capture = &capture_;
    }
    if (file.line_delay) {
      line_delay_ = QuantizeLineDelay(*file.line_delay);
      contents->row_time = &line_delay_;
    }
  }

 private:
  rg_quality_section quality_;
  std::vector<int32_t> line_points_;
  UncertaintySections uncertainty_;
  rg_capture_section capture_;
  rg_row_time_section line_delay_;
};

// The section of the operating-point model; contents point to it.
class OperatingPointSectionWriter {
 public:
  void AddTo(const OperatingPointSamples& stack, const GridPoints& points,
             const InverseSections& inverse, const RemapSections& remaps,
             rg_blob_contents* contents) {
    for (size_t k = 1; k <= stack.cameras.size(); ++k) {
      rg_stack_sample_contents sample = {};
      sample.value_q16 =
          static_cast<int32_t>(std::lround(stack.values[k - 1] * 65536));
      points.Point(k, &sample);
      sample.inverse_points = inverse.points(k);
      sample.remaps = remaps.contents(k);
      operating_point_samples_.push_back(sample);
    }
    section_.condition = static_cast<uint16_t>(stack.condition);
    section_.num_samples =
        static_cast<uint16_t>(operating_point_samples_.size());
    section_.samples = operating_point_samples_.data();
    contents->stack = &section_;
  }

 private:
  std::vector<rg_stack_sample_contents> operating_point_samples_;
  rg_stack_contents section_ = {};
};

// Packs a camera with the operating-point model given in the options, if any.
PackedCamera PackWithOperatingPoints(const CameraFile& file,
                                     const PackOptions& options) {
  const CameraModel& camera = *file.camera;
  const auto* lines = dynamic_cast<const NonCentralGeneric*>(&camera);
  RequirePackable(camera);
  CheckTableLimit(file, options);
  // The central camera with the directions of a non-central camera, which is
  // exact for distant scenes.
  const std::optional<CentralGeneric> far =
      lines ? std::optional(MakeCentral(camera)) : std::nullopt;
  const CameraModel& central = far ? *far : camera;
  const ValidityMask* stored_mask =
      file.uncertainty && file.uncertainty->mask.HasValidCells()
          ? &file.uncertainty->mask
          : nullptr;
  const int num_threads = NumThreads(options.num_threads);
  const std::function<void()> go_on = [&options] { ThrowIfStopped(options); };

  const OperatingPointSamples* stack =
      options.stack ? &*options.stack : nullptr;
  if (stack) RequireSimilarSamples(*stack, camera);
  const std::shared_ptr<const RegularRegion> region =
      IsBlobGrid(central)
          ? nullptr
          : std::make_shared<RegularRegion>(central, num_threads);
  // The regular region of the camera, which remap tables use.
  const std::unique_ptr<CameraModel> shown =
      region && !region->IsWhole() && !region->IsEmpty()
          ? std::make_unique<RegularCamera>(central, region)
          : central.Clone();
  std::vector<const CameraModel*> cameras = {shown.get()};
  for (size_t k = 0; stack && k < stack->cameras.size(); ++k)
    cameras.push_back(&stack->cameras[k]);
  const std::string name = FormatPadded("name", file.name);
  const std::string serial = FormatPadded("serial", file.serial);
  const rg_camera_section identity = {
      static_cast<uint16_t>(camera.image_size().width),
      static_cast<uint16_t>(camera.image_size().height), name.data(),
      serial.data()};
  rg_blob_contents contents = {};
  contents.camera = &identity;
  const GridTask task = {
      central,    region.get(), stored_mask, stack, options.is_int16_allowed,
      num_threads};
  const std::unique_ptr<BlobGrids> grids =
      FitBlobGrids(task, options.max_ray_error_px, &contents);
  const GridPoints& points = *grids->points;
  const ValidityMask* valid_region = grids->made.ValidOr(stored_mask);

  PackedCamera packed;
  packed.unproject_error_px = points.error().px;
  packed.unproject_error_rad = points.error().rad;
  packed.excluded_fraction = ComputeValidFraction(central, stored_mask) -
                             ComputeValidFraction(central, valid_region);
  if (const auto warning = WarnAboutExcludedArea(
          task, grids->made, packed.excluded_fraction,
          std::max(kMaxPackingErrorPx, options.max_ray_error_px)))
    packed.warnings.push_back(*warning);
  // Projects directions to pixels, also for non-central cameras.
  const InverseSections inverse(grids->Surfaces(), points, valid_region,
                                num_threads, go_on, &contents);
  packed.projection = inverse.error();
  if (const auto warning =
          WarnAboutProjection(packed.projection, valid_region != nullptr))
    packed.warnings.push_back(*warning);
  RemapSections remaps;
  remaps.Fit(cameras, lines, options, options.shown ? &*options.shown : nullptr,
             num_threads, go_on, &packed);
  remaps.AddTo(&contents);

  FileSections sections;
  sections.AddTo(file, lines, *grids, valid_region, &contents);
  OperatingPointSectionWriter operating_point_section;
  if (stack)
    operating_point_section.AddTo(*stack, points, inverse, remaps, &contents);
  packed.blob = WriteBlob(contents);
  return packed;
}

}  // namespace

PackedCamera PackCamera(const CameraFile& file, const PackOptions& options) {
  if (!file.stack || options.stack)
    return PackWithOperatingPoints(file, options);
  if (file.stack->cameras.ranges().size() > 1)
    return PackOperatingPoints(file, options);
  PackOptions with_operating_points = options;
  with_operating_points.stack = MakeModelSamples(file.stack->cameras);
  // A blob has a single uncertainty section, which must hold for all of its
  // cameras.
  CameraFile valid_in_all_samples = file;
  valid_in_all_samples.uncertainty = ComputeMaxUncertainty(file);
  return PackWithOperatingPoints(valid_in_all_samples, with_operating_points);
}

PackingMetrics ComputePackingMetrics(const PackedCamera& packed) {
  PackingMetrics metrics;
  metrics.blob_bytes = packed.blob.size();
  metrics.unproject_error_px = packed.unproject_error_px;
  metrics.warnings = packed.warnings;
  if (packed.remaps.empty()) return metrics;
  const VirtualView& view = packed.remaps[0].view;
  metrics.remap_error_px = packed.remaps[0].error_px;
  metrics.view = {view.size, view.focal_px, view.center_px};
  return metrics;
}

PackedCamera PackSupportedSections(const CameraFile& file, int num_threads,
                                   const std::function<bool()>& should_stop) {
  PackOptions options;
  options.num_threads = num_threads;
  options.should_stop = should_stop;
  options.has_default_remap = true;
  try {
    return PackCamera(file, options);
  } catch (const Error& error) {
    if (file.stack && error.code() != ExitCode::kNotConverged) {
      CameraFile alone = file;
      alone.stack.reset();
      PackedCamera packed =
          PackSupportedSections(alone, num_threads, should_stop);
      packed.warnings.push_back(
          fmt::format("contains only the camera at the centre of the range: {}",
                      error.what()));
      return packed;
    }
    PackedCamera none;
    none.warnings = {fmt::format("is omitted: {}", error.what())};
    return none;
  }
}

}  // namespace raygrid
