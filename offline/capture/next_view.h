#ifndef RAYGRID_CAPTURE_NEXT_VIEW_H
#define RAYGRID_CAPTURE_NEXT_VIEW_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/board_view.h"
#include "capture/camera_knowledge.h"

namespace raygrid {

/// A view that would add much, and how much.
struct NextView {
  BoardView view;
  Pose camera_from_board;
  double gain = 0;
};

/// The gain of a board in a pose, camera_from_board.
using ViewGain = std::function<double(const Pose&)>;

/// The best view of a board among candidates all over the image, near and far,
/// tilted and turned, and some around the best of them. Nothing if no
/// candidate shows half of the board. Views that are as good as avoided ones
/// (camera_from_board) are none.
std::optional<NextView> BestNextView(const CameraModel& camera,
                                     const Board& board, const ViewGain& gain,
                                     const std::vector<Pose>& avoided = {});
/// The view that tells most of a camera: CameraKnowledge::GainOfView().
std::optional<NextView> BestNextView(const CameraKnowledge& knowledge,
                                     const Board& board,
                                     const std::vector<Pose>& avoided = {});

/// The views to begin with, while nothing is known of a camera.
BoardView FirstView(int index, const ImageSize& size);
constexpr int kNumFirstViews = 4;

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_NEXT_VIEW_H
