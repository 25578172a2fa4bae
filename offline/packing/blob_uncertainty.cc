#include "packing/blob_uncertainty.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "packing/blob_limits.h"

namespace raygrid {
namespace {

// Returns a metric in its integer unit, rounded up; RG_UNKNOWN_METRIC without a
// value.
uint32_t QuantizeMetric(std::optional<double> value, double unit) {
  if (!value) return RG_UNKNOWN_METRIC;
  return static_cast<uint32_t>(
      std::min(std::ceil(*value / unit), RG_UNKNOWN_METRIC - 1.0));
}

void QuantizeStdDevs(const UncertaintyLattice& lattice,
                     const rg_grid_section& grid,
                     UncertaintySections* sections) {
  rg_uncertainty_section& u = sections->uncertainty;
  u.columns = static_cast<uint16_t>(lattice.columns);
  u.rows = static_cast<uint16_t>(lattice.rows);
  u.scale_x_q32 = rg_grid_scale_q32(u.columns - 1u, grid.x1_q16 - grid.x0_q16);
  u.scale_y_q32 = rg_grid_scale_q32(u.rows - 1u, grid.y1_q16 - grid.y0_q16);
  for (const double value : lattice.stddev_px)
    sections->values_q12.push_back(
        std::isfinite(value)
            ? static_cast<uint16_t>(std::min(std::ceil(std::ldexp(value, 12)),
                                             RG_UNKNOWN_UNCERTAINTY - 1.0))
            : RG_UNKNOWN_UNCERTAINTY);
}

}  // namespace

void UncertaintySections::AddTo(rg_blob_contents* contents) {
  mask.bits = bits.data();
  contents->mask = &mask;
  if (values_q12.empty()) return;
  contents->uncertainty = &uncertainty;
  contents->uncertainties_q12 = values_q12.data();
}

UncertaintySections QuantizeUncertainty(const CameraUncertainty& known,
                                        const rg_grid_section& grid) {
  UncertaintySections sections;
  if (known.HasStdDevs()) QuantizeStdDevs(known.lattice, grid, &sections);
  const ValidityMask& mask = known.mask;
  sections.mask.columns = static_cast<uint16_t>(mask.columns);
  sections.mask.rows = static_cast<uint16_t>(mask.rows);
  sections.mask.cell_log2 =
      static_cast<uint8_t>(std::lround(std::log2(mask.knot_spacing_px)));
  sections.bits.assign((mask.is_valid.size() + 31) / 32 * 4, 0);
  for (size_t k = 0; k < mask.is_valid.size(); ++k)
    if (mask.is_valid[k]) sections.bits[k / 8] |= 1u << k % 8;
  return sections;
}

rg_row_time_section QuantizeLineDelay(const LineDelay& line_delay) {
  constexpr double kQ10PerSecond = 1024 * 1e9;
  rg_row_time_section section = {};
  section.row_time_ns_q10 =
      static_cast<int32_t>(std::lround(line_delay.seconds * kQ10PerSecond));
  section.stddev_ns_q10 =
      static_cast<uint32_t>(std::lround(line_delay.stddev_s * kQ10PerSecond));
  return section;
}

rg_capture_section QuantizeCapture(const Capture& capture) {
  const auto q16 = [](double value) { return std::lround(value * 65536); };
  rg_capture_section section = {};
  if (capture.lens_position) {
    section.known |= RG_CAPTURE_HAS_LENS_POSITION;
    section.lens_position_q16 =
        static_cast<int32_t>(q16(*capture.lens_position));
    section.lens_tolerance_q16 =
        static_cast<uint32_t>(q16(capture.lens_tolerance));
  }
  if (capture.crop) {
    section.known |= RG_CAPTURE_HAS_CROP;
    section.crop_x = (*capture.crop)[0];
    section.crop_y = (*capture.crop)[1];
    section.crop_width = static_cast<uint32_t>((*capture.crop)[2]);
    section.crop_height = static_cast<uint32_t>((*capture.crop)[3]);
  }
  if (capture.zoom) {
    section.known |= RG_CAPTURE_HAS_ZOOM;
    section.zoom_q16 = static_cast<uint32_t>(q16(*capture.zoom));
  }
  if (capture.orientation) {
    section.known |= RG_CAPTURE_HAS_ORIENTATION;
    section.orientation = static_cast<uint8_t>(*capture.orientation);
  }
  if (capture.sensor_temperature_c) {
    section.known |= RG_CAPTURE_HAS_TEMPERATURE;
    section.temperature_q16 =
        static_cast<int32_t>(q16(*capture.sensor_temperature_c));
  }
  if (capture.exposure_us) {
    section.known |= RG_CAPTURE_HAS_EXPOSURE;
    section.exposure_us =
        static_cast<uint32_t>(std::lround(*capture.exposure_us));
  }
  if (capture.analogue_gain) {
    section.known |= RG_CAPTURE_HAS_GAIN;
    section.analogue_gain_q16 =
        static_cast<uint32_t>(q16(*capture.analogue_gain));
  }
  return section;
}

rg_quality_section QuantizeQuality(const CameraFile& file,
                                   const UnprojectionError& packing) {
  const auto metric = [](const std::optional<ErrorMetrics>& metrics,
                         double ErrorMetrics::*member) {
    return QuantizeMetric(
        metrics ? std::optional((*metrics).*member) : std::nullopt, 1e-6);
  };
  const auto count = [](const std::optional<ErrorMetrics>& metrics) {
    return QuantizeMetric(
        metrics ? std::optional<double>(metrics->count) : std::nullopt, 1);
  };
  rg_quality_section quality = {};
  quality.training_median_upx = metric(file.training, &ErrorMetrics::median_px);
  quality.training_rms_upx = metric(file.training, &ErrorMetrics::rms_px);
  quality.training_max_upx = metric(file.training, &ErrorMetrics::max_px);
  quality.training_count = count(file.training);
  quality.held_out_median_upx = metric(file.held_out, &ErrorMetrics::median_px);
  quality.held_out_rms_upx = metric(file.held_out, &ErrorMetrics::rms_px);
  quality.held_out_max_upx = metric(file.held_out, &ErrorMetrics::max_px);
  quality.held_out_count = count(file.held_out);
  quality.packing_error_npx = QuantizeMetric(packing.px, 1e-9);
  quality.packing_error_prad = QuantizeMetric(packing.rad, 1e-12);
  return quality;
}

void RequireBlobText(const char* what, const std::string& text) {
  const std::string place = fmt::format("{} '{}'", what, Printable(text));
  if (FindInvalidUtf8(text) != std::string::npos)
    throw Error(ExitCode::kUsage, place + ": must be UTF-8 text");
  if (text.size() >= RG_TEXT_SIZE)
    throw Error(ExitCode::kUsage, fmt::format("{}: must have at most {} bytes",
                                              place, RG_TEXT_SIZE - 1));
}

std::string FormatPadded(const char* what, const std::string& text) {
  RequireBlobText(what, text);
  std::string padded = text;
  padded.resize(RG_TEXT_SIZE, '\0');
  return padded;
}

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

}  // namespace raygrid
