#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>

#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/yaml_file.h"
#include "exchange/basalt_format.h"
#include "exchange/colmap_format.h"
#include "exchange/depthai_format.h"
#include "exchange/format.h"
#include "exchange/kalibr_format.h"
#include "exchange/kalibr_target_format.h"
#include "exchange/libcamera_format.h"
#include "exchange/metashape_format.h"
#include "exchange/mrcal_corners_format.h"
#include "exchange/mrcal_format.h"
#include "exchange/nerfstudio_format.h"
#include "exchange/opencv_format.h"
#include "exchange/photonvision_format.h"
#include "exchange/puzzlepaint_format.h"
#include "exchange/puzzlepaint_pattern_format.h"
#include "exchange/ros_format.h"

namespace raygrid {
namespace {

// Says what a user may not expect of the lenses, all of which are made.
void AddRemarksOnLenses(ExchangeContents* contents) {
  constexpr double kFarM = 10;
  double farthest_m = 0;
  for (const ReadLens& camera : contents->cameras) {
    const double part = PartWithoutRays(*MakeLens(camera.lens));
    if (part > 0)
      contents->remarks.push_back(fmt::format(
          "{}{:.1f} % of the image looks nowhere: there the distortion folds, "
          "or ends",
          contents->cameras.size() > 1 ? camera.name + ": " : "", 100 * part));
    if (camera.camera_from_rig)
      farthest_m =
          std::max(farthest_m, camera.camera_from_rig->translation.norm());
  }
  if (farthest_m > kFarM)
    contents->remarks.push_back(fmt::format(
        "its cameras stand {:g} m apart, if lengths are metres, as they are "
        "taken here",
        farthest_m));
}

// Throws for a file whose loss would be one: that of a reconstruction.
void RequireNoOther(const BesideFile& file) {
  if (std::filesystem::exists(file.path) && ReadFile(file.path) != file.text)
    throw Error(ExitCode::kOutput,
                file.path +
                    ": is there, and of something else; write into another "
                    "folder");
}

void AddFiles(const std::vector<BesideFile>& written,
              std::vector<std::pair<std::string, std::string>>* files) {
  for (const BesideFile& file : written) {
    if (file.is_never_replaced) RequireNoOther(file);
    files->emplace_back(file.path, file.text);
  }
}

[[noreturn]] void ThrowOnCorners(const std::string& path) {
  throw InputError(
      fmt::format("{}: has corners, and no camera; 'raygrid import' makes "
                  "features.csv of them, for calibrate --features",
                  path));
}

}  // namespace

const std::vector<Format>& Formats() {
  static const std::vector<Format> formats = {
      OpenCvFormat(),       RosFormat(),          KalibrFormat(),
      KalibrTargetFormat(), ColmapFormat(),       MrcalCornersFormat(),
      MrcalFormat(),        BasaltFormat(),       NerfstudioFormat(),
      MetashapeFormat(),    PuzzlepaintFormat(),  DepthAiFormat(),
      LibcameraFormat(),    PhotonVisionFormat(), PuzzlepaintPatternFormat()};
  return formats;
}

const LensForm* Format::FindForm(const std::string& form) const {
  for (const LensForm& known : forms)
    if (known.name == form) return &known;
  return nullptr;
}

std::vector<const LensForm*> Format::FindForms(const std::string& model) const {
  const bool is_named = FindForm(model) != nullptr;
  std::vector<const LensForm*> chosen;
  std::string names;
  for (const LensForm& form : forms) {
    if (model.empty() ? !form.is_only_asked : model == form.name)
      chosen.push_back(&form);
    names += (names.empty() ? "" : ", ") + form.name;
  }
  for (const LensForm& form : forms)
    if (!is_named && form.model == model && !form.is_only_asked)
      chosen.push_back(&form);
  if (chosen.empty())
    throw Error(ExitCode::kUsage,
                fmt::format("--model {}: {} has {}", model, name, names));
  return chosen;
}

const Format& FindFormat(const std::string& option, const std::string& name) {
  for (const Format& format : Formats())
    if (format.name == name) return format;
  throw Error(ExitCode::kUsage, fmt::format("{} {}: not a format; use {}",
                                            option, name, FormatNames()));
}

const Format* RecognizeFormat(const std::string& text) {
  for (const char* own : {"raygrid_camera:", "raygrid_rig:"})
    if (text.find(own) != std::string::npos) return nullptr;
  for (const Format& format : Formats())
    if (format.recognizes(text)) return &format;
  return nullptr;
}

std::string FormatNames() {
  const std::vector<Format>& formats = Formats();
  std::string names = formats.front().name;
  for (size_t k = 1; k < formats.size(); ++k)
    names += (k + 1 < formats.size() ? ", " : " or ") + formats[k].name;
  return names;
}

ExchangeContents ReadExchangeFile(const Format* format,
                                  const ReadRequest& request) {
  const Format* found = RecognizeFormat(request.text);
  if (!format && !found)
    throw InputError(fmt::format("{}: of no format that is known: {}",
                                 request.path, FormatNames()));
  if (format && found && format != found && !format->recognizes(request.text))
    throw InputError(fmt::format("{}: is of the format {}, not {}",
                                 request.path, found->name, format->name));
  return ReadNamingFile(request.path, [&] {
    ExchangeContents contents = (format ? format : found)->read(request);
    if (contents.cameras.empty() && contents.corners.empty() &&
        contents.boards.empty())
      throw InputError((format ? format : found)->takes_board ? "no corners"
                                                              : "no camera");
    AddRemarksOnLenses(&contents);
    return contents;
  });
}

void RequireCameraFormat(const Format& format, const std::string& path) {
  if (!format.forms.empty()) return;
  if (format.takes_board) ThrowOnCorners(path);
  throw InputError(
      fmt::format("{}: has a board, and no camera; 'raygrid import' makes "
                  "pattern.yaml of it, for --pattern",
                  path));
}

void RequireCameras(const ExchangeContents& contents, const std::string& path) {
  if (contents.cameras.empty()) ThrowOnCorners(path);
}

std::vector<std::string> ReadBeside(const Format& format,
                                    const std::string& path) {
  std::vector<std::string> texts;
  if (!format.beside) return texts;
  for (const std::string& beside : format.beside(path))
    texts.push_back(std::filesystem::exists(beside) ? ReadFile(beside) : "");
  return texts;
}

std::vector<std::pair<std::string, std::string>> WriteWithBeside(
    const Format& format, WriteRequest request) {
  std::vector<std::pair<std::string, std::string>> files = {
      {request.path, format.write(request)}};
  if (!format.write_beside) return files;
  if (format.file_in_folder) request.beside = ReadBeside(format, request.path);
  AddFiles(format.write_beside(request), &files);
  return files;
}

std::vector<std::pair<std::string, std::string>> WriteFolder(
    const Format& format, WriteRequest request) {
  std::vector<std::pair<std::string, std::string>> files;
  if (format.write_folder) {
    request.beside = ReadBeside(format, format.file_in_folder(request.path, 0));
    AddFiles(format.write_folder(request), &files);
    return files;
  }
  for (const WrittenLens& lens : request.cameras) {
    const std::string path =
        (std::filesystem::path(request.path) / (lens.name + format.ending))
            .string();
    files.emplace_back(path, format.write({path, {lens}}));
  }
  return files;
}

bool ExchangeContents::IsRig() const {
  return cameras.size() > 1 &&
         std::all_of(cameras.begin(), cameras.end(), [](const ReadLens& lens) {
           return lens.camera_from_rig.has_value();
         });
}

void FindPosesOfPair(std::vector<ReadLens>* cameras) {
  bool is_pair = false;
  for (const ReadLens& camera : *cameras) {
    if (!camera.rectified) return;
    is_pair = is_pair || camera.rectified->IsBeside();
  }
  if (!is_pair) return;
  // The views stand apart by the last column of P, in focal lengths.
  const auto view_from_rig = [](const RectifiedProjection& view) {
    return Pose{Eigen::Quaterniond(view.r),
                {view.p(0, 3) / view.p(0, 0), view.p(1, 3) / view.p(1, 1), 0}};
  };
  const Pose first = view_from_rig(*cameras->front().rectified);
  for (ReadLens& camera : *cameras) {
    // x_i = R_i^T (R_0 x_0 + t_i - t_0)
    const Pose own = view_from_rig(*camera.rectified);
    const Eigen::Quaterniond back = own.rotation.conjugate();
    camera.camera_from_rig = Pose{(back * first.rotation).normalized(),
                                  back * (own.translation - first.translation)};
  }
}

void RequireOneBoard(const std::string& program,
                     const std::vector<WrittenLens>& cameras) {
  const BoardPose* first = nullptr;
  for (const WrittenLens& camera : cameras)
    for (const BoardPose& pose : camera.poses) {
      if (!first) first = &pose;
      if (pose.board != first->board)
        throw InputError(fmt::format(
            "--poses: those of board {} and board {}, while images of {} stand "
            "in one world; give those of one board",
            first->board, pose.board, program));
    }
}

CameraFile CameraFileOf(const ReadLens& read) {
  CameraFile file;
  file.camera = MakeLens(read.lens);
  file.name = read.name;
  file.serial = read.serial;
  if (read.trusted) file.uncertainty = CameraUncertainty::OfMask(*read.trusted);
  return file;
}

}  // namespace raygrid
