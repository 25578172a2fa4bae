#ifndef RAYGRID_EVALUATION_PREDICTION_COMPARISON_H
#define RAYGRID_EVALUATION_PREDICTION_COMPARISON_H

#include <string>
#include <vector>

#include "evaluation/residual_statistics.h"

namespace raygrid {

/// Mean errors, in one image, of the features that both cameras predict.
struct ImagePrediction {
  std::string image;
  int num_features = 0;
  double first_px = 0, second_px = 0;
};

/// The comparison of two cameras' prediction errors.
struct PredictionComparison {
  ErrorMetrics first, second;  ///< metrics over the same features
  int num_left_out = 0;        ///< features that only one camera predicts
  std::vector<ImagePrediction> images;
  int num_first_better = 0, num_second_better = 0;  ///< number of images
  /// p-value of equal accuracy: Wilcoxon's signed-rank test (1945) of the
  /// images' mean errors, two-sided. Features of one image share its pose;
  /// images are independent.
  double probability = 1;

  /// Returns "first", "second", or "neither" if p > 0.01.
  const char* NameBetterCamera() const;
};

/// Compares residuals of the same features, localized with each camera.
PredictionComparison ComparePredictions(
    const std::vector<FeatureResidual>& first,
    const std::vector<FeatureResidual>& second);

/// Tests differences for symmetry about zero (Wilcoxon's signed-rank test):
/// returns the two-sided p-value, exact for up to 100 differences.
double SignedRankProbability(std::vector<double> differences);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_PREDICTION_COMPARISON_H
