#include "report/result_folder.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "dataset/error.h"
#include "dataset/rig_file.h"
#include "report/residual_file.h"
#include "report/rig_report.h"
#include "report/uncertainty_plot.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

std::string In(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

constexpr char kBlob[] = "camera.raygrid";
constexpr char kThumbnails[] = "thumbnails.json";
constexpr char kRowsImage[] = "rectified_rows.png";
constexpr char kDisparityImage[] = "rectified_disparity.png";

// ---- Writing ---------------------------------------------------------------

void AddCameraFiles(const CalibrationResult& result, const CameraExtras& extras,
                    const std::string& folder, OutputFiles* files) {
  CameraFile camera = result.camera;
  if (!result.has_known_intrinsics) camera.assessment = result.assessment.word;
  files->Add(In(folder, "camera.yaml"), extras.camera_yaml.empty()
                                            ? FormatCameraFile(camera)
                                            : extras.camera_yaml);
  if (camera.uncertainty)
    files->Add(In(folder, "uncertainty.png"),
               EncodePng(DrawUncertaintyPlot(*camera.uncertainty,
                                             camera.camera->image_size(),
                                             camera.camera->area())));
  if (!extras.thumbnails.empty())
    files->Add(In(folder, kThumbnails), FormatThumbnails(extras.thumbnails));
  if (!extras.blob.empty()) files->Add(In(folder, kBlob), extras.blob);
  if (!extras.view.empty())
    files->Add(In(folder, "view.camera.yaml"), extras.view);
  if (!extras.example) return;
  files->Add(In(folder, "example_before.png"),
             EncodePng(extras.example->before));
  files->Add(In(folder, "example_after.png"), EncodePng(extras.example->after));
}

std::vector<RelativePoseCovariance> CollectCovariances(
    const RigResult& result) {
  std::vector<RelativePoseCovariance> pairs;
  for (const Baseline& baseline : result.baselines)
    if (baseline.covariance)
      pairs.push_back({result.cameras[baseline.first].camera.name,
                       result.cameras[baseline.second].camera.name,
                       *baseline.covariance});
  return pairs;
}

// ---- Reading ---------------------------------------------------------------

void RequireFile(const std::string& path) {
  if (!fs::is_regular_file(path))
    throw InputError(path +
                     ": missing; a report requires all files written by "
                     "calibrate; rerun the calibration");
}

Pattern ReadResultPattern(const std::string& folder) {
  const std::string path = In(folder, "pattern.yaml");
  RequireFile(path);
  return ReadPattern(path);
}

CameraFile ReadResultCamera(const std::string& path) {
  RequireFile(path);
  return ReadCameraFile(path);
}

// The contents of the CSV files, by camera.
struct Tables {
  std::map<std::string, Dataset> features;
  std::map<std::string, std::vector<BoardPose>> poses;
  std::map<std::string, ResidualSets> residuals;
};

Tables ReadTables(const std::string& folder) {
  for (const char* name : {"features.csv", "poses.csv", "residuals.csv"})
    RequireFile(In(folder, name));
  return {ReadFeatures(In(folder, "features.csv")),
          ReadPoses(In(folder, "poses.csv")),
          ReadResiduals(In(folder, "residuals.csv"))};
}

// Adds the data that result.json does not contain.
void Complete(CameraFile camera, const Pattern& pattern,
              const std::string& name, Tables* tables,
              CalibrationResult* result) {
  const CameraFile in_json = std::move(result->camera);
  result->camera = std::move(camera);
  if (!in_json.name.empty()) result->camera.name = in_json.name;
  if (result->has_known_intrinsics) {  // camera.yaml has errors of its own
    result->camera.training = in_json.training;
    result->camera.held_out = in_json.held_out;
  }
  result->pattern = pattern;
  result->features = std::move(tables->features[name]);
  result->features.image_size = result->camera.camera->image_size();
  result->poses = std::move(tables->poses[name]);
  ResidualSets& sets = tables->residuals[name];
  result->training = std::move(sets.training);
  result->held_out = std::move(sets.held_out);
  result->rejected_features = std::move(sets.rejected);
}

// Checks that features are inside the camera's images and on the target.
void RequireMatching(const std::string& folder,
                     const CalibrationResult& result) {
  RequireConsistent(In(folder, "features.csv"), result.features,
                    result.pattern);
  if (!result.camera.training)
    throw InputError(In(folder, "camera.yaml") +
                     ": contains no training errors; rerun the calibration");
}

std::optional<BeforeAfter> ReadExample(const std::string& folder) {
  const std::string before = In(folder, "example_before.png");
  const std::string after = In(folder, "example_after.png");
  if (!fs::exists(before) || !fs::exists(after)) return std::nullopt;
  return BeforeAfter{ReadImage(before, true), ReadImage(after, true)};
}

// Returns nullopt for rigs without stereo pictures.
std::optional<StereoExample> ReadStereo(
    const std::string& folder, const std::optional<StereoMetrics>& metrics) {
  const std::string rows = In(folder, kRowsImage);
  const std::string disparity = In(folder, kDisparityImage);
  if (!metrics || !fs::exists(rows) || !fs::exists(disparity))
    return std::nullopt;
  return StereoExample{*metrics, ReadImage(rows, false),
                       ReadImage(disparity, false)};
}

ThumbnailTexts ReadThumbnails(const std::string& folder) {
  const std::string path = In(folder, kThumbnails);
  if (!fs::exists(path)) return {};
  return ParseThumbnails(path, ReadFile(path));
}

// Returns an empty string if the camera was not packed.
std::string ReadBlob(const std::string& folder) {
  const std::string path = In(folder, kBlob);
  return fs::exists(path) ? ReadFile(path) : "";
}

// Returns the cameras with files in the folder, as listed in result.json.
std::vector<RigFileCamera> ListCameras(const std::string& folder,
                                       const RigResult& result) {
  const std::string path = In(folder, "rig.yaml");
  if (!result.IsRig() && !fs::exists(path)) return {{"", "camera.yaml", {}}};
  RequireFile(path);
  std::vector<RigFileCamera> cameras = ReadRigFile(path);
  if (cameras.size() != result.cameras.size())
    throw InputError(fmt::format("{}: {} cameras, but result.json has {}", path,
                                 cameras.size(), result.cameras.size()));
  for (size_t c = 0; c < cameras.size(); ++c) {
    const std::string& name = cameras[c].name;
    if (result.cameras[c].camera.name != name)
      throw InputError(fmt::format("{}: camera '{}', but result.json has '{}'",
                                   path, name, result.cameras[c].camera.name));
    if (fs::is_symlink(In(folder, name)))
      throw InputError(In(folder, name) +
                       ": is a symbolic link, expected a folder");
  }
  return cameras;
}

}  // namespace

std::string CameraFolder(const RigResult& result, size_t camera) {
  return result.IsRig() ? result.cameras[camera].camera.name + "/" : "";
}

void AddResultFiles(const RigResult& result, const ResultExtras& extras,
                    const std::string& folder, OutputFiles* files) {
  std::vector<NamedDataset> features;
  std::vector<NamedPoses> poses;
  std::vector<RigFileCamera> rig;
  std::vector<std::optional<PackingMetrics>> packing;
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const CalibrationResult& camera = result.cameras[c];
    const std::string& name = camera.camera.name;
    features.push_back({name, camera.features});
    poses.push_back({name, camera.poses});
    rig.push_back({name, name + "/camera.yaml", result.camera_from_rig[c]});
    packing.push_back(extras.cameras[c].packing);
    AddCameraFiles(camera, extras.cameras[c],
                   In(folder, CameraFolder(result, c)), files);
  }
  const bool is_rig = result.IsRig();
  if (is_rig)
    files->Add(In(folder, "rig.yaml"),
               FormatRigFile(rig, CollectCovariances(result)));
  files->Add(In(folder, "pattern.yaml"), FormatPattern(result.pattern));
  files->Add(In(folder, "features.csv"),
             is_rig ? FormatFeatures(features)
                    : FormatFeatures(features.front().dataset));
  files->Add(In(folder, "poses.csv"),
             is_rig ? FormatPoses(poses) : FormatPoses(poses.front().poses));
  files->Add(In(folder, "residuals.csv"), FormatResiduals(result));
  std::optional<StereoMetrics> stereo;
  if (extras.stereo) {
    stereo = extras.stereo->metrics;
    files->Add(In(folder, kRowsImage), EncodePng(extras.stereo->rows));
    files->Add(In(folder, kDisparityImage),
               EncodePng(extras.stereo->disparity));
  }
  files->Add(In(folder, "result.json"),
             FormatResultJson(result, extras.seed, extras.peak_memory_bytes,
                              packing, stereo));
}

std::set<std::string> ResultFiles(const std::string& folder) {
  const std::vector<std::string> of_camera = {
      kBlob,       "camera.yaml",     "report.html",
      kThumbnails, "uncertainty.png", "view.camera.yaml"};
  std::set<std::string> files(of_camera.begin(), of_camera.end());
  files.insert({"example_after.png", "example_before.png", "features.csv",
                "pattern.yaml", "poses.csv", kDisparityImage, kRowsImage,
                "residuals.csv", "result.json", "resume.json", "rig.yaml"});
  // Partially written checkpoints also belong to the result.
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("resume.json.part-", 0) == 0) files.insert(name);
  }
  try {
    for (const RigFileCamera& camera : ReadRigFile(In(folder, "rig.yaml")))
      for (const std::string& file : of_camera)
        files.insert(camera.name + "/" + file);
  } catch (const InputError&) {
    // The folder does not contain a rig.
  }
  return files;
}

bool HasFinishedResult(const std::string& folder) {
  if (!fs::exists(In(folder, "camera.yaml")) &&
      !fs::exists(In(folder, "rig.yaml")))
    return false;
  try {
    const auto json = nlohmann::json::parse(ReadFile(In(folder, "result.json")),
                                            nullptr, false);
    return !json.is_object() || json.value("status", "") != "interrupted";
  } catch (const std::exception&) {
    return true;  // metrics are optional
  }
}

ResultMetrics ReadResultFolder(const std::string& folder) {
  const std::string path = In(folder, "result.json");
  RequireFile(path);
  ResultMetrics metrics = ParseResultJson(path, ReadFile(path));
  RigResult& result = metrics.result;
  result.pattern = ReadResultPattern(folder);
  Tables tables = ReadTables(folder);
  const std::vector<RigFileCamera> cameras = ListCameras(folder, result);
  for (size_t c = 0; c < cameras.size(); ++c) {
    const std::string& name = cameras[c].name;
    CalibrationResult& camera = result.cameras[c];
    result.camera_from_rig.push_back(cameras[c].camera_from_rig);
    result.held_out.push_back(
        std::move(tables.residuals[name].held_out_in_rig));
    Complete(ReadResultCamera(In(folder, cameras[c].file)), result.pattern,
             name, &tables, &camera);
    RequireMatching(folder, camera);
  }
  return metrics;
}

void AddReports(const std::string& folder, OutputFiles* files) {
  const ResultMetrics metrics = ReadResultFolder(folder);
  const RigResult& result = metrics.result;
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const std::string own = In(folder, CameraFolder(result, c));
    files->Add(
        In(own, "report.html"),
        FormatHtmlReport(result.cameras[c], metrics.packing[c],
                         ReadExample(own), ReadThumbnails(own), ReadBlob(own),
                         result.IsRig() ? std::vector<std::string>()
                                        : metrics.rigid_target_summary),
        Links::kReplace);
  }
  if (result.IsRig())
    files->Add(In(folder, "report.html"),
               FormatRigReport(result, ReadStereo(folder, metrics.stereo),
                               metrics.rigid_target_summary),
               Links::kReplace);
}

}  // namespace raygrid
