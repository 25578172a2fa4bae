#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>

#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/basalt_format.h"
#include "exchange/colmap_format.h"
#include "exchange/depthai_format.h"
#include "exchange/dso_format.h"
#include "exchange/format.h"
#include "exchange/kalibr_format.h"
#include "exchange/kalibr_target_format.h"
#include "exchange/keyed_formats.h"
#include "exchange/lensfun_format.h"
#include "exchange/libcamera_format.h"
#include "exchange/metashape_format.h"
#include "exchange/mrcal_corners_format.h"
#include "exchange/mrcal_format.h"
#include "exchange/nearest_grid.h"
#include "exchange/nerfstudio_format.h"
#include "exchange/ocamcalib_format.h"
#include "exchange/opencv_format.h"
#include "exchange/photonvision_format.h"
#include "exchange/puzzlepaint_format.h"
#include "exchange/puzzlepaint_pattern_format.h"
#include "exchange/python_format.h"
#include "exchange/ros_format.h"
#include "exchange/ros_ini_format.h"

namespace raygrid {
namespace {

// UTF-8 byte order mark, which other programs write.
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

bool HasByteOrderMark(const std::string& text) {
  return text.compare(0, kByteOrderMark.size(), kByteOrderMark) == 0;
}

// Returns the distance of the principal point from the image centre, relative
// to the image size.
double ComputePrincipalPointOffset(const ConvertedCamera& lens, double width,
                                   double height) {
  const Eigen::Vector2d point =
      FromProgram(lens.external_model->origin, lens.size,
                  {lens.Value("cx"), lens.Value("cy")});
  return std::max(std::abs(point.x() / width - 0.5),
                  std::abs(point.y() / height - 0.5));
}

// Throws if lengths are relative to the image size, as in some programs.
// Missing parameters are reported later.
void RequirePixels(const ConvertedCamera& lens) {
  constexpr double kMinFocalPx = 10;
  const auto is_fraction = [&](const char* name, double most) {
    return std::abs(lens.Value(name)) < most;
  };
  if (lens.values.size() < lens.external_model->parameters.size() ||
      lens.external_model->origin != PixelOrigin::kFirstPixelCenter ||
      !lens.external_model->Has("fx") || !lens.external_model->Has("cx") ||
      lens.Value("cx") <= 0 || lens.Value("cy") <= 0 ||
      std::min(lens.size.width, lens.size.height) < kMinFocalPx)
    return;
  if (is_fraction("fx", kMinFocalPx) && is_fraction("fy", kMinFocalPx) &&
      is_fraction("cx", 1) && is_fraction("cy", 1))
    throw InputError(fmt::format(
        "expected pixels, but fx {:g} and cx {:g} are fractions of the image; "
        "multiply fx and cx by its width, fy and cy by its height",
        lens.Value("fx"), lens.Value("cx")));
}

// Warns if the principal point suggests another resolution or exchanged width
// and height.
void WarnIfPrincipalPointImplausible(const std::string& name,
                                     const ConvertedCamera& lens,
                                     std::vector<std::string>* warnings) {
  constexpr double kMaxCenterOffset = 0.25, kNegligibleCenterOffset = 0.1,
                   kMaxOffsetRatio = 4;
  if (!lens.external_model->Has("cx") || lens.values.empty()) return;
  const ImageSize& size = lens.size;
  const double off = ComputePrincipalPointOffset(lens, size.width, size.height);
  if (off < kMaxCenterOffset &&
      (off < kNegligibleCenterOffset ||
       kMaxOffsetRatio *
               ComputePrincipalPointOffset(lens, size.height, size.width) >
           off))
    return;
  warnings->push_back(fmt::format(
      "{}the principal point ({:g}, {:g}) is far from the centre of {} x {} "
      "px: check that the size is that of the calibration, width first",
      name, lens.Value("cx"), lens.Value("cy"), size.width, size.height));
}

// Adds warnings about unexpected properties of the cameras.
void AddModelWarnings(ExchangeContents* contents) {
  constexpr double kFarM = 10;
  double max_distance_m = 0;
  for (const InputCamera& camera : contents->cameras) {
    const std::string name =
        contents->cameras.size() > 1 ? camera.name + ": " : "";
    const double part = ComputeUndefinedFraction(*MakeCameraModel(camera.lens));
    WarnIfPrincipalPointImplausible(name, camera.lens, &contents->warnings);
    if (part > 0)
      contents->warnings.push_back(fmt::format(
          "{}no valid rays in {:.1f} % of the image, where the distortion "
          "folds or ends",
          name, 100 * part));
    if (camera.camera_from_rig)
      max_distance_m =
          std::max(max_distance_m, camera.camera_from_rig->translation.norm());
  }
  if (max_distance_m > kFarM)
    contents->warnings.push_back(
        fmt::format("the cameras are {:g} m apart, assuming lengths in metres; "
                    "check the unit",
                    max_distance_m));
}

// Completes cameras with the user's options, which never override the file.
void ApplyUserOptions(const Format& format, const ReadRequest& request,
                      ExchangeContents* contents) {
  for (InputCamera& camera : contents->cameras) {
    ImageSize& size = camera.lens.size;
    if (size == ImageSize{} && !request.size)
      throw InputError("missing image size; specify --image-size WxH");
    if (size == ImageSize{}) size = *request.size;
    if (request.size && *request.size != size)
      throw InputError(fmt::format(
          "--image-size {}x{}: the file has {}x{}; omit the option, and for "
          "scaled or cropped images use 'raygrid pack --mode NAME:scale={:g}'",
          request.size->width, request.size->height, size.width, size.height,
          static_cast<double>(request.size->width) / size.width));
    if (!format.accepts_model)
      RequireModelOfFile(request, *camera.lens.external_model);
    RequirePixels(camera.lens);
    if (camera.lens.skew_px != 0)
      camera.lens = FitSkewedGrid(camera.lens, &contents->warnings);
  }
}

// Removes duplicate warnings of the cameras of a file.
void RemoveDuplicateWarnings(std::vector<std::string>* warnings) {
  std::vector<std::string> kept;
  for (const std::string& warning : *warnings)
    if (std::find(kept.begin(), kept.end(), warning) == kept.end())
      kept.push_back(warning);
  *warnings = std::move(kept);
}

// Warns if a file ends with a digit and no newline: the number may be
// truncated.
void AddEndWarning(const std::string& text, ExchangeContents* contents) {
  if (!text.empty() && std::isdigit(static_cast<unsigned char>(text.back())) &&
      FindInvalidUtf8(text) == std::string::npos)
    contents->warnings.push_back(
        "the last line is not terminated: its last number may be truncated");
}

// Throws if the companion file exists with other contents, such as those of a
// reconstruction.
void RequireNoConflictingFile(const CompanionFile& file) {
  if (std::filesystem::exists(file.path) && ReadFile(file.path) != file.text)
    throw Error(
        ExitCode::kOutputFailed,
        file.path +
            ": already exists with different contents; use another folder");
}

void AddFiles(const std::vector<CompanionFile>& written,
              std::vector<std::pair<std::string, std::string>>* files) {
  for (const CompanionFile& file : written) {
    if (file.is_never_replaced) RequireNoConflictingFile(file);
    files->emplace_back(file.path, file.text);
  }
}

[[noreturn]] void ThrowOnCorners(const std::string& path) {
  throw InputError(
      fmt::format("{}: contains corners but no camera; convert it with "
                  "'raygrid import' to features.csv for calibrate --features",
                  path));
}

}  // namespace

const std::vector<Format>& GetFormats() {
  static const std::vector<Format> formats = [] {
    // Application settings may also contain OpenCV matrices, so the keyed
    // formats are tried first.
    std::vector<Format> all = MakeKeyedFormats();
    for (const auto& row : {OpenCvFormat,
                            MakeRosFormat,
                            MakeKalibrFormat,
                            MakeKalibrTargetFormat,
                            MakeColmapFormat,
                            MakeMrcalCornersFormat,
                            MakeMrcalFormat,
                            MakeBasaltFormat,
                            MakeNerfstudioFormat,
                            MakeMetashapeFormat,
                            MakePuzzlepaintFormat,
                            MakeDepthAiFormat,
                            MakeLibcameraFormat,
                            MakePhotonVisionFormat,
                            MakePuzzlepaintPatternFormat,
                            MakeOcamCalibFormat,
                            MakeDsoFormat,
                            MakeRosIniFormat,
                            MakeLensfunFormat,
                            MakePythonFormat})
      all.push_back(row());
    return all;
  }();
  return formats;
}

const ExternalModel* Format::FindExternalModel(
    const std::string& external_model) const {
  for (const ExternalModel& known : external_models)
    if (known.name == external_model) return &known;
  return nullptr;
}

std::vector<const ExternalModel*> Format::FindModels(
    const std::string& model) const {
  const bool is_named = FindExternalModel(model) != nullptr;
  std::vector<const ExternalModel*> chosen;
  std::string names;
  for (const ExternalModel& external_model : external_models) {
    if (model.empty() ? !external_model.export_only_if_named
                      : model == external_model.name)
      chosen.push_back(&external_model);
    names += (names.empty() ? "" : ", ") + external_model.name;
  }
  for (const ExternalModel& external_model : external_models)
    if (!is_named && external_model.model == model &&
        !external_model.export_only_if_named)
      chosen.push_back(&external_model);
  if (chosen.empty())
    throw Error(ExitCode::kUsage,
                fmt::format("--model {}: not available in {}; use {}", model,
                            name, names));
  return chosen;
}

const Format& FindFormat(const std::string& option, const std::string& name) {
  for (const Format& format : GetFormats())
    if (format.name == name) return format;
  throw Error(ExitCode::kUsage, fmt::format("{} {}: unknown format; use {}",
                                            option, name, ListFormatNames()));
}

const Format* RecognizeFormat(const std::string& text) {
  if (HasByteOrderMark(text))
    return RecognizeFormat(text.substr(kByteOrderMark.size()));
  for (const char* own : {"raygrid_camera:", "raygrid_rig:"})
    if (text.find(own) != std::string::npos) return nullptr;
  for (const Format& format : GetFormats())
    if (format.recognizes(text)) return &format;
  return nullptr;
}

const Format* RecognizeCamera(const std::string& path,
                              const std::string& text) {
  const Format* const format = RecognizeFormat(text);
  if (!format && text.find("raygrid_") == std::string::npos)
    throw InputError(
        fmt::format("{}: not a camera file (no 'raygrid_camera: 1'), and not "
                    "in a supported format; supported are {}",
                    path, ListFormatNames()));
  return format;
}

std::string ListFormatNames() {
  const std::vector<Format>& formats = GetFormats();
  std::string names = formats.front().name;
  for (size_t k = 1; k < formats.size(); ++k)
    names += (k + 1 < formats.size() ? ", " : " or ") + formats[k].name;
  return names;
}

ExchangeContents ReadExchangeFile(const Format* format,
                                  const ReadRequest& request) {
  if (HasByteOrderMark(request.text)) {
    ReadRequest without = request;
    without.text.erase(0, kByteOrderMark.size());
    return ReadExchangeFile(format, without);
  }
  const Format* found = RecognizeFormat(request.text);
  if (!format && !found)
    throw InputError(
        fmt::format("{}: not in a supported format; supported are {}",
                    request.path, ListFormatNames()));
  if (format && found && format != found && !format->recognizes(request.text))
    throw InputError(fmt::format("{}: has the format {}, not {}", request.path,
                                 found->name, format->name));
  return ReadNamingFile(request.path, [&] {
    ExchangeContents contents = (format ? format : found)->read(request);
    const Format& own = *(format ? format : found);
    if (contents.cameras.empty() && contents.corners.empty() &&
        contents.boards.empty() && !contents.second_from_first)
      throw InputError(own.requires_board_size ? "contains no corners"
                                               : "contains no camera");
    ApplyUserOptions(own, request, &contents);
    AddEndWarning(request.text, &contents);
    AddModelWarnings(&contents);
    RemoveDuplicateWarnings(&contents.warnings);
    return contents;
  });
}

void RequireCameraFormat(const Format& format, const std::string& path) {
  if (!format.external_models.empty()) return;
  if (format.requires_board_size) ThrowOnCorners(path);
  throw InputError(
      fmt::format("{}: contains a target but no camera; convert it with "
                  "'raygrid import' to pattern.yaml for --pattern",
                  path));
}

void RequireCameras(const ExchangeContents& contents, const std::string& path) {
  if (contents.second_from_first) AssignPairPose(Pose{}, path, nullptr);
  if (contents.cameras.empty()) ThrowOnCorners(path);
}

std::vector<std::string> ReadCompanionFiles(const Format& format,
                                            const std::string& path) {
  std::vector<std::string> texts;
  if (!format.beside) return texts;
  for (const std::string& beside : format.beside(path))
    texts.push_back(std::filesystem::exists(beside) ? ReadFile(beside) : "");
  return texts;
}

std::vector<std::pair<std::string, std::string>> WriteWithCompanions(
    const Format& format, WriteRequest request) {
  std::vector<std::pair<std::string, std::string>> files = {
      {request.path, format.write(request)}};
  if (!format.write_beside) return files;
  if (format.file_in_folder)
    request.beside = ReadCompanionFiles(format, request.path);
  AddFiles(format.write_beside(request), &files);
  return files;
}

std::vector<std::pair<std::string, std::string>> WriteFolder(
    const Format& format, WriteRequest request) {
  std::vector<std::pair<std::string, std::string>> files;
  if (format.write_folder) {
    request.beside =
        ReadCompanionFiles(format, format.file_in_folder(request.path, 0));
    AddFiles(format.write_folder(request), &files);
    return files;
  }
  for (const OutputCamera& lens : request.cameras) {
    const std::string path =
        (std::filesystem::path(request.path) / (lens.name + format.ending))
            .string();
    files.emplace_back(path, format.write({path, {lens}}));
  }
  return files;
}

bool ExchangeContents::IsRig() const {
  return cameras.size() > 1 &&
         std::all_of(cameras.begin(), cameras.end(),
                     [](const InputCamera& lens) {
                       return lens.camera_from_rig.has_value();
                     });
}

void ComputeStereoPoses(std::vector<InputCamera>* cameras) {
  bool is_pair = false;
  for (const InputCamera& camera : *cameras) {
    if (!camera.rectified) return;
    is_pair = is_pair || camera.rectified->HasBaseline();
  }
  if (!is_pair) return;
  // The last column of P is the baseline times the focal length.
  const auto view_from_rig = [](const RectifiedProjection& view) {
    return Pose{Eigen::Quaterniond(view.r),
                {view.p(0, 3) / view.p(0, 0), view.p(1, 3) / view.p(1, 1), 0}};
  };
  const Pose first = view_from_rig(*cameras->front().rectified);
  for (InputCamera& camera : *cameras) {
    // x_i = R_i^T (R_0 x_0 + t_i - t_0)
    const Pose own = view_from_rig(*camera.rectified);
    const Eigen::Quaterniond back = own.rotation.conjugate();
    camera.camera_from_rig = Pose{(back * first.rotation).normalized(),
                                  back * (own.translation - first.translation)};
  }
}

void RequireModelOfFile(const ReadRequest& request,
                        const ExternalModel& external_model) {
  if (request.external_model.empty() ||
      request.external_model == external_model.name ||
      request.external_model == external_model.model)
    return;
  throw InputError(fmt::format(
      "--model {}: the file specifies its model, {}; omit the option",
      request.external_model, external_model.name));
}

void AssignPairPose(const std::optional<Pose>& second_from_first,
                    const std::string& files,
                    std::vector<InputCamera>* cameras) {
  if (!second_from_first) return;
  const bool is_pair = cameras && cameras->size() == 2 &&
                       std::none_of(cameras->begin(), cameras->end(),
                                    [](const InputCamera& camera) {
                                      return camera.camera_from_rig.has_value();
                                    });
  if (!is_pair)
    throw InputError(
        fmt::format("{}: contains R and T of a stereo pair; import it together "
                    "with the file of its two cameras to get the rig",
                    files));
  cameras->front().camera_from_rig = Pose{};
  cameras->back().camera_from_rig = *second_from_first;
}

void RequireOneBoard(const std::string& program,
                     const std::vector<OutputCamera>& cameras) {
  const BoardPose* first = nullptr;
  for (const OutputCamera& camera : cameras)
    for (const BoardPose& pose : camera.poses) {
      if (!first) first = &pose;
      if (pose.board != first->board)
        throw InputError(
            fmt::format("--poses: contains poses of boards {} and {}, but {} "
                        "has a single world frame; keep the poses of one board",
                        first->board, pose.board, program));
    }
}

CameraFile MakeCameraFile(const InputCamera& read) {
  CameraFile file;
  file.camera = MakeCameraModel(read.lens);
  file.name = read.name;
  file.serial = read.serial;
  if (read.valid_region)
    file.uncertainty = CameraUncertainty::FromMask(*read.valid_region);
  return file;
}

}  // namespace raygrid
