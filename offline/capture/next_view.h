#ifndef RAYGRID_CAPTURE_NEXT_VIEW_H
#define RAYGRID_CAPTURE_NEXT_VIEW_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/board_view.h"
#include "capture/camera_information.h"

namespace raygrid {

/// A candidate view and its gain.
struct NextView {
  BoardView view;
  Pose camera_from_board;
  double gain = 0;
};

/// Returns the gain of a board at a pose, camera_from_board.
using ViewGain = std::function<double(const Pose&)>;

/// Finds the best view of a board among candidates all over the image, at
/// various distances, tilts and rotations, with local refinement. Returns
/// nullopt if no candidate shows at least half of the board's features. Views
/// similar to `avoided` views (camera_from_board) are excluded.
std::optional<NextView> FindBestNextView(const CameraModel& camera,
                                         const Board& board,
                                         const ViewGain& gain,
                                         const std::vector<Pose>& avoided = {});
/// Finds the view with the highest CameraInformation::PredictViewGain().
std::optional<NextView> FindBestNextView(const CameraInformation& information,
                                         const Board& board,
                                         const std::vector<Pose>& avoided = {});

/// Returns the index-th of the default views that are recommended before the
/// first calibration.
BoardView FirstView(int index, const ImageSize& size);
constexpr int kNumFirstViews = 4;

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_NEXT_VIEW_H
