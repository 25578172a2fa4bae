#include "packing/pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "camera/central_generic.h"
#include "camera/equivalent_central_camera.h"
#include "camera/noncentral_generic.h"
#include "dataset/fixed_operating_point.h"
#include "dataset/parallel_for.h"
#include "dataset/text_encoding.h"
#include "packing/blob_camera.h"
#include "packing/blob_figures.h"
#include "packing/blob_grid.h"
#include "packing/blob_limits.h"
#include "packing/inverse_grid.h"
#include "packing/packed_grids.h"
#include "packing/regular_region.h"
#include "packing/remap_fitting.h"
#include "packing/unprojection_error.h"
#include "packing/view_request.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {
namespace {

// A zero-padded text of RG_TEXT_SIZE bytes.
std::string PaddedText(const char* what, const std::string& text) {
  RequireBlobText(what, text);
  std::string padded = text;
  padded.resize(RG_TEXT_SIZE, '\0');
  return padded;
}

// Why projection does not reach the guaranteed accuracy; nothing if it does.
// Without an error the blob has no inverse grid.
std::optional<std::string> WarnAboutProjection(
    const std::optional<ProjectionError>& error, bool has_mask) {
  if (!error)
    return "no 16-bit inverse grid is accurate enough: the blob does not "
           "support projection";
  const FoundPixels& pixels = error->trusted;
  const int64_t num_all = pixels.num_pixels + pixels.num_unfindable;
  std::string faults;
  const auto add = [&](int64_t count, const std::string& what) {
    if (count > 0)
      faults += fmt::format("{}{:.2g} % {}", faults.empty() ? "" : ", ",
                            100.0 * count / num_all, what);
  };
  add(pixels.num_lost, "do not converge");
  add(pixels.num_off, fmt::format("have errors above {} px, up to {:.2g} px",
                                  kMaxProjectionErrorPx, pixels.worst_px));
  add(pixels.num_unfindable,
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
    throw Error(ExitCode::kQuality,
                fmt::format("a {} camera cannot be packed; fit {} to it first",
                            camera.Name(), models::kNonCentralGeneric));
  if (camera.image_size().width > static_cast<int>(RG_MAX_IMAGE_SIZE) ||
      camera.image_size().height > static_cast<int>(RG_MAX_IMAGE_SIZE))
    ThrowDoesNotFitBlob(fmt::format(
        "the image exceeds {} px in width or height", RG_MAX_IMAGE_SIZE));
}

// Before tables are fitted, which takes time. A blob's other sections are
// camera, grid, inverse grid and quality, and those that not every camera has:
// a mask if the camera may not be regular everywhere.
void RequireFewTables(const CameraFile& file, const PackOptions& options) {
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

// Tables of the view with the resolution of the first camera's image, or
// otherwise of its calibrated area; empty if neither is possible.
std::vector<RemapTable> FitDefaultTables(
    const std::vector<const CameraModel*>& cameras, double max_error_px,
    int num_threads, const std::function<void()>& go_on,
    std::vector<std::string>* warnings) {
  const CameraModel& camera = *cameras.front();
  std::string fault;
  for (const RoughBlocks rough : {RoughBlocks::kRefuse, RoughBlocks::kLeaveOut})
    try {
      return FitRemapTables(cameras, MakeView(camera, {}), max_error_px,
                            num_threads, go_on, {}, rough);
    } catch (const Error& error) {
      fault = error.what();
      if (error.code() != ExitCode::kQuality) break;
    }
  try {
    std::vector<RemapTable> tables = FitRemapTables(
        cameras, MakeViewOfArea(camera), max_error_px, num_threads, go_on);
    warnings->push_back(
        "its undistortion table is limited to the calibrated area, which is "
        "far off the optical axis");
    return tables;
  } catch (const Error&) {
    warnings->push_back(
        "has no undistortion table; try another view with raygrid pack "
        "--remap: " +
        fault);
    return {};
  }
}

// The camera of a table's source frames: for a non-central one, the central
// approximation for the requested scene.
std::unique_ptr<CameraModel> CameraOfRequest(const CameraModel& central,
                                             const NonCentralGeneric* lines,
                                             const RemapRequest& request) {
  std::unique_ptr<CameraModel> camera = central.Clone();
  if (lines && request.scene)
    camera = std::make_unique<EquivalentCentralCamera>(*lines, *request.scene);
  if (request.mode)
    camera = std::make_unique<ModeCamera>(*camera, *request.mode);
  return camera;
}

// The maximum distance in pixels between two cameras' projections of a view's
// rays, at every eighth pixel.
double FarError(const CameraModel& near, const CameraModel& far,
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

// A mode without its name.
rg_mode_section QuantizeMode(const SensorMode& mode) {
  const auto q16 = [](double value) { return std::lround(value * 65536); };
  rg_mode_section section = {};
  section.width = static_cast<uint16_t>(mode.size.width);
  section.height = static_cast<uint16_t>(mode.size.height);
  section.offset_x_q16 = static_cast<int32_t>(q16(mode.offset_px.x()));
  section.offset_y_q16 = static_cast<int32_t>(q16(mode.offset_px.y()));
  section.scale_x_q16 = static_cast<uint32_t>(q16(mode.scale.x()));
  section.scale_y_q16 = static_cast<uint32_t>(q16(mode.scale.y()));
  section.flip_x = mode.flip_x;
  section.flip_y = mode.flip_y;
  return section;
}

// The pixels of frames of a mode, or as calibrated, in valid cells.
PixelFilter TrustedPixels(const ValidityMask& trusted,
                          const std::optional<SensorMode>& mode) {
  return [&trusted, mode](const Eigen::Vector2d& pixel) {
    return trusted.IsValidAt(mode ? mode->ToCalibrated(pixel) : pixel);
  };
}

// Remap tables as rg_blob_write() takes them.
class RemapSections {
 public:
  // Fits the requested tables, and records them in packed: of the first camera,
  // and with equal layout of the others. lines: NULL for a central camera; the
  // first one is always central. trusted: restricts what they show, or NULL.
  void Fit(const std::vector<const CameraModel*>& cameras,
           const NonCentralGeneric* lines, const PackOptions& options,
           const ValidityMask* trusted, int num_threads,
           const std::function<void()>& go_on, PackedCamera* packed) {
    for (const RemapRequest& request : options.remaps) {
      std::vector<std::unique_ptr<CameraModel>> sources;
      std::vector<const CameraModel*> pointers;
      for (const CameraModel* camera : cameras) {
        sources.push_back(CameraOfRequest(*camera, lines, request));
        pointers.push_back(sources.back().get());
      }
      packed->remaps.push_back(Add(
          FitTables(pointers, request, options, trusted, num_threads, go_on),
          request.mode));
      packed->remaps.back().distorts = request.distorts;
      WarnAboutReach(packed);
      if (packed->remaps.back().error_px > options.max_error_px)
        packed->warnings.push_back(
            fmt::format("table {}: error up to {:.2g} px exceeds {} px even "
                        "with blocks of 8 px; reduce the field of view",
                        tables_.size() - 1, packed->remaps.back().error_px,
                        options.max_error_px));
      if (lines && request.scene)
        packed->remaps.back().far_error_px = FarError(
            *sources[0], *CameraOfRequest(*cameras[0], nullptr, request),
            request.view);
    }
    if (!options.has_default_remap) return;
    std::vector<RemapTable> tables = FitDefaultTables(
        cameras, options.max_error_px, num_threads, go_on, &packed->warnings);
    if (tables.empty()) return;
    packed->remaps.push_back(Add(std::move(tables)));
    WarnAboutReach(packed);
  }

  // Adds the first camera's tables to contents, which point to memory owned by
  // this object.
  void AddTo(rg_blob_contents* contents) {
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

  // The tables of a camera, after AddTo(); NULL if there are none.
  const rg_remap_contents* contents(size_t camera) const {
    return contents_.empty() ? nullptr : contents_[camera].data();
  }

 private:
  static double PercentOfPicture(const RemapTable& table) {
    const double side = 1 << table.section.block_log2;
    return 100 * table.num_rough * side * side /
           (static_cast<double>(table.section.width) * table.section.height);
  }

  // Says what the last table cannot reach, or follow.
  void WarnAboutReach(PackedCamera* packed) const {
    const RemapTable& table = tables_.back().front();
    if (table.num_out_of_reach > 0)
      packed->warnings.push_back(fmt::format(
          "table {}: {} blocks of {} px at the image edge are filled with the "
          "border value, because their source positions exceed 8192 px; use a "
          "table for smaller frames (--mode)",
          tables_.size() - 1, table.num_out_of_reach,
          1 << table.section.block_log2));
    if (table.num_rough > 0)
      packed->warnings.push_back(fmt::format(
          "table {}: {} blocks of {} px ({:.2g} % of the view) are filled with "
          "the border value, because their distortion cannot be represented "
          "within {} px; increase --max-error-px",
          tables_.size() - 1, table.num_rough, 1 << table.section.block_log2,
          PercentOfPicture(table), table.section.bound_upx * 1e-6));
  }

  // An error says which of several tables it is of.
  static std::vector<RemapTable> FitTables(
      const std::vector<const CameraModel*>& sources,
      const RemapRequest& request, const PackOptions& options,
      const ValidityMask* trusted, int num_threads,
      const std::function<void()>& go_on) {
    const auto fit = request.distorts ? FitDistortionTables : FitRemapTables;
    constexpr double kMostPx = 1;
    for (double bound_px = options.max_error_px;;
         bound_px = std::min(2 * bound_px, kMostPx)) {
      try {
        return fit(
            sources, request.view, bound_px, num_threads, go_on,
            trusted ? TrustedPixels(*trusted, request.mode) : PixelFilter(),
            options.is_table_bound_soft && bound_px < kMostPx
                ? RoughBlocks::kRefuse
                : RoughBlocks::kLeaveOut);
      } catch (const Error& error) {
        if (error.code() == ExitCode::kQuality && options.is_table_bound_soft &&
            bound_px < kMostPx)
          continue;
        if (options.remaps.size() == 1) throw;
        throw Error(error.code(), fmt::format("table {}: {}",
                                              &request - options.remaps.data(),
                                              error.what()));
      }
    }
  }

  // Tables of each camera.
  PackedRemap Add(std::vector<RemapTable> tables,
                  const std::optional<SensorMode>& mode = std::nullopt) {
    if (mode) {
      for (RemapTable& each : tables) {
        each.section.has_view = 1;
        each.section.mode = NumberOfMode(*mode);
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
    packed.part_size = s.part_log2 != 0 ? 1 << s.part_log2 : block_size;
    for (const RemapTable& each : tables) {
      packed.error_px = std::max(packed.error_px, each.max_error_px);
      packed.chroma_error_px =
          std::max(packed.chroma_error_px, each.max_chroma_error_px);
    }
    tables_.push_back(std::move(tables));
    return packed;
  }

  // The mode's place in the section of modes, counted from 1.
  uint8_t NumberOfMode(const SensorMode& mode) {
    const std::string name = PaddedText("mode", mode.name);
    const auto found = std::find(mode_names_.begin(), mode_names_.end(), name);
    const auto number = found - mode_names_.begin() + 1;
    if (found == mode_names_.end()) {
      mode_names_.push_back(name);
      modes_.push_back(QuantizeMode(mode));
    }
    return static_cast<uint8_t>(number);
  }

  std::vector<std::vector<RemapTable>> tables_;  // of a request, of each camera
  std::vector<rg_mode_section> modes_;
  std::vector<std::string> mode_names_;
  std::vector<std::vector<rg_remap_contents>> contents_;  // of each camera
};

// Throws where the knots are not of one kind with each other.
void RequireAlikeKnots(const OperatingPointKnots& stack,
                       const CameraModel& camera) {
  const auto require = [](bool is_good, const char* what) {
    if (!is_good) ThrowDoesNotFitBlob(what);
  };
  const size_t num = stack.values.size();
  require(camera.IsCentral(),
          "samples over the operating point must be central cameras");
  require(
      num == stack.cameras.size() && num >= RG_MIN_KNOTS && num <= RG_MAX_KNOTS,
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

// A camera and what its grids are fitted to.
struct GridTask {
  const CameraModel& camera;
  const RegularRegion* region;  // NULL: the format holds the camera as it is
  const ValidityMask* trusted;  // NULL: all
  const OperatingPointKnots* stack;  // NULL: none
  bool is_narrow_allowed = true;
  int num_threads = 0;
};

// The camera's own grid, and of a stack those of its knots, with which it then
// has area and size in common.
struct MadeGrids {
  std::vector<CentralGeneric> models;
  std::optional<ValidityMask> valid;  // as BlobGrid's, of all of them
  bool follows_all = true;

  const ValidityMask* ValidOr(const ValidityMask* trusted) const {
    return valid ? &*valid : trusted;
  }
  void Add(const BlobGrid& grid) {
    models.push_back(grid.grid);
    if (grid.valid) valid = grid.valid;
    follows_all &= grid.follows_all;
  }
};

MadeGrids MakeGrids(const GridTask& task, double max_error_px) {
  MadeGrids made;
  if (!task.stack) {
    made.Add(
        MakeBlobGrid(task.camera, task.region, task.trusted, max_error_px));
    return made;
  }
  const BSplineSurface& like = task.stack->cameras[0].surface();
  std::vector<CentralGeneric> cameras = {
      FitCentralGeneric(task.camera, like.area(), like.columns(), like.rows())};
  cameras.insert(cameras.end(), task.stack->cameras.begin(),
                 task.stack->cameras.end());
  for (const CentralGeneric& camera : cameras) {
    std::optional<RegularRegion> region;
    if (!IsBlobGrid(camera)) region.emplace(camera, task.num_threads);
    made.Add(MakeBlobGrid(camera, region ? &*region : nullptr,
                          made.ValidOr(task.trusted), max_error_px));
    const BSplineSurface& surface = made.models.back().surface();
    if (surface.columns() != like.columns() || surface.rows() != like.rows())
      ThrowDoesNotFitBlob(
          "the calibrated areas of the operating points differ by less than "
          "1/65536 px");
  }
  return made;
}

// Grids in the format's integers, which keep a bound in the runtime's
// arithmetic.
class BlobGrids {
 public:
  // Makes contents those of the first grid. Throws Error(kQuality).
  BlobGrids(const GridTask& task, double max_error_px,
            rg_blob_contents* contents) {
    constexpr int kTries = 3;
    double aimed_px = max_error_px;
    for (int k = 0; k < kTries; ++k, aimed_px /= 2) {
      made = MakeGrids(task, aimed_px);
      sections_.clear();
      for (const CentralGeneric& model : made.models)
        sections_.push_back(QuantizeGrid(model));
      contents->grid = &sections_[0].section;
      points.emplace(sections_, task.is_narrow_allowed, Truths(task),
                     max_error_px, task.num_threads, contents);
      if (points->error().px <= max_error_px) return;
    }
    throw Error(ExitCode::kQuality,
                fmt::format("unprojection error of packing would be {:.2g} px, "
                            "above the limit of {}",
                            points->error().px, max_error_px));
  }
  BlobGrids(const BlobGrids&) = delete;
  BlobGrids& operator=(const BlobGrids&) = delete;

  const rg_grid_section& section() const { return sections_[0].section; }
  std::vector<const BSplineSurface*> Surfaces() const {
    std::vector<const BSplineSurface*> surfaces;
    for (const CentralGeneric& model : made.models)
      surfaces.push_back(&model.surface());
    return surfaces;
  }

  MadeGrids made;
  std::optional<GridPoints> points;

 private:
  std::vector<PackingTruth> Truths(const GridTask& task) const {
    const ValidityMask* valid = made.ValidOr(task.trusted);
    std::vector<PackingTruth> truths = {{task.camera, made.models[0], valid}};
    for (size_t k = 1; k < made.models.size(); ++k)
      truths.push_back({task.stack->cameras[k - 1], made.models[k], valid});
    return truths;
  }

  std::vector<GridSection> sections_;
};

// Grids that follow the camera everywhere to what packing may add, or else as
// far as is allowed.
std::unique_ptr<BlobGrids> FitBlobGrids(const GridTask& task,
                                        double max_error_px,
                                        rg_blob_contents* contents) {
  auto grids = std::make_unique<BlobGrids>(
      task, std::min(kMaxPackingErrorPx, max_error_px), contents);
  if (!grids->made.follows_all && max_error_px > kMaxPackingErrorPx)
    grids = std::make_unique<BlobGrids>(task, max_error_px, contents);
  return grids;
}

// The part of the image that is calibrated, and trusted if there is a mask.
double PartOf(const CameraModel& camera, const ValidityMask* trusted) {
  ValidityMask mask =
      trusted ? *trusted : ValidityMask::Over(camera.image_size());
  if (!trusted) mask.is_trusted.assign(mask.is_trusted.size(), true);
  return CameraUncertainty::FromMask(mask).ValidFraction(camera.image_size(),
                                                         camera.area());
}

// How well a camera is known, as far as it is valid. A camera that is trusted
// nowhere stays so.
std::optional<CameraUncertainty> UncertaintyWithin(
    const std::optional<CameraUncertainty>& known, const ValidityMask* valid) {
  if (!valid || (known && !known->mask.HasValidCells())) return known;
  CameraUncertainty within =
      known ? *known : CameraUncertainty::FromMask(*valid);
  within.mask = *valid;
  return within;
}

// A remark on what a blob leaves out of the image, and why; nothing if it is
// nothing.
std::optional<std::string> WarnAboutLeftOut(const GridTask& task,
                                            const MadeGrids& made,
                                            double left_out_part,
                                            double max_error_px) {
  if (left_out_part <= 0) return std::nullopt;
  std::string why;
  if (task.region && !task.region->IsWhole())
    why = fmt::format(
        "the distortion folds or ends there, or rays are more than 151 degrees "
        "off axis ({:.2g} % of the calibrated area)",
        100 * (1 - task.region->Part()));
  if (!made.follows_all)
    why += fmt::format(
        "{}no grid represents the camera there within {} px (increase "
        "--max-error-px)",
        why.empty() ? "" : ", or ", max_error_px);
  return fmt::format(
      "{:.2g} % of the image is excluded by the validity mask: {}; remap "
      "tables contain the border value there",
      100 * left_out_part, why);
}

}  // namespace

void RequireBlobText(const char* what, const std::string& text) {
  const std::string place = fmt::format("{} '{}'", what, Printable(text));
  if (FindInvalidUtf8(text) != std::string::npos)
    throw Error(ExitCode::kUsage, place + ": must be UTF-8 text");
  if (text.size() >= RG_TEXT_SIZE)
    throw Error(ExitCode::kUsage, fmt::format("{}: must have at most {} bytes",
                                              place, RG_TEXT_SIZE - 1));
}

namespace {

// Packs a camera over several conditions: boards have a stack over one, which
// is the first.
PackedCamera PackOverFirst(const CameraFile& file, const PackOptions& options) {
  CameraFile along = file;
  along.stack = SliceOperatingPointModel(*file.stack, 0);
  PackedCamera packed = PackCamera(along, options);
  const std::vector<OperatingRange>& ranges = file.stack->cameras.ranges();
  const std::string other = OperatingParameterName(ranges[1].condition);
  packed.warnings.push_back(fmt::format(
      "a blob can vary with one quantity only: it varies with {}, at {} {:g} "
      "(centre of the range); select another value with pack --at {}=VALUE",
      OperatingParameterName(ranges[0].condition), other, ranges[1].Middle(),
      other));
  return packed;
}

}  // namespace

PackedCamera PackCamera(const CameraFile& file, const PackOptions& options) {
  if (file.stack && !options.stack && file.stack->cameras.ranges().size() > 1)
    return PackOverFirst(file, options);
  if (file.stack && !options.stack) {
    PackOptions with_stack = options;
    with_stack.stack = MakeModelKnots(file.stack->cameras);
    // A blob has one statement of how well its cameras are known.
    CameraFile known_everywhere = file;
    known_everywhere.uncertainty = ComputeMaxUncertainty(file);
    return PackCamera(known_everywhere, with_stack);
  }
  const CameraModel& camera = *file.camera;
  const auto* lines = dynamic_cast<const NonCentralGeneric*>(&camera);
  RequirePackable(camera);
  RequireFewTables(file, options);
  // The central part of a camera of lines, which sees far scenes.
  const std::optional<CentralGeneric> far =
      lines ? std::optional(CentralPart(camera)) : std::nullopt;
  const CameraModel& central = far ? *far : camera;
  const ValidityMask* own_trusted =
      file.uncertainty && file.uncertainty->mask.HasValidCells()
          ? &file.uncertainty->mask
          : nullptr;
  const int num_threads = NumThreads(options.num_threads);
  const std::function<void()> go_on = [&options] { ThrowIfStopped(options); };

  const OperatingPointKnots* stack = options.stack ? &*options.stack : nullptr;
  if (stack) RequireAlikeKnots(*stack, camera);
  const std::shared_ptr<const RegularRegion> region =
      IsBlobGrid(central)
          ? nullptr
          : std::make_shared<RegularRegion>(central, num_threads);
  // The part of the camera that tables show.
  const std::unique_ptr<CameraModel> shown =
      region && !region->IsWhole() && !region->IsEmpty()
          ? std::make_unique<RegularCamera>(central, region)
          : central.Clone();
  std::vector<const CameraModel*> cameras = {shown.get()};
  for (size_t k = 0; stack && k < stack->cameras.size(); ++k)
    cameras.push_back(&stack->cameras[k]);
  const std::string name = PaddedText("name", file.name);
  const std::string serial = PaddedText("serial", file.serial);
  const rg_camera_section identity = {
      static_cast<uint16_t>(camera.image_size().width),
      static_cast<uint16_t>(camera.image_size().height), name.data(),
      serial.data()};
  rg_blob_contents contents = {};
  contents.camera = &identity;
  const GridTask task = {
      central,    region.get(), own_trusted, stack, options.is_narrow_allowed,
      num_threads};
  const std::unique_ptr<BlobGrids> grids =
      FitBlobGrids(task, options.max_ray_error_px, &contents);
  const GridPoints& points = *grids->points;
  const ValidityMask* trusted = grids->made.ValidOr(own_trusted);

  PackedCamera packed;
  packed.unproject_error_px = points.error().px;
  packed.unproject_error_rad = points.error().rad;
  packed.left_out_part =
      PartOf(central, own_trusted) - PartOf(central, trusted);
  if (const auto warning = WarnAboutLeftOut(
          task, grids->made, packed.left_out_part,
          std::max(kMaxPackingErrorPx, options.max_ray_error_px)))
    packed.warnings.push_back(*warning);
  // To the pixels that look into a direction, also where those are of lines.
  const InverseSections inverse(grids->Surfaces(), points, trusted, num_threads,
                                go_on, &contents);
  packed.projection = inverse.error();
  if (const auto warning =
          WarnAboutProjection(packed.projection, trusted != nullptr))
    packed.warnings.push_back(*warning);
  RemapSections remaps;
  remaps.Fit(cameras, lines, options, options.shown ? &*options.shown : nullptr,
             num_threads, go_on, &packed);
  remaps.AddTo(&contents);

  const rg_quality_section quality = QuantizeQuality(file, points.error());
  contents.quality = &quality;
  std::vector<int32_t> line_points;
  if (lines) {
    line_points = QuantizeLinePoints(*lines, grids->made.models[0].surface());
    contents.line_points_q28 = line_points.data();
  }
  UncertaintySections sections;
  if (const auto known = UncertaintyWithin(file.uncertainty, trusted)) {
    sections = QuantizeUncertainty(*known, grids->section());
    sections.AddTo(&contents);
  }
  rg_capture_section capture;
  if (file.capture) {
    capture = QuantizeCapture(*file.capture);
    contents.capture = &capture;
  }
  std::vector<rg_knot_contents> knots;
  rg_stack_contents stack_contents = {};
  if (stack) {
    for (size_t k = 1; k <= stack->cameras.size(); ++k) {
      rg_knot_contents knot = {};
      knot.value_q16 =
          static_cast<int32_t>(std::lround(stack->values[k - 1] * 65536));
      points.Point(k, &knot);
      knot.inverse_points = inverse.points(k);
      knot.remaps = remaps.contents(k);
      knots.push_back(knot);
    }
    stack_contents.condition = static_cast<uint16_t>(stack->condition);
    stack_contents.num_knots = static_cast<uint16_t>(knots.size());
    stack_contents.knots = knots.data();
    contents.stack = &stack_contents;
  }
  rg_row_time_section line_delay;
  if (file.line_delay) {
    line_delay = QuantizeLineDelay(*file.line_delay);
    contents.row_time = &line_delay;
  }
  packed.blob = WriteBlob(contents);
  return packed;
}

PackedCamera PackSupportedParts(const CameraFile& file, int num_threads,
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
      PackedCamera packed = PackSupportedParts(alone, num_threads, should_stop);
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
