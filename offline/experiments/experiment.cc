#include "experiments/experiment.h"

namespace raygrid {

const std::vector<Experiment>& Experiments() {
  static const std::vector<Experiment> experiments = {
      {"pattern-segments",
       "localisation error against the number of star segments",
       ComparePatternSegments},
      {"feature-refinement",
       "localisation error of each refinement, on the same images",
       CompareFeatureRefinements}};
  return experiments;
}

}  // namespace raygrid
