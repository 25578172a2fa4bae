#ifndef RAYGRID_CALIBRATION_CAMERA_EVALUATION_H
#define RAYGRID_CALIBRATION_CAMERA_EVALUATION_H

#include <vector>

#include "camera/camera_model.h"
#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"

namespace raygrid {

struct CalibrationProblem;

struct Evaluation {
  std::vector<FeatureResidual> residuals;
  std::vector<RejectedImage> rejected_images;
  int outside_area = 0;  ///< features that the camera is not calibrated for
};

/// The residuals of a view that stands at a pose.
void AddResiduals(const CameraModel& camera, const Pose& camera_from_pattern,
                  const Pattern& pattern, const CalibrationProblem& problem,
                  int view, Evaluation* evaluation);

/// Localises each image with the camera and the pattern as they are.
Evaluation EvaluateCamera(const CameraModel& camera, const Dataset& dataset,
                          const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_EVALUATION_H
