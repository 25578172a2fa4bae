#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "calibration/camera_evaluation.h"
#include "calibration/deformation_evaluation.h"
#include "calibration/rig_evaluation.h"
#include "calibration/rigid_targets.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/rig_file.h"
#include "dataset/text_encoding.h"
#include "evaluation/rigid_target_text.h"
#include "help_formatter.h"
#include "json_output.h"
#include "pattern_input.h"
#include "report/result_fields.h"

namespace raygrid {
namespace {

struct EvaluateArguments {
  std::string camera, features, pattern;
  bool independent_boards = false;
};

// Without bodies, if boards are to move by themselves.
Pattern PatternOf(const EvaluateArguments& arguments) {
  Pattern pattern = LoadPattern(arguments.pattern);
  if (arguments.independent_boards) pattern.rigid_targets.clear();
  return pattern;
}

// "boards 0, 1 and 2 as one body", several of them; or nothing.
std::string FormatRigidTargets(const Pattern& pattern) {
  std::string words;
  for (const RigidTarget& body : pattern.rigid_targets)
    words += fmt::format("{}boards {} as a rigid body",
                         words.empty() ? "" : ", ", FormatList(body.boards));
  return words;
}

// How boards are localised, if there are several.
void PrintHowLocalized(const Pattern& pattern) {
  if (pattern.boards.size() < 2) return;
  if (pattern.rigid_targets.empty())
    fmt::print("one pose estimated per board\n");
  else
    fmt::print(
        "poses estimated for {} (use --independent-boards for a pose per "
        "board)\n",
        FormatRigidTargets(pattern));
}

nlohmann::ordered_json RigidTargetsJson(const Pattern& pattern) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const RigidTarget& body : pattern.rigid_targets)
    json.push_back(body.boards);
  return json;
}

using Residuals = std::vector<FeatureResidual>;

nlohmann::ordered_json ToJson(const Evaluation& evaluation,
                              const Residuals& flexed) {
  nlohmann::ordered_json json = ComputeErrorMetrics(evaluation.residuals);
  json["outside_area_features"] = evaluation.outside_area;
  if (!flexed.empty()) json["with_deformation"] = ComputeErrorMetrics(flexed);
  json["rejected_images"] = nlohmann::ordered_json::array();
  for (const RejectedImage& image : evaluation.rejected_images)
    json["rejected_images"].push_back(
        {{"image", image.image}, {"reason", image.reason}});
  return json;
}

void Print(const ErrorMetrics& metrics) {
  fmt::print("median {:.3g} px, RMS {:.3g} px, max {:.3g} px over {} features",
             metrics.median_px, metrics.rms_px, metrics.max_px, metrics.count);
}

void Print(const Evaluation& evaluation, const Residuals& flexed) {
  Print(ComputeErrorMetrics(evaluation.residuals));
  if (evaluation.outside_area > 0)
    fmt::print("; {} outside the calibrated area", evaluation.outside_area);
  fmt::print("\n");
  if (!flexed.empty()) {
    fmt::print("with per-view target deformation: ");
    Print(ComputeErrorMetrics(flexed));
    fmt::print(", each predicted from the other half of the features\n");
  }
  for (const RejectedImage& image : evaluation.rejected_images)
    fmt::print("rejected: {} ({})\n", Printable(image.image),
               Printable(image.reason));
}

// The errors of a camera whose boards are localised as bodies.
Evaluation EvaluateRigidTargets(const RigModel& camera, const Dataset& dataset,
                                const Pattern& pattern, int num_threads) {
  RigModel with_bodies = camera;
  with_bodies.rigid_targets = MakeRigidTargets(pattern);
  return EvaluateRig(with_bodies, {dataset}, pattern, num_threads).front();
}

void RequireResiduals(size_t count) {
  if (count == 0)
    throw Error(ExitCode::kTooFew,
                "no pose could be estimated; check that features and pattern "
                "belong to this camera");
}

void RunCamera(const EvaluateArguments& arguments, const std::string& bytes,
               const CommonOptions& common) {
  const CameraInput input = ParseCamera(arguments.camera, bytes, common.at);
  const Pattern pattern = PatternOf(arguments);
  const Dataset dataset = ReadCameraFeatures(
      arguments.features, input.file.camera->image_size(), pattern);
  const Evaluation evaluation =
      EvaluateCamera(*input.file.camera, dataset, pattern, common.threads);
  RequireResiduals(evaluation.residuals.size());
  const RigModel alone = {{input.file.camera.get()}, {Pose()}};
  const Residuals flexed =
      EvaluateWithDeformation(alone, {dataset}, pattern, common.threads)
          .front();
  std::optional<ErrorMetrics> as_bodies;
  if (!pattern.rigid_targets.empty())
    as_bodies = ComputeErrorMetrics(
        EvaluateRigidTargets(alone, dataset, pattern, common.threads)
            .residuals);
  if (common.json) {
    nlohmann::ordered_json json = ToJson(evaluation, flexed);
    if (as_bodies) {
      json["with_rigid_targets"] = *as_bodies;
      json["rigid_targets"] = RigidTargetsJson(pattern);
    }
    PrintCommandJson(json);
    return;
  }
  if (pattern.boards.size() > 1) fmt::print("one pose per board: ");
  Print(evaluation, flexed);
  if (!as_bodies) return;
  fmt::print("{}: ", FormatRigidTargets(pattern));
  Print(*as_bodies);
  fmt::print("\n");
}

// ---- Rig -------------------------------------------------------------------

// Cameras of which there are no features have none.
std::vector<Dataset> ReadRigFeatures(
    const std::string& path, const std::vector<RigFileCamera>& cameras) {
  auto read = ReadFeatures(path);
  std::vector<Dataset> datasets;
  for (const RigFileCamera& camera : cameras) {
    datasets.push_back(read[camera.name]);
    read.erase(camera.name);
  }
  if (!read.empty())
    throw InputError(fmt::format("{}: camera '{}' is not in the rig", path,
                                 read.begin()->first));
  return datasets;
}

void RunRig(const EvaluateArguments& arguments, const std::string& text,
            const CommonOptions& common) {
  const std::vector<RigFileCamera> files = ParseRigFile(arguments.camera, text);
  const Pattern pattern = PatternOf(arguments);
  std::vector<Dataset> datasets = ReadRigFeatures(arguments.features, files);
  const std::filesystem::path folder =
      std::filesystem::path(arguments.camera).parent_path();
  std::vector<CameraInput> cameras;
  RigModel rig;
  for (size_t c = 0; c < files.size(); ++c) {
    cameras.push_back(ReadCamera((folder / files[c].file).string()));
    rig.cameras.push_back(cameras.back().file.camera.get());
    rig.camera_from_rig.push_back(files[c].camera_from_rig);
    datasets[c].image_size = rig.cameras.back()->image_size();
    RequireConsistent(arguments.features, datasets[c], pattern);
  }
  const std::vector<Residuals> flexed =
      EvaluateWithDeformation(rig, datasets, pattern, common.threads);
  rig.rigid_targets = MakeRigidTargets(pattern);
  const std::vector<Evaluation> evaluations =
      EvaluateRig(rig, datasets, pattern, common.threads);
  Evaluation all;
  Residuals all_flexed;
  nlohmann::ordered_json json;
  for (size_t c = 0; c < files.size(); ++c) {
    const Evaluation& own = evaluations[c];
    all.residuals.insert(all.residuals.end(), own.residuals.begin(),
                         own.residuals.end());
    all.outside_area += own.outside_area;
    all_flexed.insert(all_flexed.end(), flexed[c].begin(), flexed[c].end());
    json.push_back({{"name", files[c].name}});
    json.back().update(ToJson(own, flexed[c]));
  }
  RequireResiduals(all.residuals.size());
  if (common.json) {
    nlohmann::ordered_json whole = ToJson(all, all_flexed);
    whole.erase("rejected_images");
    whole["rigid_targets"] = RigidTargetsJson(pattern);
    whole["cameras"] = json;
    PrintCommandJson(whole);
    return;
  }
  PrintHowLocalized(pattern);
  for (size_t c = 0; c < files.size(); ++c) {
    fmt::print("{}: ", files[c].name);
    Print(evaluations[c], flexed[c]);
  }
  fmt::print("all: ");
  Print(all, all_flexed);
}

void Run(const EvaluateArguments& arguments, const CommonOptions& common) {
  const std::string bytes = ReadFile(arguments.camera);
  if (bytes.find("raygrid_rig:") == std::string::npos)
    RunCamera(arguments, bytes, common);
  else
    RunRig(arguments, bytes, common);
}

}  // namespace

void AddEvaluate(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "evaluate", "Report reprojection errors with fixed intrinsics.",
      "raygrid evaluate camera.yaml --features held_out.csv --pattern "
      "result/pattern.yaml",
      common);
  auto arguments = std::make_shared<EvaluateArguments>();
  command
      ->add_option("camera", arguments->camera, "camera.yaml, blob or rig.yaml")
      ->required();
  command
      ->add_option("--features", arguments->features,
                   "features.csv of the images to evaluate")
      ->option_text("FILE")
      ->required();
  BeginGroup(command, help_group::kModel);
  AddAtOption(command, common);
  AddPatternOption(command, &arguments->pattern,
                   "; use the estimated geometry that calibrate wrote")
      ->required();
  BeginGroup(command, help_group::kTarget);
  command->add_flag("--independent-boards", arguments->independent_boards,
                    "estimate a pose per board even if pattern.yaml declares a "
                    "rigid multi-board target");
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
