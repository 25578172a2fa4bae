#include "mode_options.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "camera_input.h"
#include "dataset/error.h"
#include "image_size_option.h"
#include "key_options.h"
#include "packing/pack.h"

namespace raygrid {

const char kModeSyntaxHelp[] =
    "Sensor modes, NAME: and any of these, separated by commas:\n"
    "  crop=X,Y,W,H                   sensor crop, in pixels of the\n"
    "                                 calibrated image\n"
    "  bin=N or scale=S or size=WxH   binning factor, scale factor, or frame\n"
    "                                 size in px\n"
    "  flip=h|v|hv, rotate=180\n";

const char kModeKeysHelp[] =
    "NAME: and a comma-separated list of crop=X,Y,W,H (sensor crop in "
    "calibrated pixels), bin=N (N x N binning), scale=S (0.5: half "
    "resolution), size=WxH (frame size, instead of bin and scale), "
    "flip=h|v|hv, rotate=180";

namespace {

using KeyValues = std::map<std::string, std::string>;

[[noreturn]] void ThrowInvalidMode(const std::string& mode,
                                   const std::string& fault) {
  throw Error(ExitCode::kUsage, fmt::format("--mode {}: {}", mode, fault));
}

// Parses the key=value pairs after the colon.
KeyValues ParseKeyValues(const std::string& mode, const std::string& text) {
  static const std::set<std::string> kKnown = {"crop", "bin",  "scale",
                                               "size", "flip", "rotate"};
  KeyValues words;
  for (const std::string& part : SplitAtKeys(text)) {
    const size_t equals = part.find('=');
    const std::string name = part.substr(0, equals);
    if (equals == std::string::npos || !kKnown.count(name))
      ThrowInvalidMode(
          mode, fmt::format("expected {}, not '{}'", kModeKeysHelp, part));
    if (!words.emplace(name, part.substr(equals + 1)).second)
      ThrowInvalidMode(mode, name + " is specified twice");
  }
  return words;
}

std::vector<double> Numbers(const std::string& mode, const KeyValues& words,
                            const std::string& word, size_t count,
                            const char* example) {
  return ParseNumbers(fmt::format("--mode {}: {}", mode, word), words.at(word),
                      count, example);
}

// Returns the calibrated pixels that the mode's frames contain.
Area ComputeDisplayedArea(const std::string& mode, const KeyValues& words,
                          const ImageSize& calibrated) {
  const auto crop = words.find("crop");
  if (crop == words.end())
    return {0, 0, double(calibrated.width), double(calibrated.height)};
  const std::vector<double> n =
      Numbers(mode, words, "crop", 4, "320,180,640,360");
  if (!(n[0] >= 0 && n[1] >= 0 && n[2] >= 2 && n[3] >= 2 &&
        n[0] + n[2] <= calibrated.width && n[1] + n[3] <= calibrated.height))
    ThrowInvalidMode(
        mode,
        fmt::format("crop={} must be within the calibrated {} x {} pixels, "
                    "and at least 2 x 2",
                    crop->second, calibrated.width, calibrated.height));
  return {n[0], n[1], n[0] + n[2], n[1] + n[3]};
}

// Sets size and scale.
void SetSize(const KeyValues& words, const Area& shown, SensorMode* mode) {
  const Eigen::Vector2d span(shown.width(), shown.height());
  if (words.count("size") + words.count("bin") + words.count("scale") > 1)
    ThrowInvalidMode(mode->name, "size, bin and scale are mutually exclusive");
  Eigen::Vector2d size = span.array().floor();
  std::optional<double> exact_scale;
  if (words.count("bin")) {
    const double bin = Numbers(mode->name, words, "bin", 1, "2")[0];
    if (!(bin >= 1 && bin <= 64 && bin == std::floor(bin)))
      ThrowInvalidMode(mode->name, "bin must be an integer from 1 to 64");
    size = (span / bin).array().floor();
    exact_scale = bin;
  } else if (words.count("scale")) {
    const double scale = Numbers(mode->name, words, "scale", 1, "0.5")[0];
    if (!(scale >= 1.0 / 64 && scale <= 64))
      ThrowInvalidMode(mode->name,
                       "scale must be 1/64 to 64 (0.5: half resolution)");
    size = (span * scale).array().round();
  } else if (words.count("size")) {
    const ImageSize wanted =
        ParseImageSize("--mode " + mode->name + ": size", words.at("size"));
    size = Eigen::Vector2d(wanted.width, wanted.height);
  } else if (size != span) {
    ThrowInvalidMode(mode->name,
                     "crop must be in whole pixels unless size is specified");
  }
  if (!(size.minCoeff() >= 2 && size.maxCoeff() <= 8192))
    ThrowInvalidMode(
        mode->name,
        fmt::format(
            "frames of {} x {} pixels; width and height must be 2 to 8192",
            size.x(), size.y()));
  mode->size = {static_cast<int>(size.x()), static_cast<int>(size.y())};
  mode->scale = exact_scale ? Eigen::Vector2d::Constant(*exact_scale)
                            : Eigen::Vector2d(span.cwiseQuotient(size));
  if (!(mode->scale.minCoeff() >= 1.0 / 64 && mode->scale.maxCoeff() <= 64))
    ThrowInvalidMode(
        mode->name,
        "scale, the ratio of crop to size, must be between 1/64 and 64");
}

void SetFlips(const KeyValues& words, SensorMode* mode) {
  if (const auto flip = words.find("flip"); flip != words.end()) {
    const std::string& text = flip->second;
    if (text != "h" && text != "v" && text != "hv" && text != "vh")
      ThrowInvalidMode(
          mode->name, fmt::format("flip: expected h, v or hv, not '{}'", text));
    mode->flip_x = text.find('h') != std::string::npos;
    mode->flip_y = text.find('v') != std::string::npos;
  }
  if (const auto rotate = words.find("rotate"); rotate != words.end()) {
    if (rotate->second != "180" && rotate->second != "0")
      ThrowInvalidMode(mode->name,
                       fmt::format("rotate: expected 180, not '{}'; 90 and "
                                   "270 degrees are not supported",
                                   rotate->second));
    if (rotate->second == "180") {
      mode->flip_x = !mode->flip_x;
      mode->flip_y = !mode->flip_y;
    }
  }
}

}  // namespace

SensorMode ParseMode(const std::string& text,
                     const ImageSize& calibrated_size) {
  const size_t colon = text.rfind(':');
  if (colon == 0 || colon == std::string::npos)
    ThrowInvalidMode(text, fmt::format("expected {}", kModeKeysHelp));
  SensorMode mode;
  mode.name = text.substr(0, colon);
  const KeyValues words = ParseKeyValues(mode.name, text.substr(colon + 1));
  const Area shown = ComputeDisplayedArea(mode.name, words, calibrated_size);
  mode.offset_px = {shown.x0, shown.y0};
  SetSize(words, shown, &mode);
  SetFlips(words, &mode);
  return mode;
}

std::vector<SensorMode> ParseModes(const std::vector<std::string>& texts,
                                   const ImageSize& calibrated_size) {
  std::vector<SensorMode> modes;
  std::set<std::string> names;
  for (const std::string& text : texts) {
    modes.push_back(ParseMode(text, calibrated_size));
    RequireBlobText("--mode", modes.back().name);
    if (!names.insert(modes.back().name).second)
      ThrowInvalidMode(modes.back().name,
                       "duplicate name; names of modes must be unique");
  }
  return modes;
}

}  // namespace raygrid
