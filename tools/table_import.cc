#include "table_import.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "camera_input.h"
#include "dataset/dataset.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"
#include "exchange/count_text.h"
#include "json_output.h"
#include "ray_import.h"
#include "target/board_yaml.h"
#include "view_import.h"

namespace raygrid {
namespace {

// Throws for options that require a camera, for tables without one.
void RequireNoCameraOption(const ImportArguments& arguments,
                           const std::string& what) {
  for (const auto& [option, value] : {std::pair("--model", arguments.model),
                                      {"--image-size", arguments.image_size}})
    if (!value.empty())
      throw Error(ExitCode::kUsage,
                  fmt::format("{}: {} contains only {}", option,
                              arguments.files[0], what));
}

// Returns the features of all cameras, or the boards, depending on the name of
// the output file.
std::string FormatFeatureTable(const FeatureTable& features,
                               const ImportArguments& arguments) {
  const std::filesystem::path output = arguments.output;
  if (output.extension() == ".yaml") {
    if (features.boards.empty())
      throw InputError(arguments.files[0] + ": contains no boards");
    return PatternText(arguments.files[0], features.boards);
  }
  if (output.extension() != ".csv" || EndsWith(output.stem(), "poses"))
    throw Error(
        ExitCode::kUsage,
        fmt::format("-o {}: {} contains features and boards; name the output "
                    "features.csv (pattern.yaml is written beside it)",
                    arguments.output, arguments.files[0]));
  size_t count = 0;
  for (const NamedDataset& camera : features.cameras)
    count += camera.dataset.num_features();
  if (count == 0)
    throw InputError(arguments.files[0] + ": contains no features");
  return features.cameras.size() == 1
             ? FormatFeatures(features.cameras.front().dataset)
             : FormatFeatures(features.cameras);
}

void PrintFeatures(const FeatureTable& features,
                   const ImportArguments& arguments,
                   const CommonOptions& common) {
  auto json =
      nlohmann::ordered_json{{"boards", features.boards.size()},
                             {"cameras", nlohmann::ordered_json::array()}};
  std::string text = CountText(features.boards.size(), "board");
  for (const auto& [name, dataset] : features.cameras) {
    const ImageSize& size = dataset.image_size;
    json["cameras"].push_back({{"name", name},
                               {"image_size", {size.width, size.height}},
                               {"features", dataset.num_features()},
                               {"images", dataset.images.size()}});
    text += fmt::format(
        "; {}{} in {} of {}x{} px", name.empty() ? "" : name + ": ",
        CountText(dataset.num_features(), "feature"),
        CountText(dataset.images.size(), "image"), size.width, size.height);
  }
  if (common.json)
    PrintCommandJson(json);
  else if (!common.quiet)
    fmt::print("{}: {}\n", Printable(arguments.output), text);
}

void ImportFeatures(const TableFormat& table, const ImportArguments& arguments,
                    const std::string& bytes, const CommonOptions& common) {
  RequireNoCameraOption(arguments, "features and boards");
  const FeatureTable features = table.read_features(arguments.files[0], bytes);
  const std::string text = FormatFeatureTable(features, arguments);
  RequireNoInputReplaced(arguments.files, {arguments.output});
  WriteFile(arguments.output, text);
  PrintFeatures(features, arguments, common);
}

void ImportPoses(const TableFormat& table, const ImportArguments& arguments,
                 const std::string& bytes, const CommonOptions& common) {
  const std::string& path = arguments.files[0];
  RequireNoCameraOption(arguments, "poses");
  if (std::filesystem::path(arguments.output).extension() != ".csv")
    throw Error(
        ExitCode::kUsage,
        fmt::format("-o {}: {} contains poses; name the output poses.csv",
                    arguments.output, path));
  const std::vector<BoardPose> poses = table.read_poses(path, bytes);
  RequireNoInputReplaced(arguments.files, {arguments.output});
  WriteFile(arguments.output, FormatPoses(poses));
  if (common.json)
    PrintCommandJson(nlohmann::ordered_json::object({{"poses", poses.size()}}));
  else if (!common.quiet)
    fmt::print("{}: {}\n", Printable(arguments.output),
               CountText(poses.size(), "pose"));
}

}  // namespace

const TableFormat* SelectTable(const ImportArguments& arguments,
                               const std::vector<std::string>& texts) {
  const TableFormat* table = RecognizeTable(texts[0]);
  if (!table) return nullptr;
  if (!arguments.from.empty() && arguments.from != table->name)
    throw InputError(fmt::format("{}: has the format {}, not {}",
                                 arguments.files[0], table->name,
                                 arguments.from));
  if (!arguments.image_size.empty() && table->read_rays)
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "--image-size: {} files store the image size; omit the option",
            table->name));
  if (arguments.files.size() > 1)
    throw Error(ExitCode::kUsage,
                fmt::format("{}: {} files must be imported separately",
                            arguments.files[1], table->name));
  return table;
}

void RequireNoView(const ImportArguments& arguments) {
  const std::string word =
      arguments.is_reverse ? "inverse" : FirstToken(arguments.view);
  if (!word.empty())
    throw Error(
        ExitCode::kUsage,
        fmt::format("--{}: only supported for STMaps; {} is not an STMap", word,
                    arguments.files[0]));
}

void ImportTable(const TableFormat& table, const ImportArguments& arguments,
                 const std::string& bytes, const CommonOptions& common) {
  const std::string& path = arguments.files[0];
  if (!arguments.board.empty())
    throw Error(ExitCode::kUsage,
                fmt::format("--board-size: {} contains no corners", path));
  if (!table.read_view) RequireNoView(arguments);
  if (table.read_poses) {
    ImportPoses(table, arguments, bytes, common);
    return;
  }
  if (table.read_features) {
    ImportFeatures(table, arguments, bytes, common);
    return;
  }
  const RayTable rays =
      table.read_rays ? table.read_rays(path, bytes)
                      : ReadViewTableRays(table, {path, bytes, arguments.view,
                                                  arguments.is_reverse,
                                                  arguments.image_size});
  ImportRays(rays, table.name, arguments.model, arguments.output, common);
}

std::string PatternText(const std::string& path,
                        const std::vector<Board>& boards) {
  if (boards.front().IsPointSet()) return MakeBoardsYaml(boards);
  try {
    RequirePossibleBoards(boards);
  } catch (const Error& error) {
    throw InputError(fmt::format("{}: {}", path, error.what()));
  }
  const std::string text = MakeBoardsYaml(boards);
  Pattern pattern = ParsePattern(path, text);
  bool has_points = false;
  for (size_t k = 0; k < boards.size(); ++k) {
    pattern.boards[k].points = boards[k].points;
    has_points = has_points || !boards[k].points.empty();
  }
  return has_points ? FormatPattern(pattern) : text;
}

}  // namespace raygrid
