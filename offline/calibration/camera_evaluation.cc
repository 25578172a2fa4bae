#include "calibration/camera_evaluation.h"

#include "adjustment/reprojection_error.h"
#include "calibration/calibration_problem.h"

namespace raygrid {

Evaluation EvaluateCamera(const CameraModel& camera, const Dataset& dataset,
                          const Pattern& pattern, int num_threads) {
  Evaluation evaluation;
  const CalibrationProblem problem =
      BuildProblem({dataset}, pattern, &evaluation.rejected_images);
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(camera, 0, problem, num_threads);
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (!poses[v]) {
      evaluation.rejected_images.push_back(
          {problem.images[v], "could not be localised"});
      continue;
    }
    for (const Observation& observation : problem.views[v].observations) {
      const auto pixel =
          camera.Project(*poses[v] * problem.nominal[observation.point],
                         &observation.pixel, kAdjustmentMarginPx);
      if (!camera.area().Contains(observation.pixel) || !pixel) {
        ++evaluation.outside_area;
        continue;
      }
      const Feature feature = problem.FeatureOf(pattern, v, observation);
      evaluation.residuals.push_back(
          {problem.images[v], feature.board, feature.column, feature.row,
           observation.pixel, *pixel - observation.pixel});
    }
  }
  return evaluation;
}

}  // namespace raygrid
