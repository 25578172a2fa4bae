#include "capture_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace raygrid {
namespace {

// A grid of characters that represents an image.
class CharacterMap {
 public:
  CharacterMap(const CaptureState& state, int num_columns)
      : state_(state),
        num_columns_(num_columns),
        // Characters are about twice as high as wide.
        num_rows_(std::max(
            1, static_cast<int>(std::lround(0.5 * num_columns * state.height /
                                            std::max(1, state.width))))),
        cells_(num_rows_, std::string(num_columns, ' ')) {}

  void Put(const Eigen::Vector2d& pixel, char character) {
    const double x = (pixel.x() + 0.5) / state_.width * num_columns_;
    const double y = (pixel.y() + 0.5) / state_.height * num_rows_;
    if (!(x >= 0 && y >= 0 && x < num_columns_ && y < num_rows_)) return;
    cells_[static_cast<size_t>(y)][static_cast<size_t>(x)] = character;
  }
  void PutLine(const std::vector<Eigen::Vector2d>& line, char character) {
    constexpr int kSteps = 64;
    for (size_t k = 0; k + 1 < line.size(); ++k)
      for (int step = 0; step <= kSteps; ++step)
        Put(line[k] + (line[k + 1] - line[k]) * step / kSteps, character);
  }
  std::string Text() const {
    std::string text = "+" + std::string(num_columns_, '-') + "+\n";
    for (const std::string& row : cells_) text += "|" + row + "|\n";
    return text + "+" + std::string(num_columns_, '-') + "+\n";
  }

 private:
  const CaptureState& state_;
  const int num_columns_, num_rows_;
  std::vector<std::string> cells_;
};

// Returns a line of text about a rig's cameras and their relative poses.
std::string RigLine(const CaptureState& state) {
  std::string text;
  for (const CameraState& camera : state.cameras) {
    text += fmt::format("{}{} {}", text.empty() ? "" : "   ", camera.name,
                        camera.word);
    if (camera.stddev_px > 0)
      text += fmt::format(" {:.3f} px", camera.stddev_px);
  }
  for (const LinkState& link : state.links)
    text += fmt::format("   {}-{} {:.3f} px", link.first, link.second,
                        link.stddev_px);
  return text.empty() ? "" : text + "\n";
}

// Returns a darker character for a larger uncertainty, in factors of two above
// the target.
char ComputeShade(double stddev_px, double good_px) {
  constexpr char kShades[] = " .:*@";
  const int step = static_cast<int>(std::ceil(std::log2(stddev_px / good_px)));
  return kShades[std::clamp(step, 0, 4)];
}

std::string FormatProgress(const CaptureState& state) {
  std::string text = fmt::format("{} kept", state.kept.size());
  if (state.num_expected > 0)
    text += fmt::format(", about {} more", state.num_expected);
  if (state.stddev_px > 0) {
    text += fmt::format("   uncertainty {:.2g} px{}", state.stddev_px,
                        state.stddev_is_floor ? " (lower bound)" : "");
    if (state.target_px > 0)
      text += fmt::format(", target {:g} px", state.target_px);
  }
  return text;
}

}  // namespace

std::string DrawState(const CaptureState& state, int num_columns) {
  if (state.width <= 0 || num_columns < 10) return "";
  CharacterMap map(state, num_columns);
  constexpr double kGoodPx = 0.02;
  for (const PositionState& place : state.places)
    map.Put(place.pixel,
            ComputeShade(place.stddev_px,
                         state.target_px > 0 ? state.target_px : kGoodPx));
  for (const Eigen::Vector2d& feature : state.features) map.Put(feature, 'o');
  for (const ViewState& view : state.next) {
    std::vector<Eigen::Vector2d> closed = view.outline;
    if (!closed.empty()) closed.push_back(closed.front());
    map.PutLine(closed, '#');
    map.PutLine(view.top, '=');
  }
  std::string text = map.Text();
  text += fmt::format("{:<8} {}\n", state.word, state.hint);
  text += RigLine(state);
  text += FormatProgress(state) + "\n";
  text += fmt::format(
      "edge width {:.1f} px   white level {:.0f} %   {:.1f} frames/s\n",
      state.sharpness_px, 100 * state.brightness, state.frames_per_second);
  for (const std::string& warning : state.warnings) text += warning + "\n";
  return text;
}

}  // namespace raygrid
