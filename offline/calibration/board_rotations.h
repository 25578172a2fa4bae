#ifndef RAYGRID_CALIBRATION_BOARD_ROTATIONS_H
#define RAYGRID_CALIBRATION_BOARD_ROTATIONS_H

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "calibration/calibration_problem.h"
#include "calibration/model_adjustment.h"

namespace raygrid {

/// Rotations of boards relative to the feature numbering of the detection, by
/// image and board id, in steps of Board::Rotated(). Boards without rotation
/// are omitted.
using BoardRotations = std::map<std::pair<std::string, int>, int>;

/// Returns whether any board of the pattern has a rotational symmetry.
bool HasSymmetricBoards(const Pattern& pattern);

/// Returns the dataset with the features of rotated boards renumbered.
Dataset Rotated(const Dataset& dataset, const Pattern& pattern,
                const BoardRotations& turns);

/// Composes rotations: first, then second, in each image.
BoardRotations ComposeRotations(const BoardRotations& first,
                                const BoardRotations& second,
                                const Pattern& pattern);

/// Localizes the views of a dataset; returns the views with their poses.
AdjustmentResult LocalizeDatasetViews(const CameraModel& camera,
                                      const Dataset& dataset,
                                      const Pattern& pattern, int num_threads);

/// Appends views and their poses; poses are not shared with existing views.
void AddViews(const AdjustmentResult& views, AdjustmentResult* camera);

/// Returns the rotation about the board centre, board_from_board, that maps
/// each feature's point to the point that it is renumbered to by the rotation.
Pose ComputeRotation(const Board& board, int turn);

struct GeometricRotations {
  BoardRotations turns;
  /// Views, by image and board id, of boards whose estimated points match no
  /// rotation; their displacements are too small to exclude another rotation.
  std::vector<std::pair<std::string, int>> doubtful;
};

/// Estimates the rotations for which the displacements of a board's points are
/// most consistent over all its views. Each camera was adjusted alone, with
/// nominal points; views in images of the same name share a rotation. Only
/// views that differ significantly from the majority are rotated.
GeometricRotations ResolveRotationsByGeometry(
    const std::vector<AdjustmentResult>& cameras, const Pattern& pattern);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_BOARD_ROTATIONS_H
