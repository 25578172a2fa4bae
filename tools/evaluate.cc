#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "calibration/camera_evaluation.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

struct Arguments {
  std::string camera, features, pattern;
};

Dataset ReadSingleCamera(const std::string& path) {
  const auto datasets = ReadFeatures(path);
  if (datasets.size() > 1)
    throw InputError(path + ": holds several cameras; split it by camera");
  return datasets.begin()->second;
}

void Run(const Arguments& arguments, const CommonOptions& common) {
  const CameraInput input = ReadCamera(arguments.camera);
  const Pattern pattern = ReadPattern(arguments.pattern);
  Dataset dataset = ReadSingleCamera(arguments.features);
  dataset.image_size = input.file.camera->image_size();
  RequireConsistent(arguments.features, dataset, pattern);
  const Evaluation evaluation =
      EvaluateCamera(*input.file.camera, dataset, pattern, common.threads);
  const ErrorFigures figures = ComputeErrorFigures(evaluation.residuals);
  if (figures.count == 0)
    throw Error(ExitCode::kTooFew,
                "no image could be localised; are features and pattern those "
                "of this camera?");
  if (common.json) {
    nlohmann::ordered_json json = {{"median_px", figures.median_px},
                                   {"rms_px", figures.rms_px},
                                   {"max_px", figures.max_px},
                                   {"count", figures.count},
                                   {"outside_area", evaluation.outside_area}};
    json["rejected"] = nlohmann::ordered_json::array();
    for (const RejectedImage& image : evaluation.rejected_images)
      json["rejected"].push_back(
          {{"image", image.image}, {"reason", image.reason}});
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print(
      "median {:.4f} px, RMS {:.4f} px, largest {:.3f} px over {} "
      "features",
      figures.median_px, figures.rms_px, figures.max_px, figures.count);
  if (evaluation.outside_area > 0)
    fmt::print("; {} outside the calibrated area", evaluation.outside_area);
  fmt::print("\n");
  for (const RejectedImage& image : evaluation.rejected_images)
    fmt::print("not used: {} ({})\n", image.image, image.reason);
}

}  // namespace

void AddEvaluate(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "evaluate",
      "Localises images with a camera as it is, and reports reprojection "
      "errors.",
      "raygrid evaluate camera.yaml --features held_out.csv --pattern "
      "result/pattern.yaml",
      common);
  auto arguments = std::make_shared<Arguments>();
  command->add_option("camera", arguments->camera, "camera.yaml or a blob")
      ->required();
  command->add_option("--features", arguments->features, "features.csv")
      ->required();
  command
      ->add_option("--pattern", arguments->pattern,
                   "pattern.yaml: the one that calibrate wrote has the board "
                   "as it really is")
      ->required();
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
