#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "features/feature_detection.h"
#include "progress_bar.h"

namespace raygrid {
namespace {

struct Arguments {
  std::vector<std::string> images;
  std::string pattern, output, overlay;
};

void AddOverlays(const Arguments& arguments,
                 const std::vector<std::string>& paths, const Dataset& dataset,
                 OutputFiles* files) {
  for (size_t i = 0; i < paths.size(); ++i) {
    const std::filesystem::path name =
        std::filesystem::path(paths[i]).stem().string() + ".png";
    files->Add((std::filesystem::path(arguments.overlay) / name).string(),
               EncodePng(DrawFeatures(ReadImage(paths[i], true),
                                      dataset.images[i].features)));
  }
}

void Run(const Arguments& arguments, const CommonOptions& common) {
  const Pattern pattern = ReadPattern(arguments.pattern);
  const std::vector<std::string> paths = FindImages(arguments.images);
  Dataset dataset;
  {
    ProgressBar bar(common.quiet);
    dataset =
        DetectFeatures(paths, pattern, common.threads,
                       [&bar](double done) { bar.Show("detection", done); });
  }
  size_t num_images = 0;
  for (const ImageFeatures& image : dataset.images)
    num_images += !image.features.empty();
  if (num_images == 0)
    throw Error(ExitCode::kTooFew,
                fmt::format("no board found in any of {} images; check columns "
                            "and rows (inner corners) in {}",
                            paths.size(), arguments.pattern));
  OutputFiles files;
  files.Add(arguments.output, FormatFeatures(dataset));
  if (!arguments.overlay.empty())
    AddOverlays(arguments, paths, dataset, &files);
  files.Commit();
  if (common.json)
    fmt::print("{{\"images\": {}, \"with_features\": {}, \"features\": {}}}\n",
               paths.size(), num_images, dataset.num_features());
  else if (!common.quiet)
    fmt::print("{} features in {} of {} images: {}\n", dataset.num_features(),
               num_images, paths.size(), arguments.output);
}

}  // namespace

void AddDetect(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "detect", "Finds the pattern's features in images.",
      "raygrid detect photos/ --pattern pattern.yaml -o features.csv "
      "--overlay seen/",
      common);
  auto arguments = std::make_shared<Arguments>();
  command->add_option("images", arguments->images, "images or folders")
      ->required();
  command->add_option("--pattern", arguments->pattern, "pattern.yaml")
      ->required();
  command->add_option("-o,--output", arguments->output, "features.csv to write")
      ->required();
  command->add_option("--overlay", arguments->overlay,
                      "folder for images with the features drawn on them");
  command->callback([arguments, common] { Run(*arguments, *common); });
}

}  // namespace raygrid
