#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "camera/model_fitting.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "evaluation/model_difference.h"

namespace raygrid {
namespace {

struct FitArguments {
  std::string camera, model, output;
};

// About so many places along the longer side are compared.
constexpr double kSamples = 160;

// A model fitted to a camera, and its difference from that.
struct Fit {
  CameraFile file;
  ModelDifference difference;
  size_t num_places = 0;  // that the camera is calibrated for
};

Fit FitCamera(const FitArguments& arguments) {
  const CameraInput input = ReadCamera(arguments.camera);
  const CameraModel& camera = *input.file.camera;
  if (!camera.IsCentral())
    throw Error(ExitCode::kUsage,
                fmt::format("{}: the lines of a {} camera do not meet in a "
                            "point; calibrate {} from the features instead",
                            arguments.camera, camera.Name(), arguments.model));
  const Area& area = camera.area();
  Fit fit;
  fit.file.name = input.file.name;
  fit.file.serial = input.file.serial;
  FittedModel nearest = FitNearestModel(arguments.model, camera, area);
  nearest.model->SetImageCircle(camera.image_circle());
  fit.file.camera = std::move(nearest.model);
  const double step_px =
      std::max(1.0, std::max(area.width(), area.height()) / kSamples);
  fit.difference = CompareTurnedModels(camera, *fit.file.camera, step_px,
                                       nearest.model_from_camera.conjugate());
  fit.num_places = CompareModels(camera, camera, step_px).pixels.size();
  if (fit.difference.pixels.empty())
    throw Error(ExitCode::kNotConverged,
                fmt::format("{}: {} fits it nowhere; use another model",
                            arguments.camera, arguments.model));
  return fit;
}

std::string FormatJson(const Fit& fit) {
  const ModelDifference& d = fit.difference;
  const Eigen::Quaterniond& q = d.first_from_second.rotation;
  const nlohmann::ordered_json json = {
      {"model", fit.file.camera->Name()},
      {"median_px", d.median_px},
      {"rms_px", d.rms_px},
      {"p99_px", d.p99_px},
      {"max_px", d.max_px},
      {"places", d.pixels.size()},
      {"places_without", fit.num_places - d.pixels.size()},
      {"camera_from_model_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
  return json.dump(2) + "\n";
}

void Run(const FitArguments& arguments, const CommonOptions& common) {
  if (!IsParametricModel(arguments.model))
    throw Error(
        ExitCode::kUsage,
        fmt::format("--model {}: not a model that can be fitted; use {}",
                    arguments.model, ParametricModelNames()));
  RequireNoInputReplaced({arguments.camera}, {arguments.output});
  const Fit fit = FitCamera(arguments);
  WriteFile(arguments.output, FormatCameraFile(fit.file));
  if (common.json) {
    fmt::print("{}", FormatJson(fit));
    return;
  }
  if (common.quiet) return;
  const ModelDifference& d = fit.difference;
  fmt::print(
      "{}: median {:.4f} px, RMS {:.4f} px, 99 % below {:.4f} px, largest "
      "{:.4f} px at {} places, after a rotation of {:.5f} rad\n",
      fit.file.camera->Name(), d.median_px, d.rms_px, d.p99_px, d.max_px,
      d.pixels.size(),
      d.first_from_second.rotation.angularDistance(
          Eigen::Quaterniond::Identity()));
  if (fit.num_places > d.pixels.size())
    fmt::print("no direction at {} of {} places\n",
               fit.num_places - d.pixels.size(), fit.num_places);
}

}  // namespace

void AddFit(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "fit",
      "The parametric model nearest to a camera, for programs that know no "
      "other, and the error that it leaves. Where a rotation leaves at least "
      "2 % less, the model looks elsewhere, and poses turn with it: --json has "
      "the rotation.",
      "raygrid fit camera.yaml --model opencv -o opencv.yaml", common);
  auto arguments = std::make_shared<FitArguments>();
  command
      ->add_option("camera", arguments->camera,
                   "camera.yaml, a blob, or another program's camera")
      ->required();
  command->add_option("--model", arguments->model, ParametricModelNames())
      ->required();
  command->add_option("-o,--output", arguments->output, "camera.yaml to write")
      ->required();
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
