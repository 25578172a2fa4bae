#include "exchange/external_model_selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "camera/model_fitting.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "exchange/unit_grid.h"

namespace raygrid {
namespace {

// Error assigned to pixels outside the domain of a model during model
// selection.
constexpr double kUnrepresentablePenaltyPx = 100;

// Approximate number of sampled pixels along the longer side.
constexpr double kPixelsAcross = 160;

// Models with smaller errors are considered equal.
constexpr double kNegligibleRmsPx = 0.005;

double ChoiceRmsPx(const ModelFit& fit) {
  const double sum =
      static_cast<double>(fit.num_pixels) * fit.rms_px * fit.rms_px +
      static_cast<double>(fit.num_unrepresentable) * kUnrepresentablePenaltyPx *
          kUnrepresentablePenaltyPx;
  return std::sqrt(
      sum / static_cast<double>(fit.num_pixels + fit.num_unrepresentable));
}

// Splined models need no rotation.
SelectedModel FitSpline(const ExternalModel& external_model,
                        const CameraModel& camera,
                        const ValidityMask* valid_region) {
  auto model = FitSplinedStereographic(camera, valid_region);
  SelectedModel chosen;
  chosen.fit = ModelFit{};
  if (!model) return chosen;
  chosen.fit = ComputeModelFit(camera, valid_region, *model, external_model,
                               Eigen::Quaterniond::Identity());
  chosen.lens = ConvertToExternalModel(external_model, *model).value();
  chosen.model = std::move(model);
  return chosen;
}

// Grids need no rotation, either, unless the target model has an optical axis.
SelectedModel FitGrid(const ExternalModel& external_model,
                      const CameraModel& camera,
                      const ValidityMask* valid_region) {
  const ExternalGrid grid =
      external_model.fit_grid
          ? external_model.fit_grid(camera, valid_region)
          : ExternalGrid{std::make_shared<UnitGrid>(
                FitUnitGrid(camera, external_model.HasLines()))};
  SelectedModel chosen;
  chosen.lens = {
      &external_model, camera.image_size(), {}, nullptr, grid.camera};
  chosen.fit = ComputeModelFit(camera, valid_region, *grid.camera,
                               external_model, grid.camera_from_input);
  chosen.model = grid.camera->Clone();
  return chosen;
}

SelectedModel FitExternalModel(const ExternalModel& external_model,
                               const CameraModel& camera,
                               const ValidityMask* valid_region) {
  if (external_model.IsGrid())
    return FitGrid(external_model, camera, valid_region);
  if (external_model.IsSpline())
    return FitSpline(external_model, camera, valid_region);
  FitOptions options;
  options.held = external_model.Missing();
  options.ties_focal_lengths = external_model.Has("f");
  options.valid_region = valid_region;
  FittedModel fitted =
      FitNearestModel(external_model.model, camera, camera.area(), options);
  SelectedModel chosen;
  chosen.fit = ComputeModelFit(camera, valid_region, *fitted.model,
                               external_model, fitted.model_from_camera);
  chosen.lens = ConvertToExternalModel(external_model, *fitted.model).value();
  chosen.model = std::move(fitted.model);
  return chosen;
}

double ComputeSortedQuantile(const std::vector<double>& sorted, double part) {
  return sorted[static_cast<size_t>(
      part * static_cast<double>(sorted.size() - 1) + 0.5)];
}

}  // namespace

ModelFit ComputeModelFit(const CameraModel& camera,
                         const ValidityMask* valid_region,
                         const CameraModel& lens,
                         const ExternalModel& external_model,
                         const Eigen::Quaterniond& fitted_from_camera) {
  constexpr double kUnlimitedMarginPx = 1e9;
  const Area& area = camera.area();
  const double step_px =
      std::max(1.0, std::max(area.width(), area.height()) / kPixelsAcross);
  ModelFit fit;
  fit.fitted_from_camera = fitted_from_camera;
  fit.has_valid_region = valid_region;
  std::vector<double> errors;
  double sum = 0;
  for (double y = area.y0; y <= area.y1; y += step_px) {
    for (double x = area.x0; x <= area.x1; x += step_px) {
      const Eigen::Vector2d pixel(x, y);
      if ((valid_region && !valid_region->IsValidAt(pixel)) ||
          !camera.IsInImageCircle(pixel))
        continue;
      const auto line = camera.Line(pixel);
      if (!line) continue;
      const Eigen::Vector3d turned =
          fitted_from_camera * (line->origin + line->direction);
      const double angle = std::atan2(turned.head<2>().norm(), turned.z());
      fit.max_valid_angle_rad = std::max(fit.max_valid_angle_rad, angle);
      const auto seen =
          lens.Project(turned, external_model.IsGrid() ? &pixel : nullptr,
                       kUnlimitedMarginPx);
      if (!seen || !(angle < external_model.max_supported_angle_rad)) {
        ++fit.num_unrepresentable;
        continue;
      }
      errors.push_back((*seen - pixel).norm());
      sum += errors.back() * errors.back();
    }
  }
  fit.num_pixels = errors.size();
  if (errors.empty()) return fit;
  std::sort(errors.begin(), errors.end());
  fit.rms_px = std::sqrt(sum / static_cast<double>(errors.size()));
  fit.p99_px = ComputeSortedQuantile(errors, 0.99);
  fit.max_px = errors.back();
  return fit;
}

SelectedModel SelectExternalModel(
    const std::vector<const ExternalModel*>& external_models,
    const CameraModel& camera, const ValidityMask* valid_region,
    int num_threads) {
  constexpr double kMinImprovementFraction = 0.02;
  const auto has_fewer = [](const ExternalModel* a, const ExternalModel* b) {
    return std::make_pair(a->IsSpline(), a->parameters.size()) <
           std::make_pair(b->IsSpline(), b->parameters.size());
  };
  std::vector<const ExternalModel*> sorted;
  for (const ExternalModel* external_model : external_models)
    if (external_model->HasLines() != camera.IsCentral())
      sorted.push_back(external_model);
  if (sorted.empty() && camera.IsCentral()) sorted = external_models;
  std::stable_sort(sorted.begin(), sorted.end(), has_fewer);
  for (const ExternalModel* external_model : sorted)
    if (auto held = ConvertToExternalModel(*external_model, camera))
      return {*held, MakeCameraModel(*held), std::nullopt};
  if (sorted.empty())
    throw Error(ExitCode::kUsage,
                fmt::format("a {} camera is non-central, but models of other "
                            "programs are central; export an undistorted view "
                            "of it, or calibrate another model",
                            camera.Name()));
  std::vector<SelectedModel> fits(sorted.size());
  // Models with many parameters are the slowest, so they start first.
  const int last = static_cast<int>(sorted.size()) - 1;
  ParallelFor(last + 1, NumThreads(num_threads), [&](int k) {
    fits[last - k] = FitExternalModel(*sorted[last - k], camera, valid_region);
  });
  double best_px = INFINITY;
  for (const SelectedModel& lens : fits)
    best_px = std::min(best_px, ChoiceRmsPx(*lens.fit));
  const double accepted_px =
      std::max(best_px / (1 - kMinImprovementFraction), kNegligibleRmsPx);
  const auto chosen =
      std::find_if(fits.begin(), fits.end(), [&](const SelectedModel& lens) {
        return ChoiceRmsPx(*lens.fit) <= accepted_px;
      });
  if (chosen == fits.end() || chosen->fit->num_pixels == 0)
    throw Error(ExitCode::kQualityTooLow,
                fmt::format("{} cannot represent any pixel of this camera's "
                            "valid region; export an undistorted view of it",
                            sorted.front()->name));
  return std::move(*chosen);
}

std::string FormatModelFit(const ModelFit& fit) {
  std::string text = fmt::format(
      "RMS {:.3g} px, 99th percentile {:.3g} px, max {:.3g} px at {} {}pixels",
      fit.rms_px, fit.p99_px, fit.max_px, fit.num_pixels,
      fit.has_valid_region ? "valid " : "");
  if (fit.num_unrepresentable > 0)
    text += fmt::format(
        "; {} pixels cannot be represented, up to {:.0f} degrees off axis",
        fit.num_unrepresentable, fit.max_valid_angle_rad * 180 / M_PI);
  if (!fit.IsTurned()) return text + "; no rotation applied";
  const Eigen::Quaterniond& q = fit.fitted_from_camera;
  return text + fmt::format(
                    "; rotated by {:.2g} rad, lens_from_camera (w, x, y, z) "
                    "{:.9f}, {:.9f}, {:.9f}, {:.9f}",
                    q.angularDistance(Eigen::Quaterniond::Identity()), q.w(),
                    q.x(), q.y(), q.z());
}

}  // namespace raygrid
