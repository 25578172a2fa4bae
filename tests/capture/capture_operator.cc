#include "capture_operator.h"

#include <string>
#include <utility>

#include "camera/pose.h"
#include "capture/board_outline.h"
#include "capture/board_view.h"
#include "initialization/localization.h"

namespace raygrid {

using Json = nlohmann::json;

std::optional<Json> NextState(HttpClient* page) {
  for (;;) {
    const std::string event = page->Until("\n\n");
    const size_t data = event.find("data: ");
    if (data == std::string::npos) return std::nullopt;
    Json state = Json::parse(event.substr(data + 6), nullptr, false);
    if (!state.is_discarded() && state.contains("kept")) return state;
  }
}

CaptureOperator::CaptureOperator(const CameraModel& camera, const Board& board,
                                 int patience)
    : camera_(camera),
      board_(board),
      surface_(board),
      rays_(camera, 2),
      patience_(patience) {}

std::optional<std::vector<uint8_t>> CaptureOperator::Look(const Json& state) {
  is_done_ = state["done"];
  const bool is_taken = state["kept_frames"].size() > num_kept_;
  num_kept_ = state["kept_frames"].size();
  if (is_done_ || state["next_views"].empty() || state["status"] == "busy")
    return std::nullopt;
  const Json& outline = state["next_views"][0]["outline"];
  const bool is_new = is_taken || outline != filled_;
  if (!is_new && ++num_looks_ < patience_) return std::nullopt;
  num_looks_ = 0;
  auto picture = Fill(outline);
  if (!picture) return std::nullopt;
  filled_ = outline;
  ++num_views_;
  return picture;
}

std::optional<std::vector<uint8_t>> CaptureOperator::Fill(const Json& outline) {
  const std::vector<Eigen::Vector3d> points = OutlinePoints(board_);
  if (outline.size() != 2 * points.size()) return std::nullopt;
  std::vector<PointPixelMatch> matches;
  for (size_t k = 0; k < points.size(); ++k)
    matches.push_back(
        {points[k], Eigen::Vector2d(outline[2 * k].get<double>(),
                                    outline[2 * k + 1].get<double>())});
  const auto pose = Localize(camera_, matches);
  if (!pose) return std::nullopt;
  constexpr double kOffM = 0.01, kOffRad = 0.035;
  Eigen::Matrix<double, 6, 1> off;
  for (int k = 0; k < 6; ++k)
    off[k] = random_.Normal() * (k < 3 ? kOffRad : kOffM);
  const Eigen::Vector3d middle = ComputeBoardCenter(board_);
  Pose held = *pose;
  held.rotation = RotationFromVector(off.head<3>()) * pose->rotation;
  held.translation = *pose * middle - held.rotation * middle + off.tail<3>();
  ImagingOptions imaging;
  imaging.read_noise = 1;
  imaging.seed = static_cast<uint64_t>(num_views_) + 1;
  return AddNoiseAndQuantize(
             RenderImage(rays_, {{&surface_, held}}, imaging, 2), imaging)
      .pixels;
}

}  // namespace raygrid
