#ifndef RAYGRID_FEATURES_REFINEMENT_CAMERA_REFINEMENT_H
#define RAYGRID_FEATURES_REFINEMENT_CAMERA_REFINEMENT_H

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera_model.h"
#include "features/board_view/detection.h"
#include "features/board_view/local_mapping.h"

namespace raygrid {

/// How the camera sees the surroundings of a board's point, as far as the
/// window reaches, board and camera being where they are known to be. Nothing
/// where the camera is not calibrated. The centre is the feature's pixel.
std::optional<LocalMapping> ComputeCameraMapping(const CameraModel& camera,
                                                 const Pose& camera_from_board,
                                                 const Board& board,
                                                 const Feature& feature,
                                                 int window_px);

/// The scene as it is known once a camera is calibrated.
struct EstimatedScene {
  const CameraModel* camera;
  const Pattern* pattern;  ///< points where they were found to be
  std::vector<BoardPose> poses;
};

/// The features of images measured once more, with the mappings that the camera
/// tells: unlike those from neighbouring features, they are free of noise, and
/// as good at the board's edge as in its middle. Those of boards without a pose
/// and those that symmetry does not pull to a place near stay as they are.
/// Images are read again; paths are those of the dataset's images. Throws
/// InputError for an image that cannot be read any more.
Dataset RefineFeaturesWithCamera(const std::vector<std::string>& paths,
                                 const Dataset& dataset,
                                 const EstimatedScene& scene,
                                 const DetectionOptions& options,
                                 int num_threads,
                                 const std::function<void(double)>& progress);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_CAMERA_REFINEMENT_H
