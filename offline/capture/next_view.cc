#include "capture/next_view.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/view_hint.h"

namespace raygrid {
namespace {

constexpr double kTiltsRad[] = {0.35, 0.7};
constexpr int kNumAxes = 4;

class Search {
 public:
  Search(const CameraModel& camera, const Board& board, const ViewGain& gain,
         const std::vector<Pose>& avoided)
      : camera_(camera), board_(board), gain_(gain), avoided_(avoided) {}

  void EvaluateView(const BoardView& view) {
    const auto pose = ComputePose(view, board_, camera_);
    if (!pose || !ContainsHalfBoard(*pose) || IsAvoided(*pose)) return;
    found_.push_back({view, *pose, gain_(*pose)});
  }
  /// Keeps only the `count` candidates with the largest gain.
  void KeepBest(size_t count) {
    std::stable_sort(
        found_.begin(), found_.end(),
        [](const NextView& a, const NextView& b) { return a.gain > b.gain; });
    found_.resize(std::min(found_.size(), count));
  }
  const std::vector<NextView>& found() const { return found_; }

 private:
  bool ContainsHalfBoard(const Pose& pose) const {
    const Area image = WholeImage(camera_.image_size());
    int num_seen = 0, num_all = 0;
    for (int row = 0; row < board_.rows; ++row)
      for (int column = 0; column < board_.columns; ++column) {
        if (!board_.HasFeature(column, row)) continue;
        ++num_all;
        const auto pixel = camera_.Project(
            pose * board_.points[board_.PointIndex(column, row)]);
        num_seen +=
            pixel && image.Contains(*pixel) && camera_.IsInImageCircle(*pixel);
      }
    return 2 * num_seen >= num_all;
  }

  bool IsAvoided(const Pose& pose) const {
    return std::any_of(avoided_.begin(), avoided_.end(),
                       [&](const Pose& other) {
                         return HasReachedView(camera_, board_, pose, other);
                       });
  }

  const CameraModel& camera_;
  const Board& board_;
  const ViewGain& gain_;
  const std::vector<Pose>& avoided_;
  std::vector<NextView> found_;
};

}  // namespace

std::optional<NextView> FindBestNextView(const CameraModel& camera,
                                         const Board& board,
                                         const ViewGain& gain,
                                         const std::vector<Pose>& avoided) {
  constexpr int kColumns = 7, kRows = 5;
  constexpr double kWidths[] = {0.4, 0.7, 1.1};  // relative to the image width
  const ImageSize size = camera.image_size();
  Search search(camera, board, gain, avoided);
  int turn = 0;
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kColumns; ++i)
      for (const double width : kWidths)
        search.EvaluateView({{(i + 0.5) / kColumns * size.width,
                              (j + 0.5) / kRows * size.height},
                             width * size.width,
                             0.5,
                             (turn++ % kNumAxes) * 2 * M_PI / kNumAxes,
                             0});
  // Varies tilt, and rotates by 90 degrees, around each of the best candidates.
  search.KeepBest(3);
  for (const NextView& start : std::vector<NextView>(search.found())) {
    for (const double turn_rad : {0.0, M_PI / 2}) {
      BoardView view = start.view;
      view.turn_rad = turn_rad;
      view.tilt_rad = 0;
      search.EvaluateView(view);
      for (const double tilt_rad : kTiltsRad)
        for (int axis = 0; axis < kNumAxes; ++axis) {
          view.tilt_rad = tilt_rad;
          view.axis_rad = axis * 2 * M_PI / kNumAxes;
          search.EvaluateView(view);
        }
    }
  }
  search.KeepBest(1);
  if (search.found().empty()) return std::nullopt;
  // Refines position and width around the best candidate.
  const BoardView best = search.found().front().view;
  for (const double x : {-0.25, 0.0, 0.25})
    for (const double y : {-0.25, 0.0, 0.25})
      for (const double factor : {0.8, 1.0, 1.25}) {
        BoardView view = best;
        view.pixel +=
            Eigen::Vector2d(x / kColumns * size.width, y / kRows * size.height);
        view.width_px *= factor;
        search.EvaluateView(view);
      }
  search.KeepBest(1);
  return search.found().front();
}

std::optional<NextView> FindBestNextView(const CameraInformation& information,
                                         const Board& board,
                                         const std::vector<Pose>& avoided) {
  return FindBestNextView(
      information.camera(), board,
      [&](const Pose& pose) {
        return information.PredictViewGain(board, pose);
      },
      avoided);
}

BoardView FirstView(int index, const ImageSize& size) {
  constexpr double kWidths[] = {0.7, 0.45}, kTiltRad = 0.6;
  BoardView view;
  view.pixel = {size.width / 2.0, size.height / 2.0};
  view.width_px = kWidths[index / kNumFirstViews % 2] * size.width;
  view.tilt_rad = kTiltRad;
  view.axis_rad = index * 2 * M_PI / kNumFirstViews;
  return view;
}

}  // namespace raygrid
