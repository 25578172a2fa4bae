#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>

#include "camera/model_fitting.h"
#include "camera/splined_stereographic.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "evaluation/model_difference.h"
#include "evaluation/residual_statistics.h"
#include "help_formatter.h"
#include "json_output.h"

namespace raygrid {
namespace {

using models::kSplinedStereographic;

struct FitArguments {
  std::string camera, model, spline, output;
};

// The approximate number of compared pixels along the longer side.
constexpr double kSamples = 160;

// Errors over the pixels of the valid region.
struct ValidRegionErrors {
  double rms_px = 0, p99_px = 0, max_px = 0;
  size_t num_samples = 0;
};

// A fitted model, and its difference from the original camera.
struct Fit {
  CameraFile file;
  ModelDifference difference;
  size_t num_samples = 0;                         // within the calibrated area
  std::optional<ValidRegionErrors> valid_region;  // if stored
};

std::string FormatModelNames() {
  return fmt::format("{}, {}", kSplinedStereographic,
                     OrList(ListModelNames(ModelUse::kFit)));
}

// Parses COLUMNSxROWS or COLUMNSxROWS,fov=DEGREES; an angle of 0 means that it
// is not given.
SplinedStereographic::Grid ParseSplineGrid(const std::string& text) {
  constexpr int kFewest = 4, kMost = 200, kMaxDeg = 359;
  static const std::regex words(
      "([0-9]{1,3})x([0-9]{1,3})(,fov=([0-9]{1,3}))?");
  std::smatch found;
  if (std::regex_match(text, found, words)) {
    SplinedStereographic::Grid grid = {std::stoi(found[1]), std::stoi(found[2]),
                                       0};
    if (found[4].matched) grid.fov_x_deg = std::stoi(found[4]);
    const bool has_fov =
        !found[4].matched || (grid.fov_x_deg >= 1 && grid.fov_x_deg <= kMaxDeg);
    if (std::min(grid.columns, grid.rows) >= kFewest &&
        std::max(grid.columns, grid.rows) <= kMost && has_fov)
      return grid;
  }
  throw Error(ExitCode::kUsage,
              fmt::format("--spline {}: expected COLUMNSxROWS control points, "
                          "{} to {} each, optionally with ,fov=DEG of 1 to {}",
                          text, kFewest, kMost, kMaxDeg));
}

// grid: the grid of a spline model, if given.
FittedModel FitModel(const std::string& model, const CameraModel& camera,
                     const std::optional<ValidityMask>& valid_region,
                     const std::optional<SplinedStereographic::Grid>& grid) {
  if (model != kSplinedStereographic)
    return FitNearestModel(model, camera, camera.area());
  FittedModel fitted;
  fitted.model = FitSplinedStereographic(
      camera, valid_region ? &*valid_region : nullptr, grid);
  return fitted;
}

std::optional<ValidRegionErrors> ComputeValidRegionErrors(
    const ModelDifference& difference, const ValidityMask& valid_region) {
  std::vector<double> norms;
  double sum = 0;
  for (size_t i = 0; i < difference.pixels.size(); ++i) {
    if (!valid_region.IsValidAt(difference.pixels[i])) continue;
    norms.push_back(difference.error_px[i].norm());
    sum += norms.back() * norms.back();
  }
  if (norms.empty()) return std::nullopt;
  return ValidRegionErrors{std::sqrt(sum / static_cast<double>(norms.size())),
                           Quantile(norms, 0.99), Quantile(norms, 1),
                           norms.size()};
}

Fit FitCamera(const FitArguments& arguments, const RequestedOperatingPoint& at,
              const std::optional<SplinedStereographic::Grid>& grid) {
  const CameraInput input = ReadCamera(arguments.camera, at);
  const CameraModel& camera = *input.file.camera;
  if (!camera.IsCentral())
    throw Error(
        ExitCode::kUsage,
        fmt::format("{}: a {} camera is non-central; calibrate central-generic "
                    "from the same features, and fit {} to that",
                    arguments.camera, camera.Name(), arguments.model));
  const Area& area = camera.area();
  Fit fit;
  fit.file.name = input.file.name;
  fit.file.serial = input.file.serial;
  fit.file.capture = input.file.capture;
  fit.file.line_delay = input.file.line_delay;
  auto valid_region = LoadValidityMask(input);
  if (valid_region && !valid_region->HasValidCells()) valid_region.reset();
  FittedModel nearest = FitModel(arguments.model, camera, valid_region, grid);
  if (nearest.model) {
    nearest.model->SetImageCircle(camera.image_circle());
    fit.file.camera = std::move(nearest.model);
    const double step_px =
        std::max(1.0, std::max(area.width(), area.height()) / kSamples);
    fit.difference =
        CompareRotatedModels(camera, *fit.file.camera, step_px,
                             nearest.model_from_camera.conjugate());
    fit.num_samples = CompareModels(camera, camera, step_px).pixels.size();
  }
  if (fit.difference.pixels.empty())
    throw Error(ExitCode::kNotConverged,
                fmt::format("{}: {} cannot represent any pixel of this camera; "
                            "use another model",
                            arguments.camera, arguments.model));
  if (valid_region)
    fit.valid_region = ComputeValidRegionErrors(fit.difference, *valid_region);
  return fit;
}

std::string FormatJson(const Fit& fit) {
  const ModelDifference& d = fit.difference;
  const Eigen::Quaterniond& q = d.first_from_second.rotation;
  nlohmann::ordered_json json = {
      {"model", fit.file.camera->Name()},
      {"median_px", d.median_px},
      {"rms_px", d.rms_px},
      {"p99_px", d.p99_px},
      {"max_px", d.max_px},
      {"points", d.pixels.size()},
      {"num_unrepresentable_points", fit.num_samples - d.pixels.size()},
      {"camera_from_model_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
  if (fit.valid_region)
    json["valid_region"] = {{"rms_px", fit.valid_region->rms_px},
                            {"p99_px", fit.valid_region->p99_px},
                            {"max_px", fit.valid_region->max_px},
                            {"points", fit.valid_region->num_samples}};
  return FormatCommandJson(json);
}

// Returns the model's name, with the grid size of spline models.
std::string FullName(const CameraModel& camera) {
  const auto* spline = dynamic_cast<const SplinedStereographic*>(&camera);
  if (!spline) return camera.Name();
  const SplinedStereographic::Grid& grid = spline->grid();
  return fmt::format("{} with {} x {} control points over {} degrees",
                     camera.Name(), grid.columns, grid.rows, grid.fov_x_deg);
}

void Run(const FitArguments& arguments, const CommonOptions& common) {
  if (!IsParametricModel(arguments.model) &&
      arguments.model != kSplinedStereographic)
    throw Error(ExitCode::kUsage,
                fmt::format("--model {}: cannot be fitted; use {}",
                            arguments.model, FormatModelNames()));
  if (!arguments.spline.empty() && arguments.model != kSplinedStereographic)
    throw Error(ExitCode::kUsage, fmt::format("--spline requires --model {}",
                                              kSplinedStereographic));
  std::optional<SplinedStereographic::Grid> grid;
  if (!arguments.spline.empty()) grid = ParseSplineGrid(arguments.spline);
  RequireNoInputReplaced({arguments.camera}, {arguments.output});
  const Fit fit = FitCamera(arguments, common.at, grid);
  WriteFile(arguments.output, FormatCameraFile(fit.file));
  if (common.json) {
    fmt::print("{}", FormatJson(fit));
    return;
  }
  if (common.quiet) return;
  const ModelDifference& d = fit.difference;
  fmt::print(
      "{}: median {:.3g} px, RMS {:.3g} px, 99th percentile {:.3g} px, max "
      "{:.3g} px at {} pixels, after a rotation of {:.2g} rad\n",
      FullName(*fit.file.camera), d.median_px, d.rms_px, d.p99_px, d.max_px,
      d.pixels.size(),
      d.first_from_second.rotation.angularDistance(
          Eigen::Quaterniond::Identity()));
  if (fit.valid_region)
    fmt::print(
        "in the valid region: RMS {:.3g} px, 99th percentile {:.3g} px, max "
        "{:.3g} px at {} pixels\n",
        fit.valid_region->rms_px, fit.valid_region->p99_px,
        fit.valid_region->max_px, fit.valid_region->num_samples);
  if (fit.num_samples > d.pixels.size())
    fmt::print("{} of {} pixels cannot be represented\n",
               fit.num_samples - d.pixels.size(), fit.num_samples);
}

}  // namespace

void AddFit(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "fit", "Fit a parametric camera model to a calibrated camera.",
      "raygrid fit camera.yaml --model opencv -o opencv.yaml", common);
  auto arguments = std::make_shared<FitArguments>();
  command
      ->add_option("camera", arguments->camera,
                   "camera.yaml, blob or another tool's camera file")
      ->required();
  BeginGroup(command, help_group::kModel);
  command->add_option("--model", arguments->model, FormatModelNames())
      ->option_text("NAME")
      ->required();
  command
      ->add_option(
          "--spline", arguments->spline,
          "size of the grid and field of view (default: fewest control "
          "points with an error of at most 0.005 px)")
      ->option_text("COLUMNSxROWS[,fov=DEG]");
  AddAtOption(command, common);
  BeginGroup(command, help_group::kOutput);
  command->add_option("-o,--output", arguments->output, "camera.yaml to write")
      ->option_text("FILE")
      ->required();
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
