#ifndef RAYGRID_CALIBRATION_BOARD_ROTATIONS_H
#define RAYGRID_CALIBRATION_BOARD_ROTATIONS_H

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "calibration/calibration_problem.h"
#include "calibration/model_adjustment.h"

namespace raygrid {

/// How boards are turned against how detection numbered their features, by
/// image and board id: steps of Board::Rotated(). Those that are not turned are
/// left out.
using BoardRotations = std::map<std::pair<std::string, int>, int>;

/// Whether a board of the pattern looks alike after a turn.
bool HasSymmetricBoards(const Pattern& pattern);

/// A dataset with the features of turned boards renumbered.
Dataset Rotated(const Dataset& dataset, const Pattern& pattern,
                const BoardRotations& turns);

/// A turn by first, then by second, in each image.
BoardRotations ComposeRotations(const BoardRotations& first,
                                const BoardRotations& second,
                                const Pattern& pattern);

/// The views of a dataset that a camera localises, with their poses.
AdjustmentResult LocalizeDatasetViews(const CameraModel& camera,
                                      const Dataset& dataset,
                                      const Pattern& pattern, int num_threads);

/// Adds views with their poses to a camera's own, each with a pose of its own.
void AddViews(const AdjustmentResult& views, AdjustmentResult* camera);

/// The rotation about a board's middle, board_from_board, that brings the
/// points of features to where those are that they become by a turn.
Pose ComputeRotation(const Board& board, int turn);

struct GeometricRotations {
  BoardRotations turns;
  /// Views, by image and board id, of a board whose points are displaced as no
  /// turn of it is, by so little that these may be turned otherwise.
  std::vector<std::pair<std::string, int>> doubtful;
};

/// The turns by which the displacements of a board's points agree best over all
/// its views. Cameras that were adjusted with nominal points, each on its own
/// images; views in images of one name share their turn. Only views that are
/// surely otherwise than most are turned.
GeometricRotations ResolveRotationsByGeometry(
    const std::vector<AdjustmentResult>& cameras, const Pattern& pattern);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_BOARD_ROTATIONS_H
