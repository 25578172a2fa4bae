#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/token_lines.h"
#include "exchange/colmap_files.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kCamerasHeader[] =
    "# Camera list with one line of data per camera:\n"
    "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
constexpr char kRigsHeader[] =
    "# Rig calib list with one line of data per calib:\n"
    "#   RIG_ID, NUM_SENSORS, REF_SENSOR_TYPE, REF_SENSOR_ID, SENSORS[] as "
    "(SENSOR_TYPE, SENSOR_ID, HAS_POSE, [QW, QX, QY, QZ, TX, TY, TZ])\n";

constexpr char kImagesHeader[] =
    "# Image list with two lines of data per image:\n"
    "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
    "#   POINTS2D[] as (X, Y, POINT3D_ID)\n";
constexpr char kFramesHeader[] =
    "# Frame list with one line of data per frame:\n"
    "#   FRAME_ID, RIG_ID, RIG_FROM_WORLD[QW, QX, QY, QZ, TX, TY, TZ], "
    "NUM_DATA_IDS, DATA_IDS[] as (SENSOR_TYPE, SENSOR_ID, DATA_ID)\n";
constexpr char kPointsHeader[] =
    "# 3D point list with one line of data per point:\n"
    "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, "
    "POINT2D_IDX)\n"
    "# Number of points: 0, mean track length: 0\n";

// raygrid-specific comments, which other readers ignore.
constexpr char kNameComment[] = "# Name of camera ";
constexpr char kSerialComment[] = "# Serial of camera ";

// Returns the texts of the comments of one kind by camera ID.
std::map<uint32_t, std::string> Comments(const std::string& text,
                                         const std::string& kind) {
  std::map<uint32_t, std::string> comments;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(kind, 0) != 0) continue;
    uint32_t id = 0;
    const char* const end = line.data() + line.size();
    const auto number = std::from_chars(line.data() + kind.size(), end, id);
    std::string rest(number.ptr, end);
    if (!rest.empty() && rest.back() == '\r') rest.pop_back();
    if (number.ec == std::errc() && rest.rfind(": ", 0) == 0)
      comments[id] = rest.substr(2);
  }
  return comments;
}

std::string FormatComment(const std::string& kind, uint32_t id,
                          const std::string& text) {
  return text.empty() ? ""
                      : fmt::format("{}{}: {}\n", kind, id, Printable(text));
}

bool IsModelName(const std::string& word) {
  return std::isupper(static_cast<unsigned char>(word[0])) &&
         word.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789") ==
             std::string::npos;
}

bool IsCount(const std::string& word) {
  return word.find_first_not_of("0123456789") == std::string::npos;
}

Pose ParsePose(const TokenLines& lines, size_t first) {
  std::array<double, 7> numbers;
  for (size_t k = 0; k < numbers.size(); ++k)
    numbers[k] = lines.Get<double>(first + k);
  try {
    return PoseFromQuaternion(numbers);
  } catch (const InputError& error) {
    lines.ThrowError(error.what());
  }
}

// Formats a pose as " QW QX QY QZ TX TY TZ".
std::string FormatPose(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  std::string words;
  for (const double number : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()})
    words += fmt::format(" {}", number);
  return words;
}

// Parses the sensors that follow the reference sensor as pairs of type and ID.
ColmapRig ParseRig(const TokenLines& lines) {
  constexpr char kCamera[] = "CAMERA";
  ColmapRig rig;
  size_t at = 4;
  const auto count = lines.Get<uint32_t>(1);
  if (count > 0 && lines.Text(2) == kCamera)
    rig.push_back({lines.Get<uint32_t>(3), Pose{}});
  for (uint32_t k = 1; k < count; ++k) {
    ColmapSensor sensor;
    const bool is_camera = lines.Text(at) == kCamera;
    sensor.camera = lines.Get<uint32_t>(at + 1);
    const bool has_pose = lines.Get<int>(at + 2) != 0;
    if (has_pose) sensor.sensor_from_rig = ParsePose(lines, at + 3);
    at += has_pose ? 10 : 3;
    if (is_camera) rig.push_back(sensor);
  }
  if (count > 0 && at != lines.size()) lines.ThrowError("too many fields");
  return rig;
}

}  // namespace

bool IsColmapText(const std::string& text) {
  if (text.rfind(kCamerasHeader, 0) == 0) return true;
  constexpr size_t kHeadBytes = 1 << 16;
  std::istringstream lines(text.substr(0, kHeadBytes));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string id, model, width, height, more;
    if (line[0] == '#' || !(words >> id)) continue;
    return words >> model >> width >> height >> more && IsCount(id) &&
           IsModelName(model) && IsCount(width) && IsCount(height);
  }
  return false;
}

std::vector<ColmapCamera> ParseColmapCameras(const std::string& path,
                                             const std::string& text) {
  TokenLines lines(path, text, "COLMAP's cameras.txt");
  const auto names = Comments(text, kNameComment);
  const auto serials = Comments(text, kSerialComment);
  std::vector<ColmapCamera> cameras;
  while (lines.NextNonEmpty()) {
    ColmapCamera camera;
    camera.id = lines.Get<uint32_t>(0);
    camera.model = lines.Text(1);
    camera.size = {lines.Get<int>(2), lines.Get<int>(3)};
    for (size_t k = 4; k < lines.size(); ++k)
      camera.parameters.push_back(lines.Get<double>(k));
    if (const auto name = names.find(camera.id); name != names.end())
      camera.name = name->second;
    if (const auto serial = serials.find(camera.id); serial != serials.end())
      camera.serial = serial->second;
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

std::vector<ColmapRig> ParseColmapRigs(const std::string& path,
                                       const std::string& text) {
  TokenLines lines(path, text, "COLMAP's rigs.txt");
  std::vector<ColmapRig> rigs;
  while (lines.NextNonEmpty()) rigs.push_back(ParseRig(lines));
  return rigs;
}

std::vector<ColmapImage> ParseColmapImages(const std::string& path,
                                           const std::string& text) {
  TokenLines lines(path, text, "COLMAP's images.txt");
  std::vector<ColmapImage> images;
  while (lines.NextNonEmpty()) {
    ColmapImage image;
    image.id = lines.Get<uint32_t>(0);
    image.camera_from_world = ParsePose(lines, 1);
    image.camera = lines.Get<uint32_t>(8);
    image.name = lines.Text(9);
    for (size_t k = 10; k < lines.size(); ++k)
      image.name += " " + lines.Text(k);
    images.push_back(std::move(image));
    // The 2D points; the line may be empty.
    if (lines.Next() && lines.size() % 3 != 0)
      lines.ThrowError("points must have three fields each");
  }
  return images;
}

std::string FormatColmapCameras(const std::vector<ColmapCamera>& cameras) {
  std::string text = kCamerasHeader;
  text += fmt::format("# Number of cameras: {}\n", cameras.size());
  for (const ColmapCamera& camera : cameras) {
    text += FormatComment(kNameComment, camera.id, camera.name);
    text += FormatComment(kSerialComment, camera.id, camera.serial);
    text += FormatComment("# Fit of camera ", camera.id, camera.warning);
    text += fmt::format("{} {} {} {}", camera.id, camera.model,
                        camera.size.width, camera.size.height);
    for (const double number : camera.parameters)
      text += fmt::format(" {}", number);
    text += "\n";
  }
  return text;
}

std::string FormatColmapRig(const ColmapRig& rig) {
  std::string text = kRigsHeader;
  text += fmt::format("# Number of rigs: 1\n1 {} CAMERA {}", rig.size(),
                      rig.front().camera);
  for (size_t k = 1; k < rig.size(); ++k)
    text += fmt::format(" CAMERA {} 1{}", rig[k].camera,
                        FormatPose(rig[k].sensor_from_rig.value()));
  return text + "\n";
}

std::string FormatColmapImages(const std::vector<ColmapImage>& images) {
  std::string text = kImagesHeader;
  text +=
      fmt::format("# Number of images: {}, mean observations per image: 0\n",
                  images.size());
  for (const ColmapImage& image : images) {
    if (image.name.find_first_of(" \t\r\n") != std::string::npos)
      throw InputError(
          fmt::format("image '{}': COLMAP text files do not support spaces in "
                      "names; write cameras.bin",
                      Printable(image.name)));
    text += fmt::format("{}{} {} {}\n\n", image.id,
                        FormatPose(image.camera_from_world), image.camera,
                        image.name);
  }
  return text;
}

std::string FormatColmapFrames(const std::vector<ColmapFrame>& frames) {
  std::string text = kFramesHeader;
  text += fmt::format("# Number of frames: {}\n", frames.size());
  for (size_t k = 0; k < frames.size(); ++k) {
    text +=
        fmt::format("{} 1{} {}", k + 1, FormatPose(frames[k].rig_from_world),
                    frames[k].images.size());
    for (const auto& [camera, image] : frames[k].images)
      text += fmt::format(" CAMERA {} {}", camera, image);
    text += "\n";
  }
  return text;
}

std::string FormatNoColmapPoints() { return kPointsHeader; }

}  // namespace raygrid
