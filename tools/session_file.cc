#include "session_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "camera_values.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

namespace fs = std::filesystem;

constexpr double kZoomTolerance = 1e-3;
constexpr int kSessionSchemaVersion = 2;

using Json = nlohmann::ordered_json;

// The numeric fields of a frame, by their keys in the file.
struct SessionNumber {
  const char* key;
  std::optional<double> SessionFrame::*value;
};
constexpr SessionNumber kNumbers[] = {
    {"time_s", &SessionFrame::seconds},
    {"lens_position_dpt", &SessionFrame::lens_position},
    {"exposure_us", &SessionFrame::exposure_us},
    {"analogue_gain", &SessionFrame::analogue_gain},
    {"zoom", &SessionFrame::zoom},
    {"sensor_temperature_c", &SessionFrame::sensor_temperature_c},
    {"edge_width_px", &SessionFrame::edge_spread_px},
    {"white_level", &SessionFrame::white},
    {"variance_reduction", &SessionFrame::variance_reduction}};

Json FormatFrame(const SessionFrame& frame) {
  Json json = {{"image", frame.image}};
  for (const SessionNumber& number : kNumbers)
    if (const auto& value = frame.*number.value; value && std::isfinite(*value))
      json[number.key] = *value;
  if (frame.orientation) json["orientation"] = *frame.orientation;
  if (frame.focus_steps) json["focus_steps"] = *frame.focus_steps;
  if (frame.crop) json["crop"] = *frame.crop;
  return json;
}

SessionFrame ParseFrame(const Json& json) {
  SessionFrame frame;
  frame.image = json.at("image").get<std::string>();
  if (frame.image.empty() || frame.image == "." || frame.image == ".." ||
      frame.image.find('/') != std::string::npos)
    throw InputError("an image name points outside the folder");
  for (const SessionNumber& number : kNumbers)
    if (json.contains(number.key))
      frame.*number.value = json.at(number.key).get<double>();
  if (json.contains("orientation"))
    frame.orientation = json.at("orientation").get<int>();
  if (json.contains("focus_steps"))
    frame.focus_steps = json.at("focus_steps").get<int>();
  if (json.contains("crop"))
    frame.crop = json.at("crop").get<std::array<int, 4>>();
  return frame;
}

Json FormatCamera(const Session& session) {
  Json json = {
      {"image_size", {session.image_size.width, session.image_size.height}}};
  if (!session.locked.empty()) json["locked"] = session.locked;
  if (!session.not_locked.empty()) json["not_locked"] = session.not_locked;
  json["frames"] = Json::array();
  for (const SessionFrame& frame : session.frames)
    json["frames"].push_back(FormatFrame(frame));
  return json;
}

Session ParseCamera(const Json& json) {
  Session session;
  const auto size = json.at("image_size").get<std::array<int, 2>>();
  session.image_size = {size[0], size[1]};
  for (const Json& frame : json.at("frames"))
    session.frames.push_back(ParseFrame(frame));
  for (const auto& [key, list] : {std::pair("locked", &session.locked),
                                  std::pair("not_locked", &session.not_locked)})
    if (json.contains(key))
      *list = json.at(key).get<std::vector<std::string>>();
  return session;
}

// Returns the value common to all frames, within a tolerance.
std::optional<double> GetCommonValue(const Session& session,
                                     std::optional<double> SessionFrame::*value,
                                     double tolerance) {
  std::vector<double> values;
  for (const SessionFrame& frame : session.frames) {
    if (!(frame.*value)) return std::nullopt;
    values.push_back(*(frame.*value));
  }
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  if (values.back() - values.front() > tolerance) return std::nullopt;
  return values[values.size() / 2];
}

template <typename Value>
std::optional<Value> SameInAll(const Session& session,
                               std::optional<Value> SessionFrame::*value) {
  if (session.frames.empty()) return std::nullopt;
  const std::optional<Value>& first = session.frames.front().*value;
  for (const SessionFrame& frame : session.frames)
    if (frame.*value != first) return std::nullopt;
  return first;
}

}  // namespace

namespace {

void Rename(const char* former, const char* current, Json* json) {
  if (!json->is_object() || !json->contains(former)) return;
  (*json)[current] = (*json)[former];
  json->erase(former);
}

void UpgradeFrames(Json* camera) {
  if (!camera->is_object() || !camera->contains("frames")) return;
  for (Json& frame : (*camera)["frames"]) {
    Rename("lens_position", "lens_position_dpt", &frame);
    Rename("seconds", "time_s", &frame);
    Rename("edge_spread_px", "edge_width_px", &frame);
    Rename("white", "white_level", &frame);
    Rename("variance_taken", "variance_reduction", &frame);
  }
}

// Converts a session of an older version to the current keys.
void UpgradeSession(Json* session) {
  if (!session->is_object() || !session->contains("raygrid_session") ||
      session->at("raygrid_session") != 1)
    return;
  (*session)["schema_version"] = kSessionSchemaVersion;
  UpgradeFrames(session);
  if (!session->contains("cameras")) return;
  for (Json& camera : (*session)["cameras"]) {
    Rename("camera", "name", &camera);
    UpgradeFrames(&camera);
  }
}

}  // namespace

bool IsSession(const std::string& folder) {
  std::error_code error;
  return fs::is_regular_file(fs::path(folder) / kSessionFile, error);
}

std::string SessionFramePath(const std::string& folder,
                             const std::string& camera,
                             const std::string& image) {
  return (fs::path(folder) / kSessionFrames / camera / image).string();
}

std::string FormatSession(const std::vector<Session>& cameras) {
  Json json = {{"schema_version", kSessionSchemaVersion}};
  if (cameras.size() == 1) {
    json.update(FormatCamera(cameras[0]));
  } else {
    json["cameras"] = Json::array();
    for (const Session& camera : cameras) {
      Json named = {{"name", camera.camera}};
      named.update(FormatCamera(camera));
      json["cameras"].push_back(named);
    }
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<Session> ReadSession(const std::string& folder) {
  const std::string path = (fs::path(folder) / kSessionFile).string();
  const std::string text = ReadFile(path);
  RequireSmallTree(path, text);
  try {
    Json json = Json::parse(text);
    UpgradeSession(&json);
    if (json.at("schema_version") != kSessionSchemaVersion)
      throw InputError("was written by a newer version of raygrid");
    if (!json.contains("cameras")) return {ParseCamera(json)};
    std::vector<Session> cameras;
    for (const Json& camera : json.at("cameras")) {
      cameras.push_back(ParseCamera(camera));
      cameras.back().camera = camera.at("name").get<std::string>();
      RequireCameraName(cameras.back().camera);
    }
    if (cameras.empty()) throw InputError("contains no camera");
    return cameras;
  } catch (const Json::exception& error) {
    throw InputError(
        fmt::format("{}: not a valid capture session ({}); capture again", path,
                    error.what()));
  } catch (const Error& error) {
    throw InputError(fmt::format("{}: {}", path, error.what()));
  }
}

Capture GetCaptureSettings(const Session& session) {
  Capture capture;
  capture.lens_position = GetCommonValue(session, &SessionFrame::lens_position,
                                         kDefaultLensTolerance);
  capture.zoom = GetCommonValue(session, &SessionFrame::zoom, kZoomTolerance);
  constexpr double kWarmingC = 10;  // the temperature rise during a session
  capture.sensor_temperature_c =
      GetCommonValue(session, &SessionFrame::sensor_temperature_c, kWarmingC);
  constexpr double kExposureToleranceUs = 100, kGainTolerance = 0.01;
  capture.exposure_us =
      GetCommonValue(session, &SessionFrame::exposure_us, kExposureToleranceUs);
  capture.analogue_gain =
      GetCommonValue(session, &SessionFrame::analogue_gain, kGainTolerance);
  capture.crop = SameInAll(session, &SessionFrame::crop);
  capture.orientation = SameInAll(session, &SessionFrame::orientation);
  return capture;
}

ImageTimes CollectTimes(const Session& session) {
  constexpr double kApartS = 1000;
  ImageTimes times;
  double begin_s = 0, last_s = 0;
  for (const SessionFrame& frame : session.frames) {
    if (!frame.seconds) continue;
    // Frames are stored in the order in which they were kept.
    if (begin_s + *frame.seconds <= last_s) begin_s = last_s + kApartS;
    last_s = begin_s + *frame.seconds;
    times[frame.image] = last_s;
  }
  return times;
}

std::vector<std::string> ListDifferences(const Capture& calibrated,
                                         const Capture& now) {
  std::vector<std::string> differences;
  const auto compare = [&](const char* what, const std::optional<double>& then,
                           const std::optional<double>& current,
                           double tolerance, const char* unit) {
    if (then && current && std::abs(*then - *current) > tolerance)
      differences.push_back(fmt::format("{} {:.4g}{}, calibrated at {:.4g}{}",
                                        what, *current, unit, *then, unit));
  };
  compare("lens position", calibrated.lens_position, now.lens_position,
          calibrated.lens_tolerance, " dioptres");
  if (calibrated.crop && now.crop && *calibrated.crop != *now.crop)
    differences.push_back(fmt::format("crop {}, calibrated with {}",
                                      fmt::join(*now.crop, ","),
                                      fmt::join(*calibrated.crop, ",")));
  compare("zoom", calibrated.zoom, now.zoom, kZoomTolerance, "");
  if (calibrated.orientation && now.orientation &&
      *calibrated.orientation != *now.orientation)
    differences.push_back(fmt::format("orientation {}, calibrated with {}",
                                      *now.orientation,
                                      *calibrated.orientation));
  constexpr double kOtherC = 20;
  compare("sensor temperature", calibrated.sensor_temperature_c,
          now.sensor_temperature_c, kOtherC, " degrees Celsius");
  return differences;
}

}  // namespace raygrid
