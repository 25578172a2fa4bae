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

/// Computes the local mapping around a target point within the window from the
/// estimated camera and pose, centred at the feature's pixel. Returns nullopt
/// outside the calibrated area.
std::optional<LocalMapping> ComputeCameraMapping(const CameraModel& camera,
                                                 const Pose& camera_from_board,
                                                 const Board& board,
                                                 const Feature& feature,
                                                 int window_px);

/// The estimated camera, target and poses.
struct EstimatedScene {
  const CameraModel* camera;
  const Pattern* pattern;  ///< with estimated target geometry
  std::vector<BoardPose> poses;
};

/// Refines the features of images with mappings computed from the camera.
/// Unlike mappings fitted to neighbouring features, these are free of noise,
/// and equally accurate at the board's edge. Features of boards without a pose,
/// and features whose refinement fails, are unchanged. paths: one per image of
/// the dataset, which is read again. Throws InputError for unreadable images.
Dataset RefineFeaturesWithCamera(const std::vector<std::string>& paths,
                                 const Dataset& dataset,
                                 const EstimatedScene& scene,
                                 const DetectionOptions& options,
                                 int num_threads,
                                 const std::function<void(double)>& progress);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_REFINEMENT_CAMERA_REFINEMENT_H
