#include "experiments/experiment.h"

namespace raygrid {

const std::vector<Experiment>& Experiments() {
  static const std::vector<Experiment> experiments = {
      {"pattern-segments",
       "localisation error against the number of star segments",
       ComparePatternSegments, 24, UserData::kNone},
      {"feature-refinement",
       "localisation error of each refinement, on the same images",
       CompareFeatureRefinements, 24, UserData::kNone},
      {"model-validation",
       "errors and bias of all models, from the same features", ValidateModels,
       75, UserData::kFeatures},
      {"model-comparison",
       "where parametric models differ from a generic camera",
       CompareModelsByFit, 60, UserData::kFeaturesOrCamera},
      {"curvature-bias",
       "what refinement by symmetry leaves behind a wide lens",
       MeasureCurvatureBias, 40, UserData::kNone},
      {"noncentrality", "how non-central a camera is, and where it matters",
       MeasureNoncentrality, 60, UserData::kFeaturesOrCamera},
      {"localization",
       "error of a camera's place, by model and images averaged",
       LocalizeByModels, 60, UserData::kFeatures},
      {"stereo-depth", "bias of depth by stereo, by calibration",
       MeasureStereoDepth, 40, UserData::kNone},
      {"trajectory-drift", "where a walk ends, by calibration",
       MeasureTrajectoryDrift, 60, UserData::kFeatures}};
  return experiments;
}

}  // namespace raygrid
