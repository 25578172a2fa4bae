#include "calibration/camera_evaluation.h"

#include "adjustment/reprojection_error.h"
#include "calibration/calibration_problem.h"

namespace raygrid {

void AddResiduals(const CameraModel& camera, const Pose& camera_from_pattern,
                  const Pattern& pattern, const CalibrationProblem& problem,
                  int view, Evaluation* evaluation) {
  for (const Observation& observation : problem.views[view].observations) {
    const auto pixel =
        camera.Project(camera_from_pattern * problem.nominal[observation.point],
                       &observation.pixel, kAdjustmentMarginPx);
    if (!camera.area().Contains(observation.pixel) || !pixel) {
      ++evaluation->outside_area;
      continue;
    }
    const Feature feature = problem.GetFeature(pattern, view, observation);
    evaluation->residuals.push_back(
        {problem.images[view], feature.board, feature.column, feature.row,
         observation.pixel, *pixel - observation.pixel});
  }
}

Evaluation EvaluateCamera(const CameraModel& camera, const Dataset& dataset,
                          const Pattern& pattern, int num_threads) {
  Evaluation evaluation;
  const CalibrationProblem problem =
      BuildProblem({dataset}, pattern, &evaluation.rejected_images);
  const std::vector<std::optional<Pose>> poses =
      LocalizeViews(camera, 0, problem, num_threads);
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    if (poses[v])
      AddResiduals(camera, *poses[v], pattern, problem, v, &evaluation);
    else
      evaluation.rejected_images.push_back(
          {problem.images[v], "pose estimation failed"});
  }
  return evaluation;
}

}  // namespace raygrid
