#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "bag_input.h"
#include "bags/camera_info.h"
#include "bags/mcap_writer.h"
#include "bags/message_writer.h"
#include "camera_input.h"
#include "commands.h"
#include "dataset/dataset.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/rectified_file.h"
#include "dataset/rig_file.h"
#include "dataset/text_encoding.h"
#include "exchange/format.h"
#include "exchange/ros_format.h"
#include "exchange/table_format.h"
#include "exchange/valid_region.h"
#include "help_formatter.h"
#include "json_output.h"
#include "packing/rectification.h"
#include "packing/view_request.h"
#include "pattern_input.h"
#include "table_export.h"
#include "view_options.h"

namespace raygrid {
namespace {

struct ExportArguments {
  std::string input, format, model, output, poses;
  std::string address, every, pattern;
  std::vector<std::string> image_sizes;
  std::optional<double> max_fit_error_px;
  bool lists = false, rectified = false, is_reverse = false;
  ViewKeyValues view;
};

// A camera to be exported.
struct Exported {
  std::string name, path;
  CameraInput input;
  std::optional<Pose> camera_from_rig = {};
  std::optional<ValidityMask> valid_region = {};
  std::optional<RectifiedProjection> rectified = {};  // if already determined
  Eigen::Quaterniond view_from_camera = Eigen::Quaterniond::Identity();
};

Exported MakeExported(const std::string& path, CameraInput input) {
  Exported camera = {input.file.name, path, std::move(input)};
  if (camera.input.file.camera_from_view)
    camera.view_from_camera =
        camera.input.file.camera_from_view->rotation.conjugate();
  camera.valid_region = LoadValidityMask(camera.input);
  return camera;
}

// Returns the views of a rectified pair, as a rig in the left view's frame.
std::vector<Exported> ReadPairOfViews(const std::string& path,
                                      const std::string& text) {
  const RectifiedFile pair = ParseRectifiedFile(path, text);
  std::vector<Exported> cameras;
  for (int c = 0; c < 2; ++c) {
    const Eigen::Matrix<double, 3, 4>& p = pair.p[c];
    VirtualView view;
    view.size = pair.size;
    view.focal_px = {p(0, 0), p(1, 1)};
    view.center_px = {p(0, 2), p(1, 2)};
    CameraInput input;
    input.file.camera = MakeViewCamera(view);
    input.file.name = pair.names[c];
    cameras.push_back(MakeExported(path, std::move(input)));
    cameras.back().camera_from_rig =
        Pose{Eigen::Quaterniond::Identity(),
             {p(0, 3) / p(0, 0), p(1, 3) / p(1, 1), 0}};
    cameras.back().rectified =
        RectifiedProjection{Eigen::Matrix3d::Identity(), p};
  }
  return cameras;
}

// Throws for poses.csv, which is exported together with a camera, and for
// features.csv, which is exported alone.
void RequireNoCsv(const std::string& path, const std::string& bytes) {
  const std::string header = bytes.substr(0, bytes.find('\n'));
  if (header.find(",qw,qx,qy,qz,") != std::string::npos)
    throw InputError(
        fmt::format("{}: contains poses but no camera; export the camera with "
                    "--poses, or the poses alone with --to tum",
                    path));
  if (header.find(",board,column,row,") != std::string::npos)
    throw InputError(
        fmt::format("{}: contains features but no camera; export them with "
                    "--to puzzlepaint-dataset",
                    path));
}

// Returns the cameras of a rig, or a single camera.
std::vector<Exported> ReadExported(const std::string& path,
                                   const RequestedOperatingPoint& at,
                                   bool* is_rig) {
  const std::string bytes = ReadFile(path);
  RequireNoCsv(path, bytes);
  std::vector<Exported> cameras;
  *is_rig = bytes.find("raygrid_rectified:") != std::string::npos;
  if (*is_rig) return ReadPairOfViews(path, bytes);
  *is_rig = bytes.find("raygrid_rig:") != std::string::npos;
  if (!*is_rig) {
    cameras.push_back(MakeExported(path, ParseCamera(path, bytes, at)));
    return cameras;
  }
  const std::filesystem::path folder =
      std::filesystem::path(path).parent_path();
  for (const RigFileCamera& camera : ParseRigFile(path, bytes)) {
    const std::string file = (folder / camera.file).string();
    cameras.push_back(MakeExported(file, ReadCamera(file)));
    cameras.back().name = camera.name;
    cameras.back().camera_from_rig = camera.camera_from_rig;
  }
  return cameras;
}

void ReplaceByView(const ViewKeyValues& words, Exported* camera) {
  const VirtualView view = RectifiedView(camera->input, words);
  camera->input.file.camera = MakeViewCamera(view);
  camera->input.file.camera_from_view.reset();
  camera->view_from_camera =
      Eigen::Quaterniond(view.camera_from_view.transpose());
  if (camera->camera_from_rig)
    camera->camera_from_rig =
        Pose{camera->view_from_camera, Eigen::Vector3d::Zero()} *
        *camera->camera_from_rig;
  camera->valid_region.reset();
}

// Returns the advice to export the pinhole camera of undistorted images
// instead, which is exact, with its field of view.
std::string MakeViewAdvice(const CameraModel& camera) {
  try {
    const VirtualView view = MakeAreaView(camera);
    return fmt::format(
        "or export the pinhole camera of undistorted images with --rectified "
        "({:.0f} x {:.0f} degrees)",
        view.HorizontalFieldOfViewDeg(), view.VerticalFieldOfViewDeg());
  } catch (const Error&) {
    return "use another format or model";
  }
}

void RequireSmallError(const Exported& camera, const SelectedModel& chosen,
                       const std::optional<double>& max_fit_error_px) {
  if (!max_fit_error_px || !chosen.fit) return;
  const ModelFit& fit = *chosen.fit;
  if (fit.num_unrepresentable == 0 && fit.max_px <= *max_fit_error_px) return;
  throw Error(
      ExitCode::kQualityTooLow,
      fmt::format(
          "{}: the fit error of {} exceeds --max-fit-error-px {:g}: {}; {}",
          camera.path, chosen.lens.external_model->name, *max_fit_error_px,
          FormatModelFit(fit), MakeViewAdvice(*camera.input.file.camera)));
}

// If the rig's frame is that of its first camera, makes it the frame of the
// first lens.
void KeepFirstFrame(const std::vector<Exported>& cameras,
                    std::vector<OutputCamera>* lenses) {
  const std::optional<Pose>& first = cameras.front().camera_from_rig;
  if (!first || !first->translation.isZero(0) ||
      first->rotation.angularDistance(Eigen::Quaterniond::Identity()) > 0)
    return;
  const Pose old_from_new = lenses->front().camera_from_rig->Inverse();
  for (OutputCamera& lens : *lenses)
    lens.camera_from_rig = *lens.camera_from_rig * old_from_new;
}

std::vector<OutputCamera> SelectModels(const ExportArguments& arguments,
                                       const Format& format,
                                       const std::vector<Exported>& cameras,
                                       int num_threads) {
  const std::vector<const ExternalModel*> external_models =
      format.FindModels(arguments.model);
  std::vector<OutputCamera> lenses;
  for (const Exported& camera : cameras) {
    const bool is_any_valid =
        camera.valid_region && camera.valid_region->HasValidCells();
    SelectedModel chosen = [&] {
      try {
        return SelectExternalModel(
            external_models, *camera.input.file.camera,
            is_any_valid ? &*camera.valid_region : nullptr, num_threads);
      } catch (const Error& error) {
        throw Error(error.code(),
                    fmt::format("{}: {}", camera.path, error.what()));
      }
    }();
    RequireSmallError(camera, chosen, arguments.max_fit_error_px);
    OutputCamera lens;
    lens.name = camera.name;
    lens.serial = camera.input.file.serial;
    lens.lens = chosen.lens;
    lens.fit = chosen.fit;
    lens.camera_from_rig = camera.camera_from_rig;
    lens.rectified = camera.rectified;
    lens.valid_region = camera.valid_region;
    if (lens.fit && lens.camera_from_rig)
      lens.camera_from_rig =
          Pose{lens.fit->fitted_from_camera, Eigen::Vector3d::Zero()} *
          *lens.camera_from_rig;
    lenses.push_back(std::move(lens));
  }
  KeepFirstFrame(cameras, &lenses);
  return lenses;
}

// Adds the matrices R and P of a rectified pair for formats that store them.
// Warns on standard error if rectified images have no common rows.
void RectifyPair(const Format& format, std::vector<OutputCamera>* lenses) {
  if (!format.supports_pairs || lenses->size() != 2 ||
      !lenses->front().camera_from_rig || lenses->front().rectified)
    return;
  std::array<OutputCamera*, 2> pair = {&(*lenses)[0], &(*lenses)[1]};
  if (IsOrderReversed(*pair[1]->camera_from_rig *
                      pair[0]->camera_from_rig->Inverse()))
    std::swap(pair[0], pair[1]);
  const auto first = MakeCameraModel(pair[0]->lens),
             second = MakeCameraModel(pair[1]->lens);
  try {
    const Rectification rectification =
        Rectify({pair[0]->name, *first, *pair[0]->camera_from_rig},
                {pair[1]->name, *second, *pair[1]->camera_from_rig}, {});
    for (int k = 0; k < 2; ++k)
      pair[k]->rectified =
          RectifiedProjection{rectification.R(k), rectification.P(k)};
  } catch (const Error& error) {
    fmt::print(stderr,
               "raygrid: R and P of a rectified pair are not written: {}\n",
               error.what());
  }
}

// Adds the poses of boards, transformed to the frames of the exported lenses.
void AddPoses(const ExportArguments& arguments, const Format& format,
              const std::vector<Exported>& cameras, bool is_rig,
              std::vector<OutputCamera>* lenses) {
  if (arguments.poses.empty()) return;
  if (!format.supports_poses)
    throw Error(ExitCode::kUsage,
                fmt::format("--poses: not supported by {}", format.name));
  auto poses = ReadPoses(arguments.poses);
  for (size_t c = 0; c < lenses->size(); ++c) {
    OutputCamera& lens = (*lenses)[c];
    const auto own = poses.find(is_rig ? lens.name : "");
    if (own == poses.end()) continue;
    lens.poses = own->second;
    Pose fitted_from_camera = {cameras[c].view_from_camera,
                               Eigen::Vector3d::Zero()};
    if (lens.fit)
      fitted_from_camera =
          Pose{lens.fit->fitted_from_camera, Eigen::Vector3d::Zero()} *
          fitted_from_camera;
    for (BoardPose& pose : lens.poses)
      pose.camera_from_board = fitted_from_camera * pose.camera_from_board;
    poses.erase(own);
  }
  if (!poses.empty())
    throw InputError(fmt::format(
        "{}: contains poses of camera '{}', which is not in {}",
        arguments.poses, Printable(poses.begin()->first), arguments.input));
}

// Sorts cameras in the order in which the format numbers them.
void SortCamerasByName(std::vector<OutputCamera>* lenses) {
  std::stable_sort(lenses->begin(), lenses->end(),
                   [](const OutputCamera& a, const OutputCamera& b) {
                     return a.name < b.name;
                   });
}

bool IsRosBag(const ExportArguments& arguments, const Format& format) {
  return format.name == "ros" && IsBagOutput(arguments.output);
}

// Returns a bag with a CameraInfo for each camera and, for a rig, the static
// transforms from its frame, "rig". All stamps are 0.
std::string MakeCameraInfoBag(const std::vector<OutputCamera>& lenses) {
  std::ostringstream stream;
  McapWriter writer(&stream);
  std::vector<StaticTransform> transforms;
  for (const OutputCamera& lens : lenses) {
    const std::string name = lens.name.empty() ? "camera" : lens.name;
    const RosMatrices matrices = MakeRosMatrices(lens);
    CameraInfo info;
    info.width = static_cast<uint32_t>(lens.lens.size.width);
    info.height = static_cast<uint32_t>(lens.lens.size.height);
    info.model = lens.lens.external_model->name;
    info.d = matrices.d;
    info.k = matrices.k;
    info.r = matrices.r;
    info.p = matrices.p;
    writer.Write(writer.AddTopic("/" + name + "/camera_info",
                                 "sensor_msgs/msg/CameraInfo"),
                 0, WriteCameraInfo({0, name}, info));
    if (!lens.camera_from_rig) continue;
    const Pose rig_from_camera = lens.camera_from_rig->Inverse();
    const Eigen::Vector3d& t = rig_from_camera.translation;
    const Eigen::Quaterniond& q = rig_from_camera.rotation;
    transforms.push_back({{0, "rig"},
                          name,
                          {t.x(), t.y(), t.z()},
                          {q.x(), q.y(), q.z(), q.w()}});
  }
  if (!transforms.empty())
    writer.Write(writer.AddTopic("/tf_static", "tf2_msgs/msg/TFMessage"), 0,
                 WriteTransforms(transforms));
  writer.Finish();
  return stream.str();
}

// Returns the output files as names and contents. A rig becomes a folder if the
// format stores one camera per file.
std::vector<std::pair<std::string, std::string>> WriteAll(
    const ExportArguments& arguments, const Format& format,
    const std::vector<OutputCamera>& lenses, bool is_rig) {
  if (IsRosBag(arguments, format))
    return {{arguments.output, MakeCameraInfoBag(lenses)}};
  const bool is_folder = is_rig && !format.supports_rigs;
  return is_folder ? WriteFolder(format, {arguments.output, lenses})
                   : WriteWithCompanions(format, {arguments.output, lenses});
}

nlohmann::ordered_json FitJson(const ModelFit& fit) {
  const Eigen::Quaterniond& q = fit.fitted_from_camera;
  return {{"rms_px", fit.rms_px},
          {"p99_px", fit.p99_px},
          {"max_px", fit.max_px},
          {"pixels", fit.num_pixels},
          {"num_unrepresentable_pixels", fit.num_unrepresentable},
          {"valid_region_only", fit.has_valid_region},
          {"model_from_camera_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

void PrintExport(const Format& format, const std::vector<OutputCamera>& lenses,
                 const std::vector<std::pair<std::string, std::string>>& files,
                 const CommonOptions& common) {
  if (common.json) {
    nlohmann::ordered_json json = {
        {"format", format.name},
        {"files", nlohmann::ordered_json::array()},
        {"cameras", nlohmann::ordered_json::array()}};
    for (const auto& file : files) json["files"].push_back(file.first);
    for (const OutputCamera& lens : lenses) {
      json["cameras"].push_back({{"name", lens.name},
                                 {"model", lens.lens.external_model->name},
                                 {"exact", !lens.fit.has_value()}});
      if (lens.fit) json["cameras"].back()["fit"] = FitJson(*lens.fit);
    }
    PrintCommandJson(json);
    return;
  }
  if (common.quiet) return;
  for (size_t c = 0; c < lenses.size(); ++c) {
    const OutputCamera& lens = lenses[c];
    fmt::print("{}{}: {}, {}\n",
               files[format.supports_rigs || files.size() == 1 ? 0 : c].first,
               lens.name.empty() ? "" : " " + lens.name,
               lens.lens.external_model->name,
               lens.fit ? FormatModelFit(*lens.fit) : "exact");
  }
}

// Returns the options given by the user that not every format supports.
std::vector<std::string> ListGivenOptions(const ExportArguments& arguments) {
  std::vector<std::string> given;
  for (const auto& [name, is_given] :
       {std::pair("model", !arguments.model.empty()),
        {"max-fit-error-px", arguments.max_fit_error_px.has_value()},
        {"rectified", arguments.rectified},
        {"poses", !arguments.poses.empty()},
        {"address", !arguments.address.empty()},
        {"stride", !arguments.every.empty()},
        {"pattern", !arguments.pattern.empty()},
        {"image-size", !arguments.image_sizes.empty()},
        {"inverse", arguments.is_reverse}})
    if (is_given) given.push_back(name);
  return given;
}

// Throws for options that the chosen kind of format does not support.
void RequireSupportedOptions(const ExportArguments& arguments,
                             const TableFormat* table) {
  const auto refuse = [&](const std::string& option) {
    throw Error(ExitCode::kUsage, fmt::format("--{}: not supported by --to {}",
                                              option, arguments.format));
  };
  static const std::set<std::string> camera_options = {
      "model", "max-fit-error-px", "rectified", "poses"};
  if (table && table->write_poses && !arguments.poses.empty())
    throw Error(ExitCode::kUsage,
                fmt::format("--poses: {} is written from poses.csv alone: "
                            "raygrid export poses.csv --to {}",
                            table->name, table->name));
  for (const std::string& option : ListGivenOptions(arguments))
    if (table ? !table->AcceptsOption(option)
              : camera_options.count(option) == 0)
      refuse(option);
  const std::string word = FirstToken(arguments.view);
  if (table && !table->IsOfView() && !word.empty()) refuse(word);
}

void ListCameras(bool json, nlohmann::ordered_json* all) {
  for (const Format& format : GetFormats()) {
    const char* const ways = !format.write  ? "import"
                             : !format.read ? "export"
                                            : "export, import";
    nlohmann::ordered_json models = nlohmann::ordered_json::array();
    std::string names;
    for (const ExternalModel& external_model : format.external_models) {
      models.push_back(external_model.name);
      names += (names.empty() ? "" : ", ") + external_model.name;
    }
    all->push_back({{"name", format.name},
                    {"description", format.holds},
                    {"source", "a lens"},
                    {"can_export", format.write != nullptr},
                    {"can_import", format.read != nullptr},
                    {"rigs", format.supports_rigs},
                    {"poses", format.supports_poses},
                    {"models", models}});
    if (!json)
      fmt::print("{}: {} ({})\n{}", format.name, format.holds, ways,
                 names.empty() ? "" : "  models: " + names + "\n");
  }
}

void ListTables(bool json, nlohmann::ordered_json* all) {
  for (const TableFormat& format : TableFormats()) {
    all->push_back({{"name", format.name},
                    {"description", format.holds},
                    {"source", format.Source()},
                    {"can_export", true},
                    {"can_import", format.IsImported()},
                    {"options", format.options},
                    {"models", format.models}});
    if (!json)
      fmt::print("{}: {} ({})\n  source: {}{}{}\n", format.name, format.holds,
                 format.IsImported() ? "export, import" : "export",
                 format.Source(), format.models.empty() ? "" : "; models: ",
                 fmt::join(format.models, ", "));
  }
}

void List(bool json) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  ListCameras(json, &all);
  ListTables(json, &all);
  if (json) fmt::print("{}\n", all.dump(2));
}

const Format& FindWrittenFormat(const std::string& name) {
  for (const Format& format : GetFormats())
    if (format.name == name && format.write) return format;
  throw Error(ExitCode::kUsage, fmt::format("--to {}: unknown format; use {}",
                                            name, WrittenFormatNames()));
}

// Prints on standard error how a stored polygon differs from the valid region.
void PrintRegions(const std::vector<OutputCamera>& lenses) {
  for (const OutputCamera& lens : lenses) {
    if (!lens.valid_region) continue;
    const RegionLoss loss =
        ComputeRegionLoss(*lens.valid_region, lens.lens.size);
    if (loss.num_left_out == 0 && loss.num_held == 0) continue;
    const double cell_fraction =
        std::pow(lens.valid_region->knot_spacing_px, 2) / lens.lens.size.width /
        lens.lens.size.height;
    fmt::print(stderr,
               "raygrid: the format stores the valid region{} as one polygon "
               "without holes: it omits {:.1f} % of the image that is valid "
               "and includes {:.1f} % that is not\n",
               lens.name.empty() ? "" : " of " + Printable(lens.name),
               100 * cell_fraction * loss.num_left_out,
               100 * cell_fraction * loss.num_held);
  }
}

// Whether the output loses the relative poses of a rig's cameras. For a pair,
// rectified views imply them; other rigs, and pairs without common views, have
// none.
bool DropsPoses(const Format& format, const std::vector<OutputCamera>& lenses) {
  if (format.discards_rig_poses) return true;
  return format.supports_pairs && !format.supports_rigs &&
         std::any_of(lenses.begin(), lenses.end(),
                     [](const OutputCamera& lens) { return !lens.rectified; });
}

void ExportCameras(const ExportArguments& arguments, const Format& format,
                   const CommonOptions& common) {
  const std::string word = FirstToken(arguments.view);
  if (!word.empty() && !arguments.rectified)
    throw Error(ExitCode::kUsage,
                fmt::format("--{}: requires --rectified", word));
  bool is_rig = false;
  std::vector<Exported> cameras =
      ReadExported(arguments.input, common.at, &is_rig);
  std::vector<std::string> inputs = {arguments.input, arguments.poses};
  for (Exported& camera : cameras) {
    inputs.push_back(camera.path);
    if (!common.quiet)
      WarnAboutFailedCalibration(camera.path, camera.input.file);
    if (arguments.rectified) ReplaceByView(arguments.view, &camera);
  }
  std::vector<OutputCamera> lenses =
      SelectModels(arguments, format, cameras, common.threads);
  AddPoses(arguments, format, cameras, is_rig, &lenses);
  RectifyPair(format, &lenses);
  if (format.write_folder) SortCamerasByName(&lenses);
  const auto files = WriteAll(arguments, format, lenses, is_rig);
  std::vector<std::string> paths;
  OutputFiles outputs;
  for (const auto& [path, text] : files) {
    paths.push_back(path);
    outputs.Add(path, text);
  }
  RequireNoInputReplaced(inputs, paths);
  outputs.Commit();
  for (const OutputCamera& lens : lenses)
    if (lens.fit && lens.fit->num_unrepresentable > 0)
      fmt::print(stderr,
                 "raygrid: {} cannot represent {} of {} pixels{}, up to {:.0f} "
                 "degrees off axis\n",
                 lens.lens.external_model->name, lens.fit->num_unrepresentable,
                 lens.fit->num_unrepresentable + lens.fit->num_pixels,
                 lens.name.empty() ? "" : " of " + Printable(lens.name),
                 lens.fit->max_valid_angle_rad * 180 / M_PI);
  if (format.supports_region) PrintRegions(lenses);
  if (is_rig && !IsRosBag(arguments, format) && DropsPoses(format, lenses))
    fmt::print(stderr,
               "raygrid: camera poses are not written: {} cannot store {}poses "
               "of a rig; use --to opencv or --to kalibr\n",
               format.name,
               format.supports_pairs ? "more than a stereo pair's " : "");
  PrintExport(format, lenses, files, common);
}

void RunExport(const ExportArguments& arguments, const CommonOptions& common) {
  if (arguments.lists) {
    List(common.json);
    return;
  }
  for (const auto& [option, value] : {std::pair("camera", arguments.input),
                                      {"--to", arguments.format},
                                      {"-o", arguments.output}})
    if (value.empty())
      throw Error(ExitCode::kUsage,
                  fmt::format("export: {} is required; see raygrid export "
                              "--help",
                              option));
  const TableFormat* table = FindTableFormat(arguments.format);
  RequireSupportedOptions(arguments, table);
  if (table)
    ExportTable(
        *table,
        {arguments.input, arguments.output, arguments.model, arguments.address,
         arguments.every, arguments.max_fit_error_px, arguments.view,
         arguments.is_reverse, arguments.pattern, arguments.image_sizes},
        common);
  else
    ExportCameras(arguments, FindWrittenFormat(arguments.format), common);
}

}  // namespace

void AddExport(CLI::App* app, CommonOptions* common) {
  CLI::App* command =
      AddCommand(app, "export",
                 "Convert cameras, views, poses or features for other tools.",
                 "raygrid export camera.yaml --to opencv -o calibration.yaml "
                 "--max-fit-error-px 0.5",
                 common);
  command->footer("Formats for --to (--list describes them):\n" +
                  WrapText(WrittenFormatNames(), 2) + "\n" +
                  command->get_footer());
  auto arguments = std::make_shared<ExportArguments>();
  command->add_option("camera", arguments->input,
                      "camera.yaml, rig.yaml, rectified.yaml, blob, another "
                      "tool's camera, poses.csv or features.csv");
  command
      ->add_option(
          "--poses", arguments->poses,
          "poses.csv to write with the camera, for formats with target poses")
      ->option_text("FILE");
  command
      ->add_option("--image-size", arguments->image_sizes,
                   "size in px of the images that features.csv was detected "
                   "in; NAME=WxH for one camera of a rig")
      ->option_text("WxH");
  BeginGroup(command, help_group::kModel);
  AddAtOption(command, common);
  command
      ->add_option("--model", arguments->model,
                   "camera model of the format (default: model with the fewest "
                   "coefficients among those within 2 % of the lowest error)")
      ->option_text("NAME");
  command
      ->add_option("--max-fit-error-px", arguments->max_fit_error_px,
                   "fail without writing files if the maximum fit error in the "
                   "valid region exceeds this limit (default: no limit)")
      ->option_text("PX")
      ->check(CLI::NonNegativeNumber);
  AddPatternOption(command, &arguments->pattern, "; for features.csv");
  BeginGroup(command, help_group::kView);
  command->add_flag(
      "--rectified", arguments->rectified,
      "export the camera of the undistorted images: the output view stored in "
      "the blob, or the one described by the options below");
  AddViewOptions(command, &arguments->view);
  command->add_flag("--inverse", arguments->is_reverse,
                    "export the inverse remap, which maps undistorted images "
                    "back to the camera image");
  command
      ->add_option("--stride", arguments->every,
                   "rays: sample every N pixels (default: 1); meshes: vertex "
                   "spacing in px (default: 16, vpi 1)")
      ->option_text("N");
  BeginGroup(command, help_group::kOutput);
  command->add_option("--to", arguments->format, "format to write, see below")
      ->option_text("FORMAT");
  command
      ->add_option(
          "-o,--output", arguments->output,
          "output file, common prefix of several files, or folder for a rig; "
          "ros: .mcap for a bag of CameraInfo and static transforms")
      ->option_text("PATH");
  command
      ->add_option("--address", arguments->address,
                   "flash address of the blob for hex, such as 0x08080000")
      ->option_text("ADDRESS");
  command->add_flag("--list", arguments->lists, "list all formats");
  command->callback([arguments, common] { RunExport(*arguments, *common); });
}

}  // namespace raygrid
