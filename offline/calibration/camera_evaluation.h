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
  int outside_area = 0;  ///< features outside the calibrated area
};

/// Adds the residuals of a view at the given pose.
void AddResiduals(const CameraModel& camera, const Pose& camera_from_pattern,
                  const Pattern& pattern, const CalibrationProblem& problem,
                  int view, Evaluation* evaluation);

/// Localizes each image with fixed camera and pattern; returns the residuals.
Evaluation EvaluateCamera(const CameraModel& camera, const Dataset& dataset,
                          const Pattern& pattern, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CAMERA_EVALUATION_H
