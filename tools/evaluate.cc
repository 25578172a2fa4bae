#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "calibration/deformation_evaluation.h"
#include "calibration/rigid_targets.h"
#include "commands.h"
#include "fixed_rig.h"
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

// Returns the pattern, without its rigid targets if boards are independent.
Pattern ReadTargetPattern(const EvaluateArguments& arguments) {
  Pattern pattern = LoadPattern(arguments.pattern);
  if (arguments.independent_boards) pattern.rigid_targets.clear();
  return pattern;
}

using Residuals = std::vector<FeatureResidual>;

nlohmann::ordered_json ToJson(const Evaluation& evaluation,
                              const Residuals& with_deformation) {
  nlohmann::ordered_json json = ComputeErrorMetrics(evaluation.residuals);
  json["outside_area_features"] = evaluation.outside_area;
  if (!with_deformation.empty())
    json["with_deformation"] = ComputeErrorMetrics(with_deformation);
  json["rejected_images"] = RejectedImagesJson(evaluation.rejected_images);
  return json;
}

void Print(const Evaluation& evaluation, const Residuals& with_deformation) {
  fmt::print("{}",
             FormatErrorMetrics(ComputeErrorMetrics(evaluation.residuals)));
  if (evaluation.outside_area > 0)
    fmt::print("; {} outside the calibrated area", evaluation.outside_area);
  fmt::print("\n");
  if (!with_deformation.empty())
    fmt::print(
        "with per-view target deformation: {}, each predicted from the other "
        "half of the features\n",
        FormatErrorMetrics(ComputeErrorMetrics(with_deformation)));
  PrintRejectedImages(evaluation.rejected_images);
}

// Returns the errors of a camera for rigid multi-board targets.
Evaluation EvaluateRigidTargets(const RigModel& camera, const Dataset& dataset,
                                const Pattern& pattern, int num_threads) {
  RigModel with_bodies = camera;
  with_bodies.rigid_targets = MakeRigidTargets(pattern);
  return EvaluateRig(with_bodies, {dataset}, pattern, num_threads).front();
}

void RunCamera(const FixedRig& alone, const Dataset& dataset,
               const Pattern& pattern, const CommonOptions& common) {
  const Evaluation evaluation =
      EvaluateRig(alone.model, {dataset}, pattern, common.threads).front();
  RequireLocalized(evaluation.residuals.size());
  const Residuals with_deformation =
      EvaluateWithDeformation(alone.model, {dataset}, pattern, common.threads)
          .front();
  std::optional<ErrorMetrics> as_rigid_targets;
  if (!pattern.rigid_targets.empty())
    as_rigid_targets = ComputeErrorMetrics(
        EvaluateRigidTargets(alone.model, dataset, pattern, common.threads)
            .residuals);
  if (common.json) {
    nlohmann::ordered_json json = ToJson(evaluation, with_deformation);
    if (as_rigid_targets) {
      json["with_rigid_targets"] = *as_rigid_targets;
      json["rigid_targets"] = MakeRigidTargetsJson(pattern);
    }
    PrintCommandJson(json);
    return;
  }
  if (pattern.boards.size() > 1) fmt::print("one pose per board: ");
  Print(evaluation, with_deformation);
  if (as_rigid_targets)
    fmt::print("{}: {}\n", FormatRigidTargets(pattern),
               FormatErrorMetrics(*as_rigid_targets));
}

void RunRig(const FixedRig& rig, const std::vector<Dataset>& datasets,
            const Pattern& pattern, const CommonOptions& common) {
  const std::vector<Residuals> with_deformation =
      EvaluateWithDeformation(rig.model, datasets, pattern, common.threads);
  RigModel with_bodies = rig.model;
  with_bodies.rigid_targets = MakeRigidTargets(pattern);
  const std::vector<Evaluation> evaluations =
      EvaluateRig(with_bodies, datasets, pattern, common.threads);
  Evaluation all;
  Residuals all_deformed;
  nlohmann::ordered_json json;
  for (size_t c = 0; c < rig.names.size(); ++c) {
    const Evaluation& own = evaluations[c];
    all.residuals.insert(all.residuals.end(), own.residuals.begin(),
                         own.residuals.end());
    all.outside_area += own.outside_area;
    all_deformed.insert(all_deformed.end(), with_deformation[c].begin(),
                        with_deformation[c].end());
    json.push_back({{"name", rig.names[c]}});
    json.back().update(ToJson(own, with_deformation[c]));
  }
  RequireLocalized(all.residuals.size());
  if (common.json) {
    nlohmann::ordered_json whole = ToJson(all, all_deformed);
    whole.erase("rejected_images");
    whole["rigid_targets"] = MakeRigidTargetsJson(pattern);
    whole["cameras"] = json;
    PrintCommandJson(whole);
    return;
  }
  PrintHowLocalized(pattern);
  for (size_t c = 0; c < rig.names.size(); ++c) {
    fmt::print("{}: ", rig.names[c]);
    Print(evaluations[c], with_deformation[c]);
  }
  fmt::print("all: ");
  Print(all, all_deformed);
}

void Run(const EvaluateArguments& arguments, const CommonOptions& common) {
  const FixedRig rig = ReadFixedRig(arguments.camera, common.at);
  const Pattern pattern = ReadTargetPattern(arguments);
  const std::vector<Dataset> datasets =
      ReadRigFeatures(rig, arguments.features, pattern);
  if (rig.is_rig)
    RunRig(rig, datasets, pattern, common);
  else
    RunCamera(rig, datasets.front(), pattern, common);
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
