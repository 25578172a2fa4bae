#include "known_intrinsics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "camera_input.h"
#include "camera_values.h"
#include "dataset/error.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

constexpr const char* kOption = "--intrinsics";

// Whether a file is camera.yaml, not a file of another program.
bool IsCameraYaml(const std::string& bytes) {
  return bytes.find("raygrid_camera:") != std::string::npos;
}

KnownIntrinsics ReadIntrinsics(const std::string& path) {
  const std::string bytes = ReadFile(path);
  CameraInput input = ParseCamera(path, bytes);
  if (input.blob)
    throw Error(ExitCode::kUsage,
                fmt::format("{} {}: is a blob; use the camera.yaml that it was "
                            "packed from",
                            kOption, path));
  if (input.file.stack)
    throw Error(ExitCode::kUsage,
                fmt::format("{} {}: the intrinsics vary with focus or "
                            "temperature; use a camera.yaml of one operating "
                            "point",
                            kOption, path));
  WarnAboutFailedCalibration(path, input.file);
  return {std::make_shared<CameraFile>(std::move(input.file)),
          IsCameraYaml(bytes) ? bytes : ""};
}

}  // namespace

void AddIntrinsicsOption(CLI::App* command, std::vector<std::string>* texts) {
  command
      ->add_option(kOption, *texts,
                   "known intrinsics of one camera of a rig (camera.yaml), "
                   "which are kept; repeatable")
      ->option_text("NAME=FILE")
      ->allow_extra_args(false);
}

IntrinsicsByCamera ReadKnownIntrinsics(const std::vector<std::string>& texts,
                                       const std::vector<std::string>& names) {
  IntrinsicsByCamera known;
  if (texts.empty()) return known;
  if (names.size() < 2)
    throw Error(ExitCode::kUsage,
                fmt::format("{} is for the cameras of a rig; for a single "
                            "camera, raygrid localize --refine-target "
                            "estimates poses and the target geometry",
                            kOption));
  for (const auto& [name, path] : ParseCameraValues(kOption, "FILE", texts)) {
    if (std::count(names.begin(), names.end(), name) == 0)
      throw Error(ExitCode::kUsage,
                  fmt::format("{} {}={}: no such camera; the cameras are {}",
                              kOption, name, path, fmt::join(names, ", ")));
    known[name] = ReadIntrinsics(path);
  }
  return known;
}

}  // namespace raygrid
