#include "packing/pack.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "bytes.h"
#include "camera/central_generic.h"
#include "camera/noncentral_generic.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "dataset/text_encoding.h"
#include "packing/blob_camera.h"
#include "packing/inverse_grid.h"
#include "packing/narrow_grid.h"
#include "packing/remap_fitting.h"
#include "raygrid.h"
#include "rg_blob.h"

namespace raygrid {
namespace {

constexpr double kMaxMeasuredPixels = 1.6e7;

[[noreturn]] void FailFormat(const std::string& what) {
  throw Error(ExitCode::kQuality, "this camera does not fit a blob: " + what);
}

int32_t Q16(double value) {
  return static_cast<int32_t>(std::lround(value * 65536));
}

// The area inside camera's that the format can say.
Area RepresentableArea(const Area& area) {
  constexpr double kUnit = 65536;
  return {
      std::ceil(area.x0 * kUnit) / kUnit, std::ceil(area.y0 * kUnit) / kUnit,
      std::floor(area.x1 * kUnit) / kUnit, std::floor(area.y1 * kUnit) / kUnit};
}

// The worst angle-times-focal-length between a model and its grid, where it is
// trusted, if it is anywhere.
double FitError(const CameraModel& model, const TrustMask* trusted,
                const CentralGeneric& grid) {
  double worst = 0;
  const Area& area = grid.area();
  for (int j = 0; j <= 60; ++j) {
    for (int i = 0; i <= 80; ++i) {
      const Eigen::Vector2d pixel(area.x0 + area.width() * i / 80,
                                  area.y0 + area.height() * j / 60);
      if (trusted && !trusted->Trusts(pixel)) continue;
      const auto ray = model.Unproject(pixel);
      if (!ray) continue;
      const auto image = grid.Project(*ray, &pixel, 5);
      worst = std::max(worst, image ? (*image - pixel).norm() : INFINITY);
    }
  }
  return worst;
}

// The camera as a grid over a representable area.
CentralGeneric AsGrid(const CameraModel& camera, const TrustMask* trusted) {
  const Area area = RepresentableArea(camera.area());
  const auto* grid = dynamic_cast<const CentralGeneric*>(&camera);
  if (grid && area.x0 == camera.area().x0 && area.y0 == camera.area().y0 &&
      area.x1 == camera.area().x1 && area.y1 == camera.area().y1)
    return *grid;
  double error = INFINITY;
  for (int half_log2 = 2; half_log2 <= 14; ++half_log2) {
    const double cell_px = std::max(area.width(), area.height()) /
                           std::exp2(half_log2 / 2.0);  // 2 to 128 cells
    CentralGeneric fit =
        FitCentralGeneric(camera, area, NumControlPoints(area.width(), cell_px),
                          NumControlPoints(area.height(), cell_px));
    error = FitError(camera, trusted, fit);
    if (error <= kMaxPackingErrorPx / 2) return fit;
  }
  throw Error(ExitCode::kQuality,
              fmt::format("no grid follows this {} camera {}; is it valid over "
                          "its whole area?",
                          camera.Name(),
                          std::isfinite(error)
                              ? fmt::format("closer than {:.4f} px", error)
                              : "and leads back to its pixels"));
}

// Whether a trusted cell's rays depend on a control point of the grid: within
// two of its cells.
bool IsTrustedNear(const TrustMask& mask, const BSplineSurface& surface,
                   int index) {
  const Eigen::Array2d reach =
      2 * Eigen::Array2d(surface.cell_width(), surface.cell_height()) +
      mask.cell_px / 2.0;
  for (size_t k = 0; k < mask.is_trusted.size(); ++k) {
    const Eigen::Array2d distance =
        mask.CellCenter(static_cast<int>(k)) - surface.PixelOf(index);
    if (mask.is_trusted[k] && (distance.abs() < reach).all()) return true;
  }
  return false;
}

// Draws control points beyond what the format holds back to it, where no
// trusted pixel sees by them: as in the corners around a fisheye's image
// circle.
void DrawIntoChart(const TrustMask* trusted, CentralGeneric* grid) {
  const double limit =
      std::ldexp(RG_CONTROL_POINT_LIMIT - 1.0, -RG_CONTROL_POINT_BITS);
  BSplineSurface surface = grid->surface();
  for (int index = 0; index < surface.num_points(); ++index) {
    Eigen::Vector2d& point = surface.points()[index];
    const double largest = point.cwiseAbs().maxCoeff();
    if (largest <= limit) continue;
    if (!std::isfinite(largest) || !trusted ||
        IsTrustedNear(*trusted, surface, index))
      FailFormat("it looks farther back than 151 degrees from its axis");
    point *= limit / largest;
  }
  *grid = CentralGeneric(grid->image_size(), surface);
}

struct GridSection {
  rg_grid_section section = {};
  ControlPoints control_points;
};

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
    FailFormat("its cells are not larger than a pixel");
  s.scale_x_q32 = rg_grid_scale_q32(s.columns - 3u, s.x1_q16 - s.x0_q16);
  s.scale_y_q32 = rg_grid_scale_q32(s.rows - 3u, s.y1_q16 - s.y0_q16);
  for (const Eigen::Vector2d& point : camera.surface().points()) {
    for (int c = 0; c < 2; ++c)
      grid.control_points.values.push_back(static_cast<int32_t>(
          std::lround(std::ldexp(point[c], RG_CONTROL_POINT_BITS))));
  }
  return grid;
}

// The points of a camera's lines, fitted anew if the grid is another one.
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
        FailFormat("its lines lie farther than 7.9 m from its centre");
      quantized.push_back(static_cast<int32_t>(std::lround(value)));
    }
  }
  return quantized;
}

// A zero-padded text of RG_TEXT_SIZE bytes.
std::string PaddedText(const char* what, const std::string& text) {
  RequireBlobText(what, text);
  std::string padded = text;
  padded.resize(RG_TEXT_SIZE, '\0');
  return padded;
}

// A figure in its integer unit, rounded up; unknown if there is none.
uint32_t Figure(std::optional<double> value, double unit) {
  if (!value) return RG_UNKNOWN_FIGURE;
  return static_cast<uint32_t>(
      std::min(std::ceil(*value / unit), RG_UNKNOWN_FIGURE - 1.0));
}

struct UncertaintySections {
  rg_uncertainty_section uncertainty = {};
  rg_mask_section mask = {};
  std::vector<uint16_t> values_q12;
  std::vector<uint8_t> bits;
};

UncertaintySections QuantizeUncertainty(const CameraUncertainty& known,
                                        const rg_grid_section& grid) {
  UncertaintySections sections;
  rg_uncertainty_section& u = sections.uncertainty;
  u.columns = static_cast<uint16_t>(known.lattice.columns);
  u.rows = static_cast<uint16_t>(known.lattice.rows);
  u.scale_x_q32 = rg_grid_scale_q32(u.columns - 1u, grid.x1_q16 - grid.x0_q16);
  u.scale_y_q32 = rg_grid_scale_q32(u.rows - 1u, grid.y1_q16 - grid.y0_q16);
  for (const double value : known.lattice.deviation_px)
    sections.values_q12.push_back(
        std::isfinite(value)
            ? static_cast<uint16_t>(std::min(std::ceil(std::ldexp(value, 12)),
                                             RG_UNKNOWN_UNCERTAINTY - 1.0))
            : RG_UNKNOWN_UNCERTAINTY);

  const TrustMask& mask = known.mask;
  sections.mask.columns = static_cast<uint16_t>(mask.columns);
  sections.mask.rows = static_cast<uint16_t>(mask.rows);
  sections.mask.cell_log2 =
      static_cast<uint8_t>(std::lround(std::log2(mask.cell_px)));
  sections.bits.assign((mask.is_trusted.size() + 31) / 32 * 4, 0);
  for (size_t k = 0; k < mask.is_trusted.size(); ++k)
    if (mask.is_trusted[k]) sections.bits[k / 8] |= 1u << k % 8;
  return sections;
}

rg_quality_section QualityOf(const CameraFile& file, double error_px,
                             double error_rad) {
  const auto figure = [](const std::optional<ErrorFigures>& figures,
                         double ErrorFigures::*member) {
    return Figure(figures ? std::optional((*figures).*member) : std::nullopt,
                  1e-6);
  };
  rg_quality_section quality = {};
  quality.training_median_upx = figure(file.training, &ErrorFigures::median_px);
  quality.training_rms_upx = figure(file.training, &ErrorFigures::rms_px);
  quality.training_max_upx = figure(file.training, &ErrorFigures::max_px);
  quality.training_count = file.training ? file.training->count : 0;
  quality.held_out_median_upx = figure(file.held_out, &ErrorFigures::median_px);
  quality.held_out_rms_upx = figure(file.held_out, &ErrorFigures::rms_px);
  quality.held_out_max_upx = figure(file.held_out, &ErrorFigures::max_px);
  quality.held_out_count = file.held_out ? file.held_out->count : 0;
  quality.packing_error_npx = Figure(error_px, 1e-9);
  quality.packing_error_prad = Figure(error_rad, 1e-12);
  return quality;
}

struct UnprojectionError {
  double px = 0, rad = 0;
};

bool TrustsAny(const TrustMask& mask) {
  return std::find(mask.is_trusted.begin(), mask.is_trusted.end(), true) !=
         mask.is_trusted.end();
}

// How many pixels lie along a radian of rays where they turn fastest, across
// the middle of the area; a fisheye's are alike everywhere in its image circle.
double FewestPixelsPerRadian(const CameraModel& camera) {
  constexpr int kSteps = 16;
  const Area& area = camera.area();
  const auto ray_at = [&](int step) {
    return camera.Unproject(
        {area.x0 + area.width() * step / kSteps, (area.y0 + area.y1) / 2});
  };
  double fewest = INFINITY;
  for (int k = 0; k < kSteps; ++k) {
    const auto from = ray_at(k), to = ray_at(k + 1);
    if (from && to)
      fewest =
          std::min(fewest, area.width() / kSteps / from->cross(*to).norm());
  }
  return fewest;
}

// What a blob is measured against: where it is trusted, if it is anywhere, the
// camera, elsewhere what is left of it there.
struct PackingTruth {
  const CameraModel& camera;
  const CameraModel& elsewhere;
  const TrustMask* trusted;

  bool Trusts(const Eigen::Vector2d& pixel) const {
    return !trusted || trusted->Trusts(pixel);
  }
};

// The runtime against the truth, at every pixel of the blob's area, in those of
// more than kMaxMeasuredPixels every few rows and columns; in pixels where it
// is trusted, and not where rays hardly turn from pixel to pixel, as outside a
// fisheye's image circle.
UnprojectionError MeasureUnprojection(const PackingTruth& truth,
                                      const rg_camera& packed,
                                      int num_threads) {
  // The grid section begins with the area's two lower ends and two upper ones.
  const auto end_px = [&](int k) {
    return rg_load_i32(packed.grid + 4 * k) / 65536.0;
  };
  const int first = static_cast<int>(std::ceil(end_px(0)));
  const int first_row = static_cast<int>(std::ceil(end_px(1)));
  const int last = static_cast<int>(std::floor(end_px(2)));
  const int last_row = static_cast<int>(std::floor(end_px(3)));
  const double num_pixels = std::max(
      1.0, static_cast<double>(last - first + 1) * (last_row - first_row + 1));
  const int step =
      static_cast<int>(std::ceil(std::sqrt(num_pixels / kMaxMeasuredPixels)));
  const int num_rows = (last_row - first_row) / step + 1;
  constexpr double kHardlyTurn = 20;
  const double most_per_radian =
      kHardlyTurn * FewestPixelsPerRadian(truth.camera);
  std::vector<UnprojectionError> worst(std::max(num_rows, 0));
  ParallelFor(num_rows, num_threads, [&](int row) {
    const int y = first_row + step * row;
    for (int x = first; x <= last; x += step) {
      const Eigen::Vector2d pixel(x, y);
      const bool is_trusted = truth.Trusts(pixel);
      const CameraModel& camera = is_trusted ? truth.camera : truth.elsewhere;
      const auto exact = camera.Unproject(pixel);
      LinearizedProjection projection;
      rg_ray ray;
      if (!exact || !camera.Linearize(*exact, &pixel, 1, &projection) ||
          rg_unproject(&packed, {x * 65536, y * 65536}, &ray) != RG_OK)
        continue;
      const Eigen::Vector3d direction =
          Eigen::Vector3d(ray.x_q30, ray.y_q30, ray.z_q30) / (1 << 30);
      worst[row].rad = std::max(worst[row].rad, direction.cross(*exact).norm());
      if (is_trusted && projection.by_point.norm() < most_per_radian)
        worst[row].px =
            std::max(worst[row].px, (projection.by_point * direction).norm());
    }
  });
  UnprojectionError total;
  for (const UnprojectionError& error : worst) {
    total.px = std::max(total.px, error.px);
    total.rad = std::max(total.rad, error.rad);
  }
  return total;
}

// Whether the format holds the contents with these control points.
bool IsWritable(const rg_blob_contents& contents) {
  std::vector<uint32_t> words((rg_blob_size(&contents) + 3) / 4);
  return rg_blob_write(&contents, words.data(),
                       static_cast<uint32_t>(4 * words.size())) == RG_OK;
}

std::string WriteBlob(const rg_blob_contents& contents) {
  const uint32_t size = rg_blob_size(&contents);
  std::vector<uint32_t> words((size + 3) / 4);
  const rg_status status = rg_blob_write(&contents, words.data(), size);
  if (status != RG_OK) FailFormat(rg_status_text(status));
  return std::string(reinterpret_cast<const char*>(words.data()), size);
}

// Why projection is not what the runtime promises; nothing if it is.
std::optional<std::string> RemarkOnProjection(const ProjectionError& error,
                                              bool has_mask) {
  const FoundPixels& pixels = error.trusted;
  const int64_t num_all = pixels.num_pixels + pixels.num_unfindable;
  std::string faults;
  const auto add = [&](int64_t count, const std::string& what) {
    if (count > 0)
      faults += fmt::format("{}{:.2g} % {}", faults.empty() ? "" : ", ",
                            100.0 * count / num_all, what);
  };
  add(pixels.num_lost, "are not found");
  add(pixels.num_off, fmt::format("are off by more than {} px, up to {:.2g} px",
                                  kMaxProjectionErrorPx, pixels.worst_px));
  add(pixels.num_unfindable,
      "cannot be found, because others look where they do, or they look 151 "
      "degrees from the axis");
  if (faults.empty()) return std::nullopt;
  return fmt::format(
      "projection does not lead back to all {} pixels: {}; images with the "
      "board there, or a larger --cell-px, make the camera smoother",
      has_mask ? "trusted" : "of the area's", faults);
}

// Adds the inverse grid that leads back to the pixels of contents.
class InverseSection {
 public:
  InverseSection(const BSplineSurface& surface, const TrustMask* trusted,
                 int num_threads, const std::function<void()>& go_on,
                 rg_blob_contents* contents)
      : contents_(contents) {
    inverse_ = FitInverseGrid(
        surface, trusted, [&](const InverseGrid& grid, double max_pixels) {
          go_on();
          Point(grid);
          return IsWritable(*contents_)
                     ? std::optional(MeasureProjection(
                           BlobCamera("blob", WriteBlob(*contents_)), trusted,
                           max_pixels, num_threads))
                     : std::nullopt;
        });
    contents_->inverse = nullptr;
    if (inverse_) Point(inverse_->grid);
  }
  InverseSection(const InverseSection&) = delete;
  InverseSection& operator=(const InverseSection&) = delete;

  std::optional<ProjectionError> error() const {
    return inverse_ ? std::optional(inverse_->error) : std::nullopt;
  }

 private:
  void Point(const InverseGrid& grid) {
    points_ = grid.points.section;
    points_.residuals = grid.points.residuals.data();
    contents_->inverse = &grid.section;
    contents_->inverse_points = &points_;
  }

  rg_blob_contents* const contents_;
  std::optional<MeasuredInverse> inverse_;
  rg_narrow_grid points_ = {};
};

// Remap tables as rg_blob_write() takes them.
class RemapSections {
 public:
  PackedRemap Add(RemapTable table) {
    const rg_remap_section& s = table.section;
    const int block_size = 1 << s.block_log2;
    const PackedRemap packed = {
        {s.width, s.height},
        table.max_error_px,
        table.max_chroma_error_px,
        block_size,
        s.part_log2 != 0 ? 1 << s.part_log2 : block_size};
    tables_.push_back(std::move(table));
    return packed;
  }

  // What it points to lives as long as this, until the next Add().
  void AddTo(rg_blob_contents* contents) {
    for (RemapTable& table : tables_) {
      table.section.empty_blocks = table.empty_blocks.data();
      table.section.bends = table.bends.data();
      contents_.push_back({&table.section, table.residuals.data()});
    }
    if (contents_.empty()) return;
    contents->remap = contents_[0].section;
    contents->residuals = contents_[0].residuals;
    contents->more_remaps = contents_.data() + 1;
    contents->num_more_remaps = static_cast<uint32_t>(contents_.size() - 1);
  }

 private:
  std::vector<RemapTable> tables_;
  std::vector<rg_remap_contents> contents_;
};

// Of the view that is as sharp as the image, or of the calibrated area's.
std::optional<RemapTable> FitDefaultTable(const CameraModel& camera,
                                          double max_error_px, int num_threads,
                                          const std::function<void()>& go_on,
                                          std::vector<std::string>* remarks) {
  std::string fault;
  try {
    return FitRemapTable(camera, MakeVirtualCamera(camera, {}, 0), max_error_px,
                         num_threads, go_on);
  } catch (const Error& error) {
    fault = error.what();
  }
  try {
    RemapTable table = FitRemapTable(camera, MakeVirtualCameraOfArea(camera),
                                     max_error_px, num_threads, go_on);
    remarks->push_back(
        "its undistortion table shows the calibrated area alone, which lies "
        "far from where the camera looks, or too close to the side");
    return table;
  } catch (const Error&) {
    remarks->push_back(
        "has no undistortion table, which raygrid pack --remap may make of "
        "another view: " +
        fault);
    return std::nullopt;
  }
}

UnprojectionError MeasureBlob(const PackingTruth& truth,
                              const std::string& blob, int num_threads) {
  std::vector<uint32_t> words((blob.size() + 3) / 4);
  std::memcpy(words.data(), blob.data(), blob.size());
  rg_camera packed;
  const rg_status status =
      rg_camera_open(&packed, words.data(), static_cast<uint32_t>(blob.size()));
  if (status != RG_OK) FailFormat(rg_status_text(status));
  return MeasureUnprojection(truth, packed, num_threads);
}

}  // namespace

void RequireBlobText(const char* what, const std::string& text) {
  const std::string place = fmt::format("{} '{}'", what, Printable(text));
  if (FindNoUtf8(text) != std::string::npos)
    throw Error(ExitCode::kUsage, place + ": not UTF-8 text; give another");
  if (text.size() >= RG_TEXT_SIZE)
    throw Error(ExitCode::kUsage,
                fmt::format("{}: at most {} bytes", place, RG_TEXT_SIZE - 1));
}

PackedCamera PackCamera(const CameraFile& file, const PackOptions& options) {
  const CameraModel& camera = *file.camera;
  const auto* lines = dynamic_cast<const NonCentralGeneric*>(&camera);
  if (!camera.IsCentral() && !lines)
    throw Error(ExitCode::kQuality,
                fmt::format("a {} camera cannot be packed; fit it with "
                            "noncentral-generic first",
                            camera.Name()));
  if (camera.image_size().width > static_cast<int>(RG_MAX_IMAGE_SIZE) ||
      camera.image_size().height > static_cast<int>(RG_MAX_IMAGE_SIZE))
    FailFormat(fmt::format("images are at most {} px wide and high",
                           RG_MAX_IMAGE_SIZE));
  // What a camera of lines sees of far scenes.
  const std::optional<CentralGeneric> far =
      lines ? std::optional(lines->CentralPart()) : std::nullopt;
  const CameraModel& central = far ? *far : camera;
  const TrustMask* trusted =
      file.uncertainty && TrustsAny(file.uncertainty->mask)
          ? &file.uncertainty->mask
          : nullptr;
  CentralGeneric model = AsGrid(central, trusted);
  DrawIntoChart(trusted, &model);
  const PackingTruth truth = {central, model, trusted};
  const GridSection grid = QuantizeGrid(model);
  const std::string name = PaddedText("name", file.name);
  const std::string serial = PaddedText("serial", file.serial);
  const rg_camera_section identity = {
      static_cast<uint16_t>(camera.image_size().width),
      static_cast<uint16_t>(camera.image_size().height), name.data(),
      serial.data()};
  rg_blob_contents contents = {};
  contents.camera = &identity;
  contents.grid = &grid.section;
  contents.control_points_q29 = grid.control_points.values.data();
  PackedCamera packed;
  // Control points of 16 bits where they keep the bound.
  const int num_threads = NumThreads(options.num_threads);
  const auto go_on = [&options] {
    if (options.should_stop && options.should_stop())
      throw Error(ExitCode::kNotConverged,
                  "interrupted before the camera was packed; pack makes the "
                  "blob of camera.yaml");
  };
  std::optional<NarrowGrid> narrow;
  if (options.is_narrow_allowed) narrow = Narrow(grid.control_points);
  UnprojectionError error = {INFINITY, INFINITY};
  if (narrow) {
    narrow->section.residuals = narrow->residuals.data();
    contents.narrow = &narrow->section;
    if (IsWritable(contents))
      error = MeasureBlob(truth, WriteBlob(contents), num_threads);
  }
  if (!(error.px <= kMaxPackingErrorPx && error.rad <= kMaxNarrowErrorRad)) {
    contents.narrow = nullptr;
    error = MeasureBlob(truth, WriteBlob(contents), num_threads);
  }
  packed.unproject_error_px = error.px;
  packed.unproject_error_rad = error.rad;
  if (error.px > kMaxPackingErrorPx)
    throw Error(
        ExitCode::kQuality,
        fmt::format("packing would add {:.4f} px to un-projection, more "
                    "than {}",
                    error.px, kMaxPackingErrorPx));

  // To the pixels that look into a direction, also where those are of lines.
  const InverseSection inverse(model.surface(), trusted, num_threads, go_on,
                               &contents);
  packed.projection = inverse.error();
  const std::optional<std::string> remark =
      packed.projection
          ? RemarkOnProjection(*packed.projection, trusted != nullptr)
          : "no inverse grid of 16 bits leads back to its pixels: the blob "
            "does not project";
  if (remark) packed.remarks.push_back(*remark);

  RemapSections remaps;
  for (const VirtualCamera& virtual_camera : options.remaps)
    packed.remaps.push_back(remaps.Add(FitRemapTable(
        central, virtual_camera, options.max_error_px, num_threads, go_on)));
  if (options.has_default_remap)
    if (auto table = FitDefaultTable(central, options.max_error_px, num_threads,
                                     go_on, &packed.remarks))
      packed.remaps.push_back(remaps.Add(*std::move(table)));
  remaps.AddTo(&contents);

  const rg_quality_section quality = QualityOf(file, error.px, error.rad);
  contents.quality = &quality;
  std::vector<int32_t> line_points;
  if (lines) {
    line_points = QuantizeLinePoints(*lines, model.surface());
    contents.line_points_q28 = line_points.data();
  }
  UncertaintySections sections;
  if (file.uncertainty) {
    sections = QuantizeUncertainty(*file.uncertainty, grid.section);
    sections.mask.bits = sections.bits.data();
    contents.uncertainty = &sections.uncertainty;
    contents.uncertainties_q12 = sections.values_q12.data();
    contents.mask = &sections.mask;
  }
  packed.blob = WriteBlob(contents);
  return packed;
}

PackedCamera PackWhatCanBe(const CameraFile& file, int num_threads,
                           const std::function<bool()>& should_stop) {
  PackOptions options;
  options.num_threads = num_threads;
  options.should_stop = should_stop;
  options.has_default_remap = true;
  try {
    return PackCamera(file, options);
  } catch (const Error& error) {
    PackedCamera none;
    none.remarks = {fmt::format("is left out: {}", error.what())};
    return none;
  }
}

}  // namespace raygrid
