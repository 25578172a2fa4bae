#include "packing/remap_sections.h"

#include <fmt/format.h>

#include <algorithm>

#include "camera/equivalent_central_camera.h"
#include "dataset/error.h"
#include "packing/blob_uncertainty.h"
#include "packing/view_request.h"

namespace raygrid {
namespace {

// Returns tables of the view with the resolution of the first camera's image,
// or otherwise of its calibrated area; empty if neither is possible.
std::vector<RemapTable> FitDefaultTables(
    const std::vector<const CameraModel*>& cameras, double max_error_px,
    int num_threads, const std::function<void()>& go_on,
    std::vector<std::string>* warnings) {
  const CameraModel& camera = *cameras.front();
  std::string fault;
  for (const InaccurateBlocks rough :
       {InaccurateBlocks::kReject, InaccurateBlocks::kExclude})
    try {
      return FitRemapTables(cameras, MakeView(camera, {}), max_error_px,
                            num_threads, go_on, {}, rough);
    } catch (const Error& error) {
      fault = error.what();
      if (error.code() != ExitCode::kQualityTooLow) break;
    }
  try {
    std::vector<RemapTable> tables = FitRemapTables(
        cameras, MakeAreaView(camera), max_error_px, num_threads, go_on);
    warnings->push_back(
        "the undistortion table is limited to the calibrated area, which is "
        "far off the optical axis");
    return tables;
  } catch (const Error&) {
    warnings->push_back(
        "the blob has no undistortion table; try another output view with "
        "raygrid pack --remap: " +
        fault);
    return {};
  }
}

// Returns the camera of a table's source frames: for a non-central one, the
// central approximation for the requested scene.
std::unique_ptr<CameraModel> MakeRequestCamera(const CameraModel& central,
                                               const NonCentralGeneric* lines,
                                               const RemapRequest& request) {
  std::unique_ptr<CameraModel> camera = central.Clone();
  if (lines && request.scene)
    camera = std::make_unique<EquivalentCentralCamera>(*lines, *request.scene);
  if (request.mode)
    camera = std::make_unique<ModeCamera>(*camera, *request.mode);
  return camera;
}

// Returns the maximum distance in pixels between two cameras' projections of a
// view's rays, at every eighth pixel.
double ComputeMaxDistantError(const CameraModel& near, const CameraModel& far,
                              const VirtualView& view) {
  constexpr int kStep = 8;
  double worst_px = 0;
  for (int y = 0; y < view.size.height; y += kStep) {
    for (int x = 0; x < view.size.width; x += kStep) {
      const auto direction = view.Direction({x, y});
      const auto a = direction ? near.Project(*direction) : std::nullopt;
      const auto b = direction ? far.Project(*direction) : std::nullopt;
      if (a && b) worst_px = std::max(worst_px, (*a - *b).norm());
    }
  }
  return worst_px;
}

// Returns the pixels of frames of a mode, or as calibrated, in valid cells.
PixelFilter MakeValidPixelFilter(const ValidityMask& valid_region,
                                 const std::optional<SensorMode>& mode) {
  return [&valid_region, mode](const Eigen::Vector2d& pixel) {
    return valid_region.IsValidAt(mode ? mode->ToCalibrated(pixel) : pixel);
  };
}

double ComputeImagePercent(const RemapTable& table) {
  const double side = 1 << table.section.block_log2;
  return 100 * table.num_inaccurate_blocks * side * side /
         (static_cast<double>(table.section.width) * table.section.height);
}

// Errors name the table if there are several.
std::vector<RemapTable> FitTables(
    const std::vector<const CameraModel*>& sources, const RemapRequest& request,
    const PackOptions& options, const ValidityMask* valid_region,
    int num_threads, const std::function<void()>& go_on) {
  const auto fit = request.distorts ? FitDistortionTables : FitRemapTables;
  constexpr double kMaxPx = 1;
  for (double bound_px = options.max_error_px;;
       bound_px = std::min(2 * bound_px, kMaxPx)) {
    try {
      return fit(sources, request.view, bound_px, num_threads, go_on,
                 valid_region
                     ? MakeValidPixelFilter(*valid_region, request.mode)
                     : PixelFilter(),
                 options.is_table_bound_soft && bound_px < kMaxPx
                     ? InaccurateBlocks::kReject
                     : InaccurateBlocks::kExclude);
    } catch (const Error& error) {
      if (error.code() == ExitCode::kQualityTooLow &&
          options.is_table_bound_soft && bound_px < kMaxPx)
        continue;
      if (options.remaps.size() == 1) throw;
      throw Error(error.code(),
                  fmt::format("table {}: {}", &request - options.remaps.data(),
                              error.what()));
    }
  }
}

}  // namespace

void RemapSections::Fit(const std::vector<const CameraModel*>& cameras,
                        const NonCentralGeneric* lines,
                        const PackOptions& options,
                        const ValidityMask* valid_region, int num_threads,
                        const std::function<void()>& go_on,
                        PackedCamera* packed) {
  for (const RemapRequest& request : options.remaps) {
    std::vector<std::unique_ptr<CameraModel>> sources;
    std::vector<const CameraModel*> pointers;
    for (const CameraModel* camera : cameras) {
      sources.push_back(MakeRequestCamera(*camera, lines, request));
      pointers.push_back(sources.back().get());
    }
    packed->remaps.push_back(Add(
        FitTables(pointers, request, options, valid_region, num_threads, go_on),
        request.mode));
    packed->remaps.back().distorts = request.distorts;
    WarnAboutOutOfRange(packed);
    if (packed->remaps.back().error_px > options.max_error_px)
      packed->warnings.push_back(
          fmt::format("table {}: error up to {:.2g} px exceeds {} px even "
                      "with blocks of 8 px; reduce the field of view",
                      tables_.size() - 1, packed->remaps.back().error_px,
                      options.max_error_px));
    if (lines && request.scene)
      packed->remaps.back().distant_error_px = ComputeMaxDistantError(
          *sources[0], *MakeRequestCamera(*cameras[0], nullptr, request),
          request.view);
  }
  if (!options.has_default_remap) return;
  std::vector<RemapTable> tables = FitDefaultTables(
      cameras, options.max_error_px, num_threads, go_on, &packed->warnings);
  if (tables.empty()) return;
  packed->remaps.push_back(Add(std::move(tables)));
  WarnAboutOutOfRange(packed);
}

void RemapSections::AddTo(rg_blob_contents* contents) {
  for (std::vector<RemapTable>& tables : tables_) {
    contents_.resize(tables.size());
    for (size_t k = 0; k < tables.size(); ++k) {
      RemapTable& table = tables[k];
      table.section.empty_blocks = table.empty_blocks.data();
      table.section.bends = table.bends.data();
      contents_[k].push_back({&table.section, table.residuals.data()});
    }
  }
  if (contents_.empty()) return;
  const std::vector<rg_remap_contents>& own = contents_[0];
  contents->remap = own[0].section;
  contents->residuals = own[0].residuals;
  contents->more_remaps = own.data() + 1;
  contents->num_more_remaps = static_cast<uint32_t>(own.size() - 1);
  for (size_t k = 0; k < modes_.size(); ++k)
    modes_[k].name = mode_names_[k].data();
  contents->modes = modes_.data();
  contents->num_modes = static_cast<uint32_t>(modes_.size());
}

void RemapSections::WarnAboutOutOfRange(PackedCamera* packed) const {
  const RemapTable& table = tables_.back().front();
  if (table.num_out_of_range > 0)
    packed->warnings.push_back(fmt::format(
        "table {}: {} blocks of {} px at the image edge are filled with the "
        "border value, because their source positions exceed 8192 px; use a "
        "table for smaller frames (--mode)",
        tables_.size() - 1, table.num_out_of_range,
        1 << table.section.block_log2));
  if (table.num_inaccurate_blocks > 0)
    packed->warnings.push_back(fmt::format(
        "table {}: {} blocks of {} px ({:.2g} % of the output view) are filled "
        "with the border value, because their distortion cannot be represented "
        "within {} px; increase --max-error-px",
        tables_.size() - 1, table.num_inaccurate_blocks,
        1 << table.section.block_log2, ComputeImagePercent(table),
        table.section.bound_upx * 1e-6));
}

PackedRemap RemapSections::Add(std::vector<RemapTable> tables,
                               const std::optional<SensorMode>& mode) {
  if (mode) {
    for (RemapTable& each : tables) {
      each.section.has_view = 1;
      each.section.mode = GetModeNumber(*mode);
    }
  }
  const RemapTable& table = tables.front();
  const rg_remap_section& s = table.section;
  const int block_size = 1 << s.block_log2;
  PackedRemap packed;
  packed.view = table.view;
  if (mode) packed.mode = mode->name;
  packed.error_px = table.max_error_px;
  packed.chroma_error_px = table.max_chroma_error_px;
  packed.block_size = block_size;
  packed.tile_size = s.part_log2 != 0 ? 1 << s.part_log2 : block_size;
  for (const RemapTable& each : tables) {
    packed.error_px = std::max(packed.error_px, each.max_error_px);
    packed.chroma_error_px =
        std::max(packed.chroma_error_px, each.max_chroma_error_px);
  }
  tables_.push_back(std::move(tables));
  return packed;
}

uint8_t RemapSections::GetModeNumber(const SensorMode& mode) {
  const std::string name = FormatPadded("mode", mode.name);
  const auto found = std::find(mode_names_.begin(), mode_names_.end(), name);
  const auto number = found - mode_names_.begin() + 1;
  if (found == mode_names_.end()) {
    mode_names_.push_back(name);
    modes_.push_back(QuantizeMode(mode));
  }
  return static_cast<uint8_t>(number);
}

}  // namespace raygrid
