#include "packing/blob_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "bytes.h"
#include "camera/central_generic.h"
#include "camera/noncentral_generic.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

// Whether bytes begin with the magic number of blobs, or with a truncated one.
bool HasBlobMagic(const std::string& bytes) {
  const std::string magic = "RAYGRID";
  return bytes.compare(0, magic.size(), magic, 0, bytes.size()) == 0;
}

[[noreturn]] void ThrowReadError(const std::string& name, rg_status status) {
  throw Error(ExitCode::kInvalidBlob,
              fmt::format("{}: {}; pack it again from camera.yaml", name,
                          rg_status_text(status)));
}

// Returns the number of fraction bits, >= 0, with which coordinates are below
// 2^30.
int FractionBits(const Eigen::Vector3d& point) {
  int exponent = 0;
  std::frexp(point.cwiseAbs().maxCoeff(), &exponent);
  return std::min(30 - exponent, static_cast<int>(RG_POINT_MAX_BITS));
}

// Extracts one channel of interleaved pixels.
std::vector<uint8_t> Channel(const Image& image, int channel) {
  std::vector<uint8_t> plane(image.pixels.size() / image.channels);
  const int pixel_bytes = image.channels * image.sample_bytes;
  const uint8_t* from = image.pixels.data() + channel * image.sample_bytes;
  for (size_t i = 0; i < plane.size(); i += image.sample_bytes) {
    std::copy_n(from, image.sample_bytes, &plane[i]);
    from += pixel_bytes;
  }
  return plane;
}

void SetChannel(const std::vector<uint8_t>& plane, int channel, Image* image) {
  const int pixel_bytes = image->channels * image->sample_bytes;
  uint8_t* to = image->pixels.data() + channel * image->sample_bytes;
  for (size_t i = 0; i < plane.size(); i += image->sample_bytes) {
    std::copy_n(&plane[i], image->sample_bytes, to);
    to += pixel_bytes;
  }
}

}  // namespace

VirtualView GetTableView(const rg_remap_section& table) {
  VirtualView view;
  view.size = {table.width, table.height};
  if (table.direction == RG_DISTORT)
    view.size = {table.source_width, table.source_height};
  view.focal_px = Eigen::Vector2d(table.fx_q16, table.fy_q16) / 65536;
  view.center_px = Eigen::Vector2d(table.cx_q16, table.cy_q16) / 65536;
  static_assert(static_cast<int>(ViewProjection::kEquidistant) ==
                RG_PROJECTION_EQUIDISTANT);
  view.projection = static_cast<ViewProjection>(table.projection);
  for (int k = 0; k < 9; ++k)
    view.camera_from_view(k / 3, k % 3) =
        std::ldexp(static_cast<double>(table.rotation_q30[k]), -30);
  return view;
}

BlobCamera::BlobCamera(const std::string& name, const std::string& bytes)
    : words_((bytes.size() + 3) / 4 + 1) {
  std::memcpy(words_.data(), bytes.data(), bytes.size());
  const uint32_t size = static_cast<uint32_t>(bytes.size());
  rg_status status = rg_blob_open(words_.data(), size, &blob_);
  if (status == RG_OK) status = rg_camera_open(&camera_, words_.data(), size);
  // Files that are not blobs get this error even if they are short.
  if (status == RG_ERR_TRUNCATED && !HasBlobMagic(bytes)) status = RG_ERR_MAGIC;
  if (status != RG_OK) ThrowReadError(name, status);
}

std::optional<Eigen::Vector3d> BlobCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  const auto line = Line(pixel);
  return line ? std::optional(line->direction) : std::nullopt;
}

std::optional<ObservationLine> BlobCamera::Line(
    const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d q16 = pixel * 65536;
  if (!(q16.cwiseAbs().maxCoeff() < 2e9)) return std::nullopt;
  rg_line line;
  const rg_pixel position = {static_cast<int32_t>(std::lround(q16.x())),
                             static_cast<int32_t>(std::lround(q16.y()))};
  if (rg_unproject_line(&camera_, position, &line) != RG_OK)
    return std::nullopt;
  const rg_ray& ray = line.direction;
  return ObservationLine{
      Eigen::Vector3d(line.point_q28[0], line.point_q28[1], line.point_q28[2]) /
          (1 << RG_LINE_POINT_BITS),
      Eigen::Vector3d(ray.x_q30, ray.y_q30, ray.z_q30) / (1 << 30)};
}

std::optional<Eigen::Vector2d> BlobCamera::Project(
    const Eigen::Vector3d& point) const {
  const bool has_lines = camera_.line_points;
  const int bits = FractionBits(point);
  const Eigen::Vector3d scaled =
      has_lines ? Eigen::Vector3d(point * std::ldexp(1, bits))
                : Eigen::Vector3d(point.normalized() * (1 << 30));
  if (!scaled.allFinite()) return std::nullopt;
  const Eigen::Matrix<int32_t, 3, 1> rounded =
      scaled.array().round().cast<int32_t>();
  const rg_ray direction = {rounded.x(), rounded.y(), rounded.z()};
  rg_pixel pixel;
  if ((has_lines ? rg_project_point(&camera_, rounded.data(), std::max(bits, 0),
                                    &pixel)
                 : rg_project(&camera_, &direction, &pixel)) != RG_OK)
    return std::nullopt;
  return Eigen::Vector2d(pixel.x_q16, pixel.y_q16) / 65536;
}

std::optional<OperatingRange> BlobCamera::Range() const {
  if (blob_.stack == 0) return std::nullopt;
  rg_stack_section stack;
  rg_blob_stack(&blob_, &stack);
  const auto value = [&](int sample) {
    return rg_stack_sample_value(&stack, sample) / 65536.0;
  };
  return OperatingRange{stack.condition == RG_OPERATING_PARAMETER_TEMPERATURE
                            ? OperatingParameter::kTemperature
                            : OperatingParameter::kLensPosition,
                        value(0), value(stack.num_samples - 1)};
}

void BlobCamera::SetOperatingPoint(double value) {
  const rg_status status = rg_set_operating_point(
      &camera_, static_cast<int32_t>(std::lround(value * 65536)));
  if (status != RG_OK && status != RG_EXTRAPOLATED)
    ThrowReadError("stack", status);
}

// Returns a control point of the current grid, or of the same grid in a later
// sample.
Eigen::Vector2d BlobCamera::ControlPoint(const Eigen::Vector2i& place,
                                         int upper_sample) const {
  rg_blob there = blob_;
  there.grid = static_cast<uint32_t>(camera_.grid - blob_.bytes) +
               upper_sample * camera_.sample_size;
  int32_t point_q29[2];
  rg_blob_control_point(&there, place.x(), place.y(), point_q29);
  return Eigen::Vector2d(point_q29[0], point_q29[1]) /
         std::ldexp(1, RG_CONTROL_POINT_BITS);
}

std::unique_ptr<CameraModel> BlobCamera::ToModel() const {
  rg_grid_section grid;
  rg_blob_grid(&blob_, &grid);
  const Area area = {grid.x0_q16 / 65536.0, grid.y0_q16 / 65536.0,
                     grid.x1_q16 / 65536.0, grid.y1_q16 / 65536.0};
  BSplineSurface surface(area, grid.columns, grid.rows);
  const double weight = std::ldexp(camera_.weight_q14, -14);
  for (int k = 0; k < surface.num_points(); ++k) {
    const Eigen::Vector2i place(k % grid.columns, k / grid.columns);
    surface.points()[k] = ControlPoint(place, 0);
    if (weight > 0)
      surface.points()[k] +=
          weight * (ControlPoint(place, 1) - surface.points()[k]);
  }
  if (blob_.line_points == 0)
    return std::make_unique<CentralGeneric>(image_size(), std::move(surface));
  const uint8_t* const bytes = rg_blob_line_points(&blob_);
  std::vector<Eigen::Vector3d> points(surface.num_points());
  for (int k = 0; k < surface.num_points(); ++k)
    for (int c = 0; c < 3; ++c)
      points[k][c] =
          std::ldexp(rg_load_i32(bytes + RG_LINE_POINT_SIZE * k + 4 * c),
                     -static_cast<int>(RG_LINE_POINT_BITS));
  return std::make_unique<NonCentralGeneric>(image_size(), std::move(surface),
                                             std::move(points));
}

ImageSize BlobCamera::image_size() const {
  uint16_t width = 0, height = 0;
  rg_calibrated_size(&camera_, &width, &height);
  return {width, height};
}

uint32_t BlobCamera::NumRemaps() const {
  uint32_t count = 0;
  while (rg_find_section(blob_.bytes, RG_SECTION_REMAP, count)) ++count;
  return count;
}

std::vector<uint32_t> BlobCamera::ListCalibratedTables() const {
  std::vector<uint32_t> tables;
  for (uint32_t k = 0; k < NumRemaps(); ++k) {
    rg_remap_section remap;
    rg_read_remap(rg_find_section(blob_.bytes, RG_SECTION_REMAP, k), &remap);
    if (remap.mode == 0 && remap.direction == RG_UNDISTORT) tables.push_back(k);
  }
  return tables;
}

std::optional<ValidityMask> BlobCamera::GetValidityMask() const {
  if (blob_.mask == 0) return std::nullopt;
  rg_mask_section section;
  rg_blob_mask(&blob_, &section);
  ValidityMask mask;
  mask.knot_spacing_px = 1 << section.cell_log2;
  mask.columns = section.columns;
  mask.rows = section.rows;
  for (int k = 0; k < mask.columns * mask.rows; ++k)
    mask.is_valid.push_back((section.bits[k / 8] >> k % 8 & 1) != 0);
  return mask;
}

rg_camera BlobCamera::WithTable(uint32_t remap_index) const {
  rg_camera camera = camera_;
  const rg_status status = rg_select_remap(&camera, remap_index);
  if (status != RG_OK) ThrowReadError("blob", status);
  return camera;
}

std::optional<LineDelay> BlobCamera::GetRowTime() const {
  constexpr double kQ10PerSecond = 1024 * 1e9;
  int32_t row_time_ns_q10;
  uint32_t stddev_ns_q10;
  if (rg_line_delay(&camera_, &row_time_ns_q10, &stddev_ns_q10) != RG_OK)
    return std::nullopt;
  return LineDelay{row_time_ns_q10 / kQ10PerSecond,
                   stddev_ns_q10 / kQ10PerSecond};
}

std::optional<Capture> BlobCamera::GetCalibrationCapture() const {
  if (!blob_.capture) return std::nullopt;
  rg_capture_section section;
  rg_blob_capture(&blob_, &section);
  Capture capture;
  if (section.known & RG_CAPTURE_HAS_LENS_POSITION) {
    capture.lens_position = section.lens_position_q16 / 65536.0;
    capture.lens_tolerance = section.lens_tolerance_q16 / 65536.0;
  }
  if (section.known & RG_CAPTURE_HAS_CROP)
    capture.crop = {section.crop_x, section.crop_y,
                    static_cast<int>(section.crop_width),
                    static_cast<int>(section.crop_height)};
  if (section.known & RG_CAPTURE_HAS_ZOOM)
    capture.zoom = section.zoom_q16 / 65536.0;
  if (section.known & RG_CAPTURE_HAS_ORIENTATION)
    capture.orientation = section.orientation;
  if (section.known & RG_CAPTURE_HAS_TEMPERATURE)
    capture.sensor_temperature_c = section.temperature_q16 / 65536.0;
  if (section.known & RG_CAPTURE_HAS_EXPOSURE)
    capture.exposure_us = section.exposure_us;
  if (section.known & RG_CAPTURE_HAS_GAIN)
    capture.analogue_gain = section.analogue_gain_q16 / 65536.0;
  return capture;
}

VirtualView BlobCamera::GetRemapView(uint32_t remap_index) const {
  rg_remap_section remap;
  rg_read_remap(WithTable(remap_index).remap, &remap);
  return GetTableView(remap);
}

ImageSize BlobCamera::FrameSize(uint32_t remap_index) const {
  const rg_camera camera = WithTable(remap_index);
  return {camera.frame_width, camera.frame_height};
}

bool BlobCamera::IsInverseRemap(uint32_t remap_index) const {
  rg_remap_section remap;
  rg_read_remap(WithTable(remap_index).remap, &remap);
  return remap.direction == RG_DISTORT;
}

std::vector<SensorMode> BlobCamera::Modes() const {
  std::vector<SensorMode> modes;
  for (uint32_t k = 0; k < rg_blob_num_modes(&blob_); ++k) {
    rg_mode_section section;
    rg_blob_mode(&blob_, k, &section);
    modes.push_back(
        {section.name,
         {section.width, section.height},
         Eigen::Vector2d(section.offset_x_q16, section.offset_y_q16) / 65536,
         Eigen::Vector2d(section.scale_x_q16, section.scale_y_q16) / 65536,
         section.flip_x != 0,
         section.flip_y != 0});
  }
  return modes;
}

std::optional<SensorMode> BlobCamera::GetRemapMode(uint32_t remap_index) const {
  rg_remap_section remap;
  rg_read_remap(WithTable(remap_index).remap, &remap);
  if (!remap.has_view || remap.mode == 0) return std::nullopt;
  return Modes()[remap.mode - 1];
}

std::optional<uint32_t> BlobCamera::FindModeTable(
    const std::string& name) const {
  const std::vector<SensorMode> modes = Modes();
  for (uint32_t k = 0;; ++k) {
    const uint8_t* const section =
        rg_find_section(blob_.bytes, RG_SECTION_REMAP, k);
    if (!section) return std::nullopt;
    rg_remap_section remap;
    rg_read_remap(section, &remap);
    if (remap.mode != 0 && remap.direction == RG_UNDISTORT &&
        modes[remap.mode - 1].name == name)
      return k;
  }
}

Image BlobCamera::Undistort(const Image& image, uint8_t border,
                            uint32_t remap_index) const {
  uint16_t width = 0, height = 0;
  const rg_camera camera = WithTable(remap_index);
  rg_remap_size(&camera, &width, &height);
  Image result;
  result.size = {width, height};
  result.channels = image.channels;
  result.sample_bytes = image.sample_bytes;
  result.pixels.resize(result.stride() * height);
  std::vector<uint8_t> plane(result.pixels.size() / image.channels);
  for (int channel = 0; channel < image.channels; ++channel) {
    const std::vector<uint8_t> source = Channel(image, channel);
    rg_image frame = {};
    frame.format = image.sample_bytes == 1 ? RG_FORMAT_GREY8 : RG_FORMAT_GREY16;
    frame.width = static_cast<uint16_t>(image.size.width);
    frame.height = static_cast<uint16_t>(image.size.height);
    frame.planes[0] = {
        source.data(),
        static_cast<uint32_t>(image.size.width * image.sample_bytes)};
    rg_target target = {};
    target.planes[0] = {plane.data(),
                        static_cast<uint32_t>(width * image.sample_bytes)};
    target.num_rows = height;
    target.border_values[0] = border;
    const rg_status status = rg_remap(&camera, &frame, &target);
    if (status != RG_OK) ThrowReadError("image", status);
    SetChannel(plane, channel, &result);
  }
  return result;
}

bool IsBlob(const std::string& path, const std::string& bytes) {
  const std::string extension = ".raygrid";
  return bytes.compare(0, 7, "RAYGRID") == 0 ||
         (path.size() >= extension.size() &&
          path.compare(path.size() - extension.size(), extension.size(),
                       extension) == 0);
}

}  // namespace raygrid
