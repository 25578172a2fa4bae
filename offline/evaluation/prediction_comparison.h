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

/// Which of two cameras predicts features better.
struct PredictionComparison {
  ErrorMetrics first, second;  ///< of the same features
  int num_left_out = 0;        ///< features that only one camera predicts
  std::vector<ImagePrediction> images;
  int num_first_better = 0, num_second_better = 0;  ///< images
  /// p-value of equal accuracy: Wilcoxon's signed-rank test (1945) of the
  /// images' mean errors, two-sided. Features of one image share its pose;
  /// images are independent.
  double probability = 1;

  /// "first", "second", or "neither" if p > 0.01.
  const char* Better() const;
};

/// Residuals of the same features, of images localized with each camera.
PredictionComparison ComparePredictions(
    const std::vector<FeatureResidual>& first,
    const std::vector<FeatureResidual>& second);

/// Wilcoxon's signed-rank test of differences being symmetric about zero:
/// two-sided p-value, exact for up to 100 differences.
double SignedRankProbability(std::vector<double> differences);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_PREDICTION_COMPARISON_H
