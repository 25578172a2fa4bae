#include "capture_options.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "key_options.h"

namespace raygrid {

const char kCaptureSyntaxHelp[] =
    "Capture settings, separated by commas:\n"
    "  crop=X,Y,W,H                   sensor crop in sensor pixels\n"
    "  lens=DPT, tolerance=DPT        lens position in dioptres, and the "
    "maximum\n"
    "                                 deviation accepted for a frame\n"
    "                                 (default: 0.1)\n"
    "  zoom=FACTOR                    digital zoom; 1: full field of view\n"
    "  orientation=1..8               EXIF orientation\n"
    "  temperature=C, exposure=US, gain=FACTOR\n";

const char kCaptureKeysHelp[] =
    "crop=X,Y,W,H (sensor crop in sensor pixels), lens=DIOPTRES (LensPosition "
    "of libcamera), tolerance=DIOPTRES (default: 0.1), zoom=FACTOR (1: full "
    "field of view), orientation=1..8 (as in EXIF), temperature=CELSIUS, "
    "exposure=MICROSECONDS, gain=FACTOR";

namespace {

[[noreturn]] void ThrowInvalidCapture(const std::string& fault) {
  throw Error(ExitCode::kUsage, "--capture-settings: " + fault);
}

std::vector<double> CaptureNumbers(const std::string& word,
                                   const std::string& text, size_t count,
                                   const char* example) {
  return ParseNumbers("--capture-settings: " + word, text, count, example);
}

// Parses an integer of any magnitude.
int WholeNumber(const std::string& word, double number) {
  if (number != std::floor(number) || std::abs(number) > 1e9)
    ThrowInvalidCapture(fmt::format("{}: {} is not an integer", word, number));
  return static_cast<int>(number);
}

void ParseKey(const std::string& word, const std::string& text,
              Capture* capture) {
  if (word == "crop") {
    const std::vector<double> n =
        CaptureNumbers(word, text, 4, "0,0,3280,2464");
    capture->crop.emplace();
    for (size_t k = 0; k < 4; ++k)
      (*capture->crop)[k] = WholeNumber(word, n[k]);
  } else if (word == "lens") {
    capture->lens_position = CaptureNumbers(word, text, 1, "2.5")[0];
  } else if (word == "tolerance") {
    capture->lens_tolerance = CaptureNumbers(word, text, 1, "0.1")[0];
  } else if (word == "zoom") {
    capture->zoom = CaptureNumbers(word, text, 1, "1")[0];
  } else if (word == "temperature") {
    capture->sensor_temperature_c = CaptureNumbers(word, text, 1, "41")[0];
  } else if (word == "exposure") {
    capture->exposure_us = CaptureNumbers(word, text, 1, "8333")[0];
  } else if (word == "gain") {
    capture->analogue_gain = CaptureNumbers(word, text, 1, "1.5")[0];
  } else {
    capture->orientation =
        WholeNumber(word, CaptureNumbers(word, text, 1, "1")[0]);
  }
}

}  // namespace

std::optional<Capture> ParseCaptureKeys(const std::vector<std::string>& texts,
                                        const std::optional<Capture>& known,
                                        const ImageSize& size) {
  static const std::set<std::string> kKnown = {
      "crop",        "lens",        "tolerance", "zoom",
      "orientation", "temperature", "exposure",  "gain"};
  if (texts.empty()) return known;
  if (texts.size() == 1 && texts[0] == "none") return std::nullopt;
  Capture capture = known.value_or(Capture());
  std::set<std::string> taken;
  for (const std::string& text : texts) {
    for (const std::string& part : SplitAtKeys(text)) {
      const size_t equals = part.find('=');
      const std::string word = part.substr(0, equals);
      if (equals == std::string::npos || !kKnown.count(word))
        ThrowInvalidCapture(fmt::format("expected none or {}, not '{}'",
                                        kCaptureKeysHelp, Printable(part)));
      if (!taken.insert(word).second)
        ThrowInvalidCapture(word + " is specified twice");
      ParseKey(word, part.substr(equals + 1), &capture);
    }
  }
  if (!capture.lens_position && taken.count("tolerance"))
    ThrowInvalidCapture("tolerance requires lens");
  if (const char* const impossible = FindInvalidValue(capture, size))
    ThrowInvalidCapture(impossible);
  return capture;
}

}  // namespace raygrid
