#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "bag_input.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/dataset.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/rig_file.h"
#include "dataset/text_encoding.h"
#include "exchange/count_text.h"
#include "exchange/format.h"
#include "exchange/table_format.h"
#include "help_formatter.h"
#include "image_size_option.h"
#include "import_arguments.h"
#include "json_output.h"
#include "table_import.h"

namespace raygrid {
namespace {

// The maximum number of corners along a side of a board.
constexpr int kMaxCorners = 1000;

// Parses COLUMNSxROWS.
ImageSize ParseBoardSize(const std::string& text) {
  int columns = 0, rows = 0;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, columns);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == 'x') {
    const auto second = std::from_chars(first.ptr + 1, end, rows);
    if (second.ec == std::errc() && second.ptr == end &&
        std::min(columns, rows) >= 2 && std::max(columns, rows) <= kMaxCorners)
      return {columns, rows};
  }
  throw Error(ExitCode::kUsage,
              fmt::format("--board-size {}: expected COLUMNSxROWS corners, 2 "
                          "to {} each, such as 10x10",
                          text, kMaxCorners));
}

ExchangeContents ReadForeignFile(const ImportArguments& arguments,
                                 const std::string& path,
                                 const std::string& text) {
  ReadRequest request = {path, text, arguments.model, std::nullopt};
  if (!arguments.board.empty()) request.board = ParseBoardSize(arguments.board);
  if (!arguments.image_size.empty())
    request.size = ParseImageSize("--image-size", arguments.image_size);
  const Format* format =
      arguments.from.empty() ? nullptr : &FindFormat("--from", arguments.from);
  if (format && !format->read)
    throw Error(ExitCode::kUsage,
                fmt::format("--from {}: this format can only be exported",
                            format->name));
  for (const char* own : {"raygrid_camera:", "raygrid_rig:"})
    if (request.text.find(own) != std::string::npos)
      throw InputError(path + ": is already a raygrid file; no import needed");
  const Format* const found = format ? format : RecognizeFormat(request.text);
  if (found) request.beside = ReadCompanionFiles(*found, path);
  return ReadExchangeFile(format, request);
}

// Writes the boards if the file contains only boards; returns whether it does.
bool ImportBoards(const ImportArguments& arguments,
                  const std::vector<std::string>& texts,
                  const CommonOptions& common) {
  const Format* format = RecognizeFormat(texts[0]);
  if (!format || !format->external_models.empty() ||
      format->requires_board_size)
    return false;
  const std::string& path = arguments.files[0];
  const ExchangeContents contents = ReadForeignFile(arguments, path, texts[0]);
  for (const auto& [option, value] : {std::pair("--model", arguments.model),
                                      {"--image-size", arguments.image_size},
                                      {"--board-size", arguments.board}})
    if (!value.empty())
      throw Error(ExitCode::kUsage,
                  fmt::format("{}: {} contains only a target", option, path));
  if (arguments.files.size() > 1)
    throw Error(
        ExitCode::kUsage,
        arguments.files[1] + ": a target file must be imported separately");
  if (std::filesystem::path(arguments.output).extension() == ".csv")
    throw Error(
        ExitCode::kUsage,
        fmt::format("-o {}: {} contains a target; name the output pattern.yaml",
                    arguments.output, path));
  RequireNoInputReplaced(arguments.files, {arguments.output});
  OutputFiles outputs;
  outputs.Add(arguments.output, PatternText(path, contents.boards));
  outputs.Commit();
  const Board& board = contents.boards.front();
  if (common.json)
    PrintCommandJson({{"kind", board.kind},
                      {"columns", board.columns},
                      {"rows", board.rows}});
  else if (!common.quiet)
    fmt::print("{}: {} with {} x {} features\n", arguments.output, board.kind,
               board.columns, board.rows);
  return true;
}

// Throws for options that have no effect on these contents, with or without
// cameras.
void RequireUsed(const ImportArguments& arguments,
                 const ExchangeContents& contents) {
  const auto refuse = [](const std::string& option, const std::string& why) {
    throw Error(ExitCode::kUsage, option + ": " + why);
  };
  if (!contents.cameras.empty()) {
    if (!arguments.board.empty() &&
        std::filesystem::path(arguments.output).extension() != ".csv")
      refuse("--board-size",
             "is for corner files only (imported as features.csv)");
    return;
  }
  if (arguments.files.size() > 1)
    refuse(arguments.files[1], "a corner file must be imported separately");
  if (!arguments.model.empty())
    refuse("--model", "a corner file has no camera");
  if (!arguments.image_size.empty())
    refuse("--image-size",
           "features.csv does not store it; pass it to calibrate");
}

// Returns the contents of a file that contains only corners; nullopt for other
// formats.
std::optional<ExchangeContents> ReadCorners(
    const ImportArguments& arguments, const std::vector<std::string>& texts) {
  const Format* format = arguments.from.empty()
                             ? RecognizeFormat(texts[0])
                             : &FindFormat("--from", arguments.from);
  if (!format || !format->requires_board_size) {
    if (!arguments.board.empty() && !(format && format->accepts_board_size))
      throw Error(ExitCode::kUsage,
                  "--board-size is only for corner files without a board size");
    return std::nullopt;
  }
  RequireUsed(arguments, {});
  ReadRequest request = {arguments.files[0], texts[0], "", std::nullopt};
  if (!arguments.board.empty()) request.board = ParseBoardSize(arguments.board);
  return ReadExchangeFile(format, request);
}

void ImportCorners(const ExchangeContents& contents,
                   const ImportArguments& arguments,
                   const CommonOptions& common) {
  if (std::filesystem::path(arguments.output).extension() != ".csv")
    throw Error(ExitCode::kUsage,
                fmt::format("-o {}: {} contains corners but no camera; name "
                            "the output features.csv",
                            arguments.output, arguments.files[0]));
  const Dataset dataset = {{}, contents.corners};
  RequireNoInputReplaced(arguments.files, {arguments.output});
  OutputFiles outputs;
  outputs.Add(arguments.output, FormatFeatures(dataset));
  outputs.Commit();
  for (const std::string& warning : contents.warnings)
    fmt::print(stderr, "raygrid: {}: {}\n", Printable(arguments.files[0]),
               Printable(warning));
  if (common.json)
    PrintCommandJson({{"features", dataset.num_features()},
                      {"images", dataset.images.size()},
                      {"warnings", contents.warnings}});
  else if (!common.quiet)
    fmt::print("{}: {} in {}\n", arguments.output,
               CountText(dataset.num_features(), "feature"),
               CountText(dataset.images.size(), "image"));
}

// Reads all files. Rigs with one file per camera contain the poses, or the
// rectification matrices R and P. Unless every camera has a name in its file,
// cameras are named after the files.
ExchangeContents ReadForeign(const ImportArguments& arguments,
                             const std::vector<std::string>& texts) {
  ExchangeContents all;
  std::vector<std::string> stems;
  std::set<std::string> names;
  std::string of_pose;
  for (size_t k = 0; k < arguments.files.size(); ++k) {
    const std::string& path = arguments.files[k];
    ExchangeContents contents = ReadForeignFile(arguments, path, texts[k]);
    for (const std::string& warning : contents.warnings)
      all.warnings.push_back(path + ": " + warning);
    if (contents.second_from_first) {
      all.second_from_first = contents.second_from_first;
      of_pose = path;
      continue;
    }
    RequireUsed(arguments, contents);
    if (contents.cameras.empty()) return contents;
    for (InputCamera& camera : contents.cameras) {
      stems.push_back(std::filesystem::path(path).stem().string());
      names.insert(camera.name);
      all.cameras.push_back(std::move(camera));
    }
  }
  AssignPairPose(all.second_from_first, of_pose, &all.cameras);
  if (arguments.files.size() == 1) {
    const auto& rectified = all.cameras.front().rectified;
    if (all.cameras.size() == 1 && rectified && rectified->HasBaseline())
      all.warnings.push_back(arguments.files.front() +
                             ": R and P of the rectified pair are ignored; "
                             "import both files of the pair to get a rig");
    const auto& pose = all.cameras.front().camera_from_rig;
    if (all.cameras.size() == 1 && pose &&
        !(pose->rotation.vec().norm() + pose->translation.norm() < 1e-12))
      all.warnings.push_back(arguments.files.front() +
                             ": its pose is ignored; import the files of all "
                             "cameras to get the rig");
    return all;
  }
  if (names.size() < all.cameras.size() || names.count("") > 0)
    for (size_t c = 0; c < stems.size(); ++c) all.cameras[c].name = stems[c];
  if (!all.IsRig()) ComputeStereoPoses(&all.cameras);
  return all;
}

// Converts a camera's name to a file name: "Camera 001" becomes "Camera-001".
std::string MakeFileName(std::string name) {
  for (char& c : name)
    if (!IsRigCameraName(std::string(1, c))) c = '-';
  return name;
}

// Returns the distinct file names for the cameras.
std::vector<std::string> FolderNames(const ImportArguments& arguments,
                                     const ExchangeContents& contents) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const InputCamera& camera : contents.cameras) {
    const std::string name = MakeFileName(camera.name);
    if (name.empty() || !taken.insert(name).second)
      throw InputError(
          fmt::format("{}: camera '{}': camera names must be unique in their "
                      "letters, digits and '_'",
                      arguments.files.back(), Printable(camera.name)));
    names.push_back(name);
  }
  return names;
}

// Returns the features or the poses of all cameras in CSV, depending on the
// name of the output file.
std::string MakeCsvName(const ImportArguments& arguments,
                        const ExchangeContents& contents) {
  const std::string stem =
      std::filesystem::path(arguments.output).stem().string();
  const bool wants_features = EndsWith(stem, "features");
  if (!wants_features && !EndsWith(stem, "poses"))
    throw Error(
        ExitCode::kUsage,
        fmt::format("-o {}: the name must end in features.csv or poses.csv",
                    arguments.output));
  std::vector<NamedDataset> features;
  std::vector<NamedPoses> poses;
  bool has_any = false;
  for (const InputCamera& camera : contents.cameras) {
    features.push_back({camera.name, {camera.lens.size, camera.features}});
    poses.push_back({camera.name, camera.poses});
    has_any = has_any || !(wants_features ? camera.features.empty()
                                          : camera.poses.empty());
  }
  for (const InputCamera& camera : contents.cameras)
    if (wants_features && !camera.missing_features_reason.empty())
      throw InputError(fmt::format("{}: {}", arguments.files.front(),
                                   camera.missing_features_reason));
  if (!has_any)
    throw InputError(fmt::format("{}: contains no {}", arguments.files.front(),
                                 wants_features ? "features" : "poses"));
  if (features.size() == 1)
    return wants_features ? FormatFeatures(features.front().dataset)
                          : FormatPoses(poses.front().poses);
  return wants_features ? FormatFeatures(features) : FormatPoses(poses);
}

// Returns a message with the number of features or poses written.
std::string CsvText(const std::string& output,
                    const ExchangeContents& contents) {
  size_t features = 0, images = 0, poses = 0;
  for (const InputCamera& camera : contents.cameras) {
    features += Dataset{camera.lens.size, camera.features}.num_features();
    images += camera.features.size();
    poses += camera.poses.size();
  }
  if (EndsWith(std::filesystem::path(output).stem().string(), "poses"))
    return CountText(poses, "pose");
  return fmt::format("{} in {}", CountText(features, "feature"),
                     CountText(images, "image"));
}

// Returns the files of several cameras: those of a rig next to rig.yaml, as
// calibrate writes them; others in the specified folder.
std::vector<std::pair<std::string, std::string>> MakeOutputFiles(
    const ImportArguments& arguments, const ExchangeContents& contents) {
  const auto text_of = [](const InputCamera& camera) {
    return FormatCameraFile(MakeCameraFile(camera), Digits::kAll);
  };
  if (std::filesystem::path(arguments.output).extension() == ".csv")
    return {{arguments.output, MakeCsvName(arguments, contents)}};
  if (contents.cameras.size() == 1)
    return {{arguments.output, text_of(contents.cameras.front())}};
  const std::vector<std::string> names = FolderNames(arguments, contents);
  const std::filesystem::path output = arguments.output;
  const std::filesystem::path folder =
      contents.IsRig() ? output.parent_path() : output;
  if (!contents.IsRig()) RequireCreatableFolder(arguments.output);
  std::vector<std::pair<std::string, std::string>> files;
  std::vector<RigFileCamera> rig;
  for (size_t c = 0; c < names.size(); ++c) {
    const std::string file = names[c] + "/camera.yaml";
    files.emplace_back((folder / file).string(), text_of(contents.cameras[c]));
    rig.push_back(
        {names[c], file, contents.cameras[c].camera_from_rig.value_or(Pose{})});
  }
  if (contents.IsRig())
    files.emplace_back(arguments.output, FormatRigFile(rig));
  return files;
}

// Returns the camera files of puzzlepaint in a folder, sorted by number.
std::vector<std::string> ListStateCameras(const std::filesystem::path& folder) {
  std::vector<std::string> files;
  const auto next = [&] {
    return folder / fmt::format("intrinsics{}.yaml", files.size());
  };
  while (std::filesystem::exists(next())) files.push_back(next().string());
  return files;
}

// Returns the camera files in a folder: of COLMAP, preferring its binary
// format, or of puzzlepaint.
std::vector<std::string> ListFiles(const std::filesystem::path& folder) {
  for (const char* name : {"cameras.bin", "cameras.txt"})
    if (std::filesystem::exists(folder / name))
      return {(folder / name).string()};
  std::vector<std::string> files = ListStateCameras(folder);
  if (files.empty())
    throw InputError(
        folder.string() +
        ": the folder contains neither cameras.bin nor cameras.txt (COLMAP) "
        "nor intrinsics0.yaml (puzzlepaint); specify a file");
  return files;
}

// Whether to import a rig: given puzzlepaint's first camera file, all cameras
// in its folder are imported.
bool IsFirstRigFile(const ImportArguments& arguments) {
  const std::filesystem::path first = arguments.files.front();
  return arguments.files.size() == 1 &&
         first.filename() == "intrinsics0.yaml" &&
         EndsWith(std::filesystem::path(arguments.output).stem(), "rig");
}

// Replaces folders by the files in them.
void FindFiles(ImportArguments* arguments) {
  std::vector<std::string> files;
  for (const std::string& path : arguments->files)
    if (ParseBagArgument(path))
      files.push_back(arguments->topic.empty() ? path
                                               : path + ":" + arguments->topic);
    else if (!arguments->topic.empty())
      throw Error(ExitCode::kUsage,
                  fmt::format("--topic: {} is not a bag", path));
    else if (std::filesystem::is_directory(path))
      for (const std::string& file : ListFiles(path)) files.push_back(file);
    else
      files.push_back(path);
  arguments->files = files;
  if (IsFirstRigFile(*arguments))
    arguments->files =
        ListStateCameras(std::filesystem::path(files.front()).parent_path());
}

void RunImport(ImportArguments arguments, const CommonOptions& common) {
  FindFiles(&arguments);
  std::vector<std::string> texts;
  for (const std::string& path : arguments.files)
    texts.push_back(ReadCameraBytes(path));
  if (const TableFormat* table = SelectTable(arguments, texts)) {
    ImportTable(*table, arguments, texts[0], common);
    return;
  }
  RequireNoView(arguments);
  if (ImportBoards(arguments, texts, common)) return;
  if (const auto corners = ReadCorners(arguments, texts)) {
    ImportCorners(*corners, arguments, common);
    return;
  }
  const ExchangeContents contents = ReadForeign(arguments, texts);
  if (contents.cameras.empty()) {
    ImportCorners(contents, arguments, common);
    return;
  }
  const auto files = MakeOutputFiles(arguments, contents);
  std::vector<std::string> paths;
  OutputFiles outputs;
  for (const auto& [path, text] : files) {
    paths.push_back(path);
    outputs.Add(path, text);
  }
  RequireNoInputReplaced(arguments.files, paths);
  outputs.Commit();
  for (const std::string& warning : contents.warnings)
    fmt::print(stderr, "raygrid: {}\n", Printable(warning));
  if (common.json) {
    nlohmann::ordered_json json = {{"rig", contents.IsRig()},
                                   {"cameras", nlohmann::ordered_json::array()},
                                   {"warnings", contents.warnings}};
    for (const InputCamera& camera : contents.cameras)
      json["cameras"].push_back(
          {{"name", camera.name},
           {"model", camera.lens.external_model->model},
           {"file_model", camera.lens.external_model->name},
           {"image_size", {camera.lens.size.width, camera.lens.size.height}}});
    PrintCommandJson(json);
    return;
  }
  if (common.quiet) return;
  if (std::filesystem::path(arguments.output).extension() == ".csv") {
    fmt::print("{}: {}\n", arguments.output,
               CsvText(arguments.output, contents));
    return;
  }
  for (size_t c = 0; c < contents.cameras.size(); ++c) {
    const ConvertedCamera& lens = contents.cameras[c].lens;
    fmt::print("{}: {} of {} x {} px, imported as {}\n",
               paths[std::min(c, paths.size() - 1)], lens.external_model->name,
               lens.size.width, lens.size.height, lens.external_model->model);
  }
  if (contents.IsRig() && paths.size() > 1)
    fmt::print("{}: rig\n", arguments.output);
}

}  // namespace

void AddImport(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "import", "Convert another tool's calibration to raygrid files.",
      "raygrid import calibration.xml -o camera.yaml", common);
  auto arguments = std::make_shared<ImportArguments>();
  command
      ->add_option("files", arguments->files,
                   "another tool's files, the folder of a COLMAP model, or a "
                   "bag; raygrid export --list names the formats")
      ->required();
  command
      ->add_option("--from", arguments->from,
                   "format of the file (default: detected from its contents)")
      ->option_text("FORMAT");
  command
      ->add_option("--image-size", arguments->image_size,
                   "image size in px, if the file does not contain it")
      ->option_text("WxH");
  command
      ->add_option("--topic", arguments->topic,
                   "topic of sensor_msgs/CameraInfo, if a bag has several")
      ->option_text("TOPIC");
  command->add_flag("--inverse", arguments->is_reverse,
                    "the STMap maps camera pixels to undistorted pixels "
                    "(default: undistorted to camera)");
  BeginGroup(command, help_group::kModel);
  command
      ->add_option("--model", arguments->model,
                   "distortion model, if the file does not contain it; for ray "
                   "tables central-generic or noncentral-generic")
      ->option_text("NAME");
  BeginGroup(command, help_group::kTarget);
  command
      ->add_option("--board-size", arguments->board,
                   "inner corners, if the file does not contain them (mrcal "
                   "corners.vnl, OpenCV image_points)")
      ->option_text("COLUMNSxROWS");
  AddViewOptions(command, &arguments->view);
  BeginGroup(command, help_group::kOutput);
  command
      ->add_option("-o,--output", arguments->output,
                   "camera.yaml, rig.yaml (cameras in NAME/camera.yaml), "
                   "features.csv, poses.csv, pattern.yaml, or a folder")
      ->option_text("PATH")
      ->required();
  command->callback([arguments, common] { RunImport(*arguments, *common); });
}

}  // namespace raygrid
