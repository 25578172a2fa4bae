#include "capture_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace raygrid {
namespace {

using Json = nlohmann::json;

constexpr int kCaptureSchemaVersion = 3;

double RoundedPixel(double pixel) { return std::round(10 * pixel) / 10; }

// Rounds to four significant digits.
double Rounded(double value) {
  if (!(value > 0) || std::isinf(value)) return value;
  const double scale = std::pow(10, 3 - std::floor(std::log10(value)));
  return std::round(scale * value) / scale;
}

Json MakePixelsJson(const std::vector<Eigen::Vector2d>& pixels) {
  Json out = Json::array();
  for (const Eigen::Vector2d& pixel : pixels) {
    out.push_back(RoundedPixel(pixel.x()));
    out.push_back(RoundedPixel(pixel.y()));
  }
  return out;
}

}  // namespace

std::string CaptureJson(const CaptureState& state) {
  Json next = Json::array();
  for (const ViewState& view : state.next)
    next.push_back({{"outline", MakePixelsJson(view.outline)},
                    {"top", MakePixelsJson(view.top)}});
  Json places = Json::array();
  for (const PositionState& place : state.places) {
    places.push_back(RoundedPixel(place.pixel.x()));
    places.push_back(RoundedPixel(place.pixel.y()));
    places.push_back(Rounded(place.stddev_px));
  }
  Json cameras = Json::array(), links = Json::array();
  for (const CameraState& camera : state.cameras)
    cameras.push_back({{"name", camera.name},
                       {"status", camera.word},
                       {"uncertainty_px", Rounded(camera.stddev_px)}});
  for (const LinkState& link : state.links)
    links.push_back({{"cameras", {link.first, link.second}},
                     {"uncertainty_px", Rounded(link.stddev_px)}});
  const Json json = {{"schema_version", kCaptureSchemaVersion},
                     {"width", state.width},
                     {"height", state.height},
                     {"camera", state.camera},
                     {"cameras", cameras},
                     {"links", links},
                     {"status", state.word},
                     {"hint", state.hint},
                     {"done", state.is_done},
                     {"paused", state.is_paused},
                     {"features", MakePixelsJson(state.features)},
                     {"next_views", next},
                     {"arrow", MakePixelsJson(state.arrow)},
                     {"uncertainty_map", places},
                     {"uncertainty_px", Rounded(state.stddev_px)},
                     {"uncertainty_is_lower_bound", state.stddev_is_floor},
                     {"requested_uncertainty_px", Rounded(state.target_px)},
                     {"kept_frames", state.kept},
                     {"frames_remaining", state.num_expected},
                     {"edge_width_px", Rounded(state.sharpness_px)},
                     {"white_level", Rounded(state.brightness)},
                     {"frames_per_second", Rounded(state.frames_per_second)},
                     {"warnings", state.warnings}};
  // File names may be invalid UTF-8.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace raygrid
