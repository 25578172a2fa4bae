#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "bag_input.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_memory_budget.h"
#include "dataset/parallel_for.h"
#include "dataset/text_encoding.h"
#include "features/board_guess.h"
#include "features/detection_overlays.h"
#include "features/pattern_detector.h"
#include "help_formatter.h"
#include "json_output.h"
#include "pattern_input.h"
#include "progress_bar.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

constexpr char kCoverage[] = "coverage.png";

struct DetectArguments {
  std::vector<std::string> images;
  std::string pattern, output, overlay;
  std::string cache = DetectionCache::DefaultFolder();
  bool no_cache = false;
  DetectionOptions detection;
  BagOptions bags;
};

const std::map<std::string, Refinement> kRefinements = {
    {"intensities", Refinement::kIntensities},
    {"gradients-xy", Refinement::kGradientsXY},
    {"gradient-magnitude", Refinement::kGradientMagnitude},
    {"corner-subpix", Refinement::kCornerSubpix},
    {"none", Refinement::kNone}};

// Keeps the extension, since a.jpg and a.png may both exist.
std::string OverlayName(const std::string& path) {
  const fs::path name = fs::path(path).filename();
  return name.extension() == ".png" ? name.string() : name.string() + ".png";
}

std::string OverlayPath(const DetectArguments& arguments,
                        const std::string& name) {
  return (fs::path(arguments.overlay) / name).string();
}

void RequireInputsNotOverwritten(const DetectArguments& arguments,
                                 const std::vector<std::string>& images) {
  std::vector<std::string> inputs = images, outputs = {arguments.output};
  inputs.push_back(arguments.pattern);
  if (!arguments.overlay.empty()) {
    outputs.push_back(OverlayPath(arguments, kCoverage));
    for (const std::string& path : images)
      outputs.push_back(OverlayPath(arguments, OverlayName(path)));
  }
  RequireNoInputReplaced(inputs, outputs);
  if (!arguments.overlay.empty())
    RequireSeparateFolders(images, arguments.overlay);
}

FolderDetection Detect(const DetectArguments& arguments, const Pattern& pattern,
                       const CommonOptions& common) {
  const FoundImages images =
      FindImages(ExpandBags(arguments.images, arguments.bags, common.quiet));
  RequireInputsNotOverwritten(arguments, images.paths);
  const DetectionCache cache(arguments.no_cache ? "" : arguments.cache);
  ProgressBar bar(common.quiet);
  FolderDetection found =
      DetectFeatures(images.paths, pattern, arguments.detection,
                     arguments.no_cache ? nullptr : &cache, common.threads,
                     [&bar](double done) { bar.Show("detection", done); });
  found.skipped.insert(found.skipped.end(), images.left_out.begin(),
                       images.left_out.end());
  return found;
}

void WarnAboutSkipped(const FolderDetection& found) {
  for (const SkippedImage& skipped : found.skipped)
    fmt::print(stderr, "raygrid: {}: skipped: {}\n", Printable(skipped.path),
               Printable(skipped.reason));
}

void PrintAllWarnings(const FolderDetection& found) {
  for (const std::string& warning : SummarizeWarnings(found))
    fmt::print(stderr, "raygrid: {}\n", Printable(warning));
  if (!found.turned.empty())
    fmt::print(stderr, "raygrid: {}\n",
               Printable(WarnAboutOrientation(found.turned)));
}

// Lists the images without features; of many, only the first ones.
void PrintImagesWithoutFeatures(const FolderDetection& found) {
  constexpr size_t kMaxNames = 20;
  std::vector<std::string> names;
  for (size_t i = 0; i < found.images.size(); ++i)
    if (found.images[i].features.empty())
      names.push_back(found.dataset.images[i].image);
  if (names.empty()) return;
  const size_t num_others = names.size() - std::min(names.size(), kMaxNames);
  names.resize(names.size() - num_others);
  fmt::print(stderr, "raygrid: no target found in {}{}\n",
             Printable(fmt::format("{}", fmt::join(names, ", "))),
             num_others == 0
                 ? std::string()
                 : fmt::format(" and {} more (--json lists all)", num_others));
}

int NumWithFeatures(const FolderDetection& found) {
  int count = 0;
  for (const ImageDetection& image : found.images)
    count += !image.features.empty();
  return count;
}

size_t NumRejected(const FolderDetection& found) {
  size_t count = 0;
  for (const ImageDetection& image : found.images)
    count += image.rejected.size();
  return count;
}

void RequireFeatures(const FolderDetection& found, const Pattern& pattern,
                     const DetectArguments& arguments) {
  if (NumWithFeatures(found) > 0) return;
  std::string seen;
  for (const std::string& warning : SummarizeWarnings(found))
    seen += "; " + warning;
  throw Error(ExitCode::kInsufficientData,
              fmt::format("no target found in any of {} images{}; {}",
                          found.images.size(), seen,
                          DescribeExpectedBoards(pattern, arguments.pattern)));
}

void AddOverlays(const DetectArguments& arguments, const FolderDetection& found,
                 int num_threads, OutputFiles* files) {
  const int count = static_cast<int>(found.paths.size());
  std::vector<std::string> pictures(count);
  ParallelFor(count, NumThreads(num_threads), [&](int i) {
    const ImageMemoryBudget room(found.dataset.image_size);
    pictures[i] = EncodePng(DrawDetection(
        MakeGreyImage(ReadGreyLevels(found.paths[i])), found.images[i]));
  });
  for (int i = 0; i < count; ++i)
    files->Add(OverlayPath(arguments, OverlayName(found.paths[i])),
               std::move(pictures[i]));
  files->Add(OverlayPath(arguments, kCoverage),
             EncodePng(DrawCoverage(found.dataset)));
}

std::string FormatJson(const FolderDetection& found, double seconds) {
  nlohmann::ordered_json json;
  json["images"] = found.images.size() + found.skipped.size();
  json["images_with_features"] = NumWithFeatures(found);
  json["features"] = found.dataset.num_features();
  json["rejected_features"] = NumRejected(found);
  json["skipped_images"] = nlohmann::ordered_json::array();
  for (const SkippedImage& skipped : found.skipped)
    json["skipped_images"].push_back(
        {{"image", fs::path(skipped.path).filename().string()},
         {"reason", skipped.reason}});
  json["images_without_features"] = nlohmann::ordered_json::array();
  for (size_t i = 0; i < found.images.size(); ++i)
    if (found.images[i].features.empty())
      json["images_without_features"].push_back(
          {{"image", found.dataset.images[i].image},
           {"reasons", found.images[i].warnings}});
  json["rotated_by_exif"] = found.turned;
  json["elapsed_s"] = seconds;
  return FormatCommandJson(json);
}

void Run(const DetectArguments& arguments, const CommonOptions& common) {
  const auto start = std::chrono::steady_clock::now();
  const Pattern pattern = LoadCheckedPattern(arguments.pattern, common);
  const FolderDetection found = Detect(arguments, pattern, common);
  WarnAboutSkipped(found);
  OutputFiles overlays;
  if (!arguments.overlay.empty()) {
    AddOverlays(arguments, found, common.threads, &overlays);
    overlays.Commit();  // they also show why detection failed
  }
  if (const auto other =
          SuggestOtherBoard(found, pattern, arguments.pattern, common.threads))
    throw Error(ExitCode::kInsufficientData, *other);
  RequireFeatures(found, pattern, arguments);
  if (!common.quiet) {
    PrintImagesWithoutFeatures(found);
    PrintAllWarnings(found);
  }
  WriteFile(arguments.output, FormatFeatures(found.dataset));
  const std::chrono::duration<double> seconds =
      std::chrono::steady_clock::now() - start;
  if (common.json)
    fmt::print("{}", FormatJson(found, seconds.count()));
  else if (!common.quiet)
    fmt::print(
        "{} features in {} of {} images ({} skipped, {} features rejected): "
        "{}\n",
        found.dataset.num_features(), NumWithFeatures(found),
        found.images.size() + found.skipped.size(), found.skipped.size(),
        NumRejected(found), Printable(arguments.output));
}

void AddDetectionOptions(CLI::App* command, DetectArguments* arguments) {
  BeginGroup(command, help_group::kAdvanced);
  command
      ->add_option("--refinement", arguments->detection.refinement,
                   "sub-pixel refinement: intensities, gradients-xy or "
                   "gradient-magnitude (symmetry), corner-subpix or none")
      ->transform(CLI::CheckedTransformer(kRefinements, CLI::ignore_case)
                      .description(""))
      ->option_text("NAME")
      ->default_str("intensities");
  command
      ->add_option("--window", arguments->detection.window_px,
                   "side length of the refinement window, odd, 5 to 101")
      ->check([](const std::string& text) {
        int value = 0;
        return CLI::detail::lexical_cast(text, value) && value >= 5 &&
                       value <= 101 && value % 2 == 1
                   ? std::string()
                   : text + " is not an odd number from 5 to 101";
      })
      ->option_text("PX")
      ->capture_default_str();
  command
      ->add_option("--cache", arguments->cache,
                   "cache folder for detections (default: raygrid in "
                   "$XDG_CACHE_HOME or ~/.cache)")
      ->option_text("DIR");
  command->add_flag("--no-cache", arguments->no_cache, "do not use the cache");
}

}  // namespace

void AddDetect(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "detect", "Detect target features with sub-pixel accuracy.",
      "raygrid detect photos/ --pattern pattern.yaml -o features.csv "
      "--overlay seen/",
      common);
  auto arguments = std::make_shared<DetectArguments>();
  command->add_option("images", arguments->images, "images, folders or bags")
      ->required();
  AddPatternOption(command, &arguments->pattern)->required();
  AddYesOption(command, common);
  AddBagOptions(command, &arguments->bags, false);
  BeginGroup(command, help_group::kOutput);
  command->add_option("-o,--output", arguments->output, "features.csv to write")
      ->option_text("FILE")
      ->required();
  command
      ->add_option("--overlay", arguments->overlay,
                   "folder for images with the detected features, and "
                   "coverage.png")
      ->option_text("DIR");
  AddDetectionOptions(command, arguments.get());
  AddHugeOption(command);
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
