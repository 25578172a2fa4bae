#include "evaluation/noncentrality.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "dataset/error.h"
#include "experiments/calibrated_cameras.h"
#include "experiments/montage.h"
#include "report/color_scale.h"

namespace raygrid {
namespace {

constexpr double kDistancesM[] = {0.1, 0.2, 0.3, 0.5, 1, 2, 5, 10, 100};

// A non-central camera, and the conditions that describe its origin.
struct Camera {
  std::shared_ptr<const CameraModel> model;
  std::vector<Condition> conditions;
};

Camera CalibrateLines(const ExperimentOptions& options) {
  constexpr int kCells = 8;
  const ExperimentFeatures features = SelectFeatures(options, "glass");
  Camera camera = {nullptr, features.conditions};
  for (const char* model :
       {models::kCentralGeneric, models::kNonCentralGeneric}) {
    const CalibrationResult result =
        CalibrateModel(features, {model, kCells}, options);
    camera.conditions.push_back(
        {model, fmt::format("held-out median {:.3g} px, RMS {:.3g} px",
                            result.camera.held_out->median_px,
                            result.camera.held_out->rms_px)});
    camera.model = result.camera.camera;
  }
  return camera;
}

Camera GetCamera(const ExperimentOptions& options) {
  if (options.data.cameras.empty()) return CalibrateLines(options);
  const auto& camera = options.data.cameras.front().model;
  if (camera->IsCentral())
    throw InputError(
        "the camera is central; calibrate with --model noncentral-generic, or "
        "specify --features");
  return {camera, {{"camera", "user-provided, " + camera->Name()}}};
}

struct ProjectionErrors {
  double rms_px = 0, max_px = 0;
};

// Returns the error at distance_m of a central camera that is located at the
// point closest to all observation lines, and exact at right_at_m.
ProjectionErrors ComputeProjectionErrors(const CameraModel& camera,
                                         const Eigen::Vector3d& center,
                                         double right_at_m, double distance_m) {
  constexpr int kSteps = 40;
  ProjectionErrors errors;
  int count = 0;
  const Area& area = camera.area();
  for (int k = 0; k < (kSteps + 1) * (kSteps + 1); ++k) {
    const Eigen::Vector2d pixel(
        area.x0 + area.width() * (k % (kSteps + 1)) / kSteps,
        area.y0 + area.height() * (k / (kSteps + 1)) / kSteps);
    const auto line = camera.Line(pixel);
    if (!line) continue;
    // The point of the line that is closest to the centre.
    const Eigen::Vector3d start =
        line->origin +
        line->direction * line->direction.dot(center - line->origin);
    const auto seen_from_center = [&](double distance) {
      return (start + distance * line->direction - center).normalized();
    };
    const Eigen::Vector3d point = start + distance_m * line->direction;
    LinearizedProjection linear;
    if (!camera.Linearize(point, &pixel, 1, &linear)) continue;
    const double error_px =
        (linear.J_point * distance_m *
         (seen_from_center(right_at_m) - seen_from_center(distance_m)))
            .norm();
    errors.rms_px += error_px * error_px;
    errors.max_px = std::max(errors.max_px, error_px);
    ++count;
  }
  errors.rms_px = std::sqrt(errors.rms_px / std::max(1, count));
  return errors;
}

std::vector<double> ListOffsetsMm(const CameraModel& camera,
                                  const Eigen::Vector3d& center, int columns,
                                  int rows) {
  const Area& area = camera.area();
  std::vector<double> offsets;
  for (int k = 0; k < columns * rows; ++k) {
    const auto line =
        camera.Line({area.x0 + area.width() * (k % columns + 0.5) / columns,
                     area.y0 + area.height() * (k / columns + 0.5) / rows});
    offsets.push_back(
        line ? 1000 * line->direction.cross(line->origin - center).norm()
             : NAN);
  }
  return offsets;
}

}  // namespace

ExperimentResult MeasureNoncentrality(const ExperimentOptions& options) {
  constexpr double kBoardM = 0.5, kInfinitelyFarM = 1e4;
  const Camera camera = GetCamera(options);
  const Noncentrality spread = ComputeNoncentrality(*camera.model);
  ExperimentResult table;
  table.conditions = camera.conditions;
  table.conditions.push_back(
      {"lines",
       fmt::format(
           "distance from their common point {:.3f} mm RMS, {:.3f} mm max",
           1000 * spread.rms_m, 1000 * spread.max_m)});
  table.columns = {"distance_m", "right_far_rms_px", "right_far_max_px",
                   "right_at_half_metre_rms_px", "right_at_half_metre_max_px"};
  table.chart.title = "Error of a central model, by distance";
  table.chart.note =
      "RMS over the image, of a central camera exact at infinity or at 0.5 m";
  table.chart.x_label = "distance, m";
  table.chart.y_label = "error, px";
  table.chart.is_logarithmic = true;
  ChartSeries far = {"exact at infinity", {}, true},
              near = {"exact at 0.5 m", {}, true};
  for (const double distance_m : kDistancesM) {
    const ProjectionErrors distant_effect = ComputeProjectionErrors(
        *camera.model, spread.nearest_point, kInfinitelyFarM, distance_m);
    const ProjectionErrors if_near = ComputeProjectionErrors(
        *camera.model, spread.nearest_point, kBoardM, distance_m);
    table.rows.push_back({distance_m, distant_effect.rms_px,
                          distant_effect.max_px, if_near.rms_px,
                          if_near.max_px});
    const double place = static_cast<double>(table.chart.ticks.size());
    table.chart.ticks.push_back({place, fmt::format("{:g}", distance_m)});
    far.points.push_back({place, distant_effect.rms_px});
    near.points.push_back({place, if_near.rms_px});
  }
  table.chart.series = {far, near};

  constexpr int kColumns = 80, kRows = 60, kCellPx = 5;
  const std::vector<double> offsets =
      ListOffsetsMm(*camera.model, spread.nearest_point, kColumns, kRows);
  const Image bar =
      DrawColorLegend(ColorScale::kMagnitude, "0",
                      fmt::format("{:.3g} mm", 1000 * spread.max_m));
  table.pictures.push_back(
      {"offsets",
       ComposeMontage(
           {{"Distance of each observation line from the common point",
             HeatMap(offsets, kColumns, 0, 1000 * spread.max_m, kCellPx,
                     ColorScale::kMagnitude)}},
           {"over the calibrated area"}, &bar)});
  return table;
}

}  // namespace raygrid
