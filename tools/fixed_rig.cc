#include "fixed_rig.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "bag_input.h"
#include "calibration/rigid_targets.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/rig_file.h"
#include "dataset/text_encoding.h"
#include "evaluation/rigid_target_text.h"

namespace raygrid {

FixedRig ReadFixedRig(const std::string& path,
                      const RequestedOperatingPoint& at) {
  const std::string bytes = ReadCameraBytes(path);
  FixedRig rig;
  rig.is_rig = bytes.find("raygrid_rig:") != std::string::npos;
  if (!rig.is_rig) {
    rig.names = {""};
    rig.cameras.push_back(ParseCamera(path, bytes, at));
    rig.model.camera_from_rig = {Pose()};
  } else {
    if (at.HasValues())
      throw Error(
          ExitCode::kUsage,
          fmt::format("{}: --at: the cameras of a rig have no operating "
                      "point",
                      path));
    const auto folder = std::filesystem::path(path).parent_path();
    for (const RigFileCamera& camera : ParseRigFile(path, bytes)) {
      rig.names.push_back(camera.name);
      rig.cameras.push_back(ReadCamera((folder / camera.file).string()));
      rig.model.camera_from_rig.push_back(camera.camera_from_rig);
    }
  }
  for (const CameraInput& camera : rig.cameras)
    rig.model.cameras.push_back(camera.file.camera.get());
  return rig;
}

std::vector<Dataset> ReadRigFeatures(const FixedRig& rig,
                                     const std::string& path,
                                     const Pattern& pattern) {
  auto read = ReadFeatures(path);
  std::vector<Dataset> datasets;
  if (!rig.is_rig) {
    if (read.size() > 1)
      throw InputError(path +
                       ": contains features of several cameras; split it into "
                       "one file per camera");
    datasets.push_back(std::move(read.begin()->second));
  } else {
    for (const std::string& name : rig.names) {
      datasets.push_back(std::move(read[name]));
      read.erase(name);
    }
    if (!read.empty())
      throw InputError(fmt::format("{}: camera '{}' is not in the rig", path,
                                   read.begin()->first));
  }
  for (size_t c = 0; c < datasets.size(); ++c) {
    datasets[c].image_size = rig.model.cameras[c]->image_size();
    RequireConsistent(path, datasets[c], pattern);
    UseRuntimeRays(rig.cameras[c], &datasets[c]);
  }
  return datasets;
}

void UseRuntimeRays(const CameraInput& camera, Dataset* dataset) {
  if (!camera.blob) return;
  for (ImageFeatures& image : dataset->images)
    for (Feature& feature : image.features) {
      const auto line = camera.blob->Line(feature.pixel);
      if (!line) continue;
      const auto pixel = camera.file.camera->Project(
          line->origin + line->direction, &feature.pixel, 0);
      if (pixel) feature.pixel = *pixel;
    }
}

void RequireLocalized(size_t count) {
  if (count == 0)
    throw Error(ExitCode::kInsufficientData,
                "no pose could be estimated; check that features and pattern "
                "belong to this camera");
}

std::string FormatErrorMetrics(const ErrorMetrics& metrics) {
  return fmt::format(
      "median {:.3g} px, RMS {:.3g} px, max {:.3g} px over {} features",
      metrics.median_px, metrics.rms_px, metrics.max_px, metrics.count);
}

nlohmann::ordered_json RejectedImagesJson(
    const std::vector<RejectedImage>& images) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const RejectedImage& image : images)
    json.push_back({{"image", image.image}, {"reason", image.reason}});
  return json;
}

void PrintRejectedImages(const std::vector<RejectedImage>& images) {
  for (const RejectedImage& image : images)
    fmt::print("rejected: {} ({})\n", Printable(image.image),
               Printable(image.reason));
}

nlohmann::ordered_json MakeRigidTargetsJson(const Pattern& pattern) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const RigidTarget& target : pattern.rigid_targets)
    json.push_back(target.boards);
  return json;
}

std::string FormatRigidTargets(const Pattern& pattern) {
  std::string words;
  for (const RigidTarget& target : pattern.rigid_targets)
    words += fmt::format("{}boards {} as a rigid body",
                         words.empty() ? "" : ", ", FormatList(target.boards));
  return words;
}

void PrintHowLocalized(const Pattern& pattern) {
  if (pattern.boards.size() < 2) return;
  if (pattern.rigid_targets.empty())
    fmt::print("one pose estimated per board\n");
  else
    fmt::print(
        "poses estimated for {} (use --independent-boards for a pose per "
        "board)\n",
        FormatRigidTargets(pattern));
}

RigModel LocalizingRig(const FixedRig& rig, const Pattern& pattern) {
  RigModel model = rig.model;
  const Pose rig_from_first = model.camera_from_rig.front().Inverse();
  for (Pose& pose : model.camera_from_rig) pose = pose * rig_from_first;
  model.rigid_targets = MakeRigidTargets(pattern);
  return model;
}

}  // namespace raygrid
