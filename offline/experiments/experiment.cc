#include "experiments/experiment.h"

namespace raygrid {

const std::vector<Experiment>& Experiments() {
  static const std::vector<Experiment> experiments = {
      {"pattern-segments",
       "localisation error against the number of star segments",
       ComparePatternSegments,
       24,
       {}},
      {"feature-refinement",
       "localisation error of each refinement, on the same images",
       CompareFeatureRefinements,
       24,
       {}},
      {"model-validation",
       "errors and bias of all models, from the same features",
       ValidateModels,
       75,
       {"--features"}},
      {"model-comparison",
       "where parametric models differ from a generic camera",
       CompareModelsByFit,
       60,
       {"--features", "--camera"}},
      {"curvature-bias",
       "what refinement by symmetry leaves behind a wide lens",
       MeasureCurvatureBias,
       40,
       {"--features", "--camera", "--image"}},
      {"noncentrality",
       "how non-central a camera is, and where it matters",
       MeasureNoncentrality,
       60,
       {"--features", "--camera"}},
      {"localization",
       "error of a camera's place, by model and images averaged",
       LocalizeByModels,
       60,
       {"--features"}},
      {"stereo-depth",
       "bias of depth by stereo, by calibration",
       MeasureStereoDepth,
       40,
       {"--rig", "--image", "--nearest-m"}},
      {"trajectory-drift",
       "where a walk ends, by calibration",
       MeasureTrajectoryDrift,
       60,
       {"--features", "--camera", "--walk"}}};
  return experiments;
}

}  // namespace raygrid
