#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "calibration/camera_evaluation.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_files.h"
#include "evaluation/model_difference.h"
#include "evaluation/prediction_comparison.h"
#include "evaluation/residual_statistics.h"
#include "help_formatter.h"
#include "json_output.h"
#include "pattern_input.h"
#include "report/plots.h"

namespace raygrid {
namespace {

struct CompareArguments {
  std::string first, second, output, features, pattern;
  double distance_m = 1;
};

// The approximate number of compared pixels along the longer side.
constexpr double kMaxSamplesAlongSide = 160;

struct Comparison {
  ModelDifference difference;
  ImageSize size;
  Area area;  // area of the second camera
  double angle_rad = 0;
  // Over the pixels in the valid regions of both cameras; nullopt if neither
  // stores a valid region.
  std::optional<ErrorMetrics> valid_region;
  std::optional<PredictionComparison> prediction;  // comparison on given
                                                   // features
};

// Compares the residuals after pose estimation with each camera.
PredictionComparison Predict(const CompareArguments& arguments,
                             const CameraModel& first,
                             const CameraModel& second, int num_threads) {
  const Pattern pattern = LoadPattern(arguments.pattern);
  const Dataset dataset =
      ReadCameraFeatures(arguments.features, first.image_size(), pattern);
  const auto residuals = [&](const CameraModel& camera) {
    return EvaluateCamera(camera, dataset, pattern, num_threads).residuals;
  };
  const PredictionComparison prediction =
      ComparePredictions(residuals(first), residuals(second));
  if (prediction.images.empty())
    throw Error(ExitCode::kInsufficientData,
                arguments.features +
                    ": no pose could be estimated with both cameras; check "
                    "that features and pattern belong to them");
  return prediction;
}

// Returns the difference over pixels in the valid regions of both cameras.
// Elsewhere, one of them is extrapolated, and the difference is arbitrary.
std::optional<ErrorMetrics> WhereValid(const ModelDifference& difference,
                                       const CameraInput& first,
                                       const CameraInput& second) {
  const auto first_valid = LoadValidityMask(first),
             second_valid = LoadValidityMask(second);
  if (!first_valid && !second_valid) return std::nullopt;
  std::vector<FeatureResidual> places;
  for (size_t i = 0; i < difference.pixels.size(); ++i) {
    const Eigen::Vector2d& pixel = difference.pixels[i];
    if ((first_valid && !first_valid->IsValidAt(pixel)) ||
        (second_valid && !second_valid->IsValidAt(pixel)))
      continue;
    places.emplace_back();
    places.back().error_px = difference.error_px[i];
  }
  if (places.empty()) return std::nullopt;
  return ComputeErrorMetrics(places);
}

Comparison Compare(const CompareArguments& arguments,
                   const CommonOptions& common) {
  const auto [first, second] =
      ReadCameraPair(arguments.first, arguments.second, common.at);
  Comparison comparison;
  comparison.size = first.file.camera->image_size();
  const ImageSize other = second.file.camera->image_size();
  if (comparison.size != other)
    throw InputError(fmt::format(
        "image sizes differ: {} has {} x {} pixels, {} has {} x {}; compare "
        "cameras of the same sensor mode",
        arguments.first, comparison.size.width, comparison.size.height,
        arguments.second, other.width, other.height));
  comparison.area = second.file.camera->area();
  const double step_px = std::max(
      1.0, std::max(comparison.area.width(), comparison.area.height()) /
               kMaxSamplesAlongSide);
  comparison.difference = CompareModels(*first.file.camera, *second.file.camera,
                                        step_px, arguments.distance_m);
  if (comparison.difference.pixels.empty())
    throw InputError(
        fmt::format("{} and {}: the calibrated areas do not overlap",
                    arguments.first, arguments.second));
  comparison.valid_region = WhereValid(comparison.difference, first, second);
  comparison.angle_rad =
      comparison.difference.first_from_second.rotation.angularDistance(
          Eigen::Quaterniond::Identity());
  if (!arguments.features.empty())
    comparison.prediction = Predict(arguments, *first.file.camera,
                                    *second.file.camera, common.threads);
  return comparison;
}

nlohmann::ordered_json ToJson(const ErrorMetrics& metrics) {
  return {{"median_px", metrics.median_px},
          {"rms_px", metrics.rms_px},
          {"max_px", metrics.max_px}};
}

nlohmann::ordered_json ToJson(const PredictionComparison& prediction) {
  return {{"better", prediction.NameBetterCamera()},
          {"probability", prediction.probability},
          {"features", prediction.first.count},
          {"excluded_features", prediction.num_left_out},
          {"images", prediction.images.size()},
          {"first_better_images", prediction.num_first_better},
          {"second_better_images", prediction.num_second_better},
          {"first", ToJson(prediction.first)},
          {"second", ToJson(prediction.second)}};
}

std::string FormatJson(const Comparison& comparison) {
  const ModelDifference& d = comparison.difference;
  nlohmann::ordered_json json = {
      {"median_px", d.median_px},  {"rms_px", d.rms_px},
      {"p99_px", d.p99_px},        {"max_px", d.max_px},
      {"points", d.pixels.size()}, {"rotation_rad", comparison.angle_rad}};
  const Eigen::Vector3d& t = d.first_from_second.translation;
  if (!d.inverse_distances.empty())
    json["translation_m"] = {t.x(), t.y(), t.z()};
  if (comparison.valid_region) {
    json["valid_region"] = ToJson(*comparison.valid_region);
    json["valid_region"]["points"] = comparison.valid_region->count;
  }
  if (comparison.prediction)
    json["prediction"] = ToJson(*comparison.prediction);
  return FormatCommandJson(json);
}

std::string FormatCsv(const ModelDifference& difference) {
  const bool has_distances = !difference.inverse_distances.empty();
  std::string csv =
      has_distances ? "x,y,dx,dy,inverse_distance\n" : "x,y,dx,dy\n";
  for (size_t i = 0; i < difference.pixels.size(); ++i) {
    csv += fmt::format("{:.3f},{:.3f},{:.6f},{:.6f}", difference.pixels[i].x(),
                       difference.pixels[i].y(), difference.error_px[i].x(),
                       difference.error_px[i].y());
    if (has_distances)
      csv += fmt::format(",{:.6g}", difference.inverse_distances[i]);
    csv += "\n";
  }
  return csv;
}

std::string FormatCsv(const PredictionComparison& prediction) {
  std::string csv = "image,features,first_mean_px,second_mean_px\n";
  for (const ImagePrediction& image : prediction.images)
    csv += fmt::format("{},{},{:.6f},{:.6f}\n", CsvField(image.image),
                       image.num_features, image.first_px, image.second_px);
  return csv;
}

void Write(const Comparison& comparison, const std::filesystem::path& folder) {
  std::vector<FeatureResidual> places;
  for (size_t i = 0; i < comparison.difference.pixels.size(); ++i) {
    FeatureResidual place;
    place.pixel = comparison.difference.pixels[i];
    place.error_px = comparison.difference.error_px[i];
    places.push_back(place);
  }
  const double full_scale_px = std::max(comparison.difference.p99_px, 1e-9);
  OutputFiles files;
  files.Add((folder / "difference.json").string(), FormatJson(comparison));
  files.Add((folder / "difference.csv").string(),
            FormatCsv(comparison.difference));
  if (comparison.prediction)
    files.Add((folder / "predictions.csv").string(),
              FormatCsv(*comparison.prediction));
  files.Add((folder / "magnitude.png").string(),
            EncodePng(DrawMagnitudePlot(places, comparison.size,
                                        comparison.area, full_scale_px)));
  files.Add(
      (folder / "direction.png").string(),
      EncodePng(DrawDirectionPlot(places, comparison.size, comparison.area)));
  files.Commit();
}

void Print(const CompareArguments& arguments,
           const PredictionComparison& prediction) {
  const auto print = [](const std::string& camera, const ErrorMetrics& metrics,
                        int num_better) {
    fmt::print("{}: median {:.3g} px, RMS {:.3g} px, better in {} images\n",
               camera, metrics.median_px, metrics.rms_px, num_better);
  };
  fmt::print("{} features of {} images, poses estimated with each camera:\n",
             prediction.first.count, prediction.images.size());
  print(arguments.first, prediction.first, prediction.num_first_better);
  print(arguments.second, prediction.second, prediction.num_second_better);
  const std::string better = prediction.NameBetterCamera();
  if (better == "neither")
    fmt::print(
        "no significant difference (p = {:.2g}, Wilcoxon signed-rank test over "
        "images)\n",
        prediction.probability);
  else
    fmt::print("{} predicts better (p = {:.2g})\n",
               better == "first" ? arguments.first : arguments.second,
               prediction.probability);
  if (prediction.num_left_out > 0)
    fmt::print(
        "{} features outside the calibrated area of one camera were ignored\n",
        prediction.num_left_out);
}

void Run(const CompareArguments& arguments, const CommonOptions& common) {
  if (arguments.features.empty() != arguments.pattern.empty())
    throw Error(ExitCode::kUsage,
                "compare: --features and --pattern must be used together");
  if (!arguments.output.empty()) {
    const std::filesystem::path folder = arguments.output;
    RequireNoInputReplaced({arguments.first, arguments.second,
                            arguments.features, arguments.pattern},
                           {(folder / "difference.csv").string(),
                            (folder / "difference.json").string(),
                            (folder / "predictions.csv").string()});
    RequireCreatableFolder(arguments.output);
  }
  const Comparison comparison = Compare(arguments, common);
  if (!arguments.output.empty()) Write(comparison, arguments.output);
  const ModelDifference& d = comparison.difference;
  if (common.json) {
    fmt::print("{}", FormatJson(comparison));
    return;
  }
  if (common.quiet) return;
  fmt::print(
      "median {:.3g} px, RMS {:.3g} px, 99th percentile {:.3g} px, max {:.3g} "
      "px at {} pixels, after a rotation of {:.2g} rad",
      d.median_px, d.rms_px, d.p99_px, d.max_px, d.pixels.size(),
      comparison.angle_rad);
  if (!d.inverse_distances.empty())
    fmt::print(
        " and a translation of {:.2f} mm; compared at {:g} m and at infinity",
        1000 * d.first_from_second.translation.norm(), arguments.distance_m);
  fmt::print("\n");
  if (comparison.valid_region)
    fmt::print(
        "in both valid regions: median {:.3g} px, RMS {:.3g} px, max {:.3g} px "
        "at {} pixels\n",
        comparison.valid_region->median_px, comparison.valid_region->rms_px,
        comparison.valid_region->max_px, comparison.valid_region->count);
  if (comparison.prediction) Print(arguments, *comparison.prediction);
  if (!arguments.output.empty())
    fmt::print(
        "magnitude.png (scale 0 to {:.2g} px), direction.png, difference.csv{} "
        "and difference.json in {}\n",
        d.p99_px, comparison.prediction ? ", predictions.csv" : "",
        arguments.output);
}

}  // namespace

void AddCompare(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "compare",
      "Compare two cameras by their projection difference in pixels.",
      "raygrid compare today/camera.yaml last_year/camera.yaml -o difference/",
      common);
  auto arguments = std::make_shared<CompareArguments>();
  command->add_option("first", arguments->first, "camera.yaml or blob")
      ->required();
  command->add_option("second", arguments->second, "camera.yaml or blob")
      ->required();
  command
      ->add_option("--features", arguments->features,
                   "features.csv of images that neither calibration used: "
                   "compares the reprojection errors of both cameras")
      ->option_text("FILE");
  BeginGroup(command, help_group::kModel);
  AddAtOption(command, common);
  command
      ->add_option("--distance", arguments->distance_m,
                   "distance at which non-central cameras are compared, in "
                   "addition to infinity")
      ->option_text("M")
      ->check(AboveZero())
      ->capture_default_str();
  AddPatternOption(command, &arguments->pattern, "; with --features");
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "folder for plots and tables")
      ->option_text("DIR");
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
