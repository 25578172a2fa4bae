#ifndef RAYGRID_EVALUATION_PREDICTION_COMPARISON_H
#define RAYGRID_EVALUATION_PREDICTION_COMPARISON_H

#include <string>
#include <vector>

#include "evaluation/residual_statistics.h"

namespace raygrid {

/// Mean errors of the features that both cameras were told of, in an image.
struct ImagePrediction {
  std::string image;
  int num_features = 0;
  double first_px = 0, second_px = 0;
};

/// Which of two cameras tells better where features are seen.
struct PredictionComparison {
  ErrorFigures first, second;  ///< of the same features
  int num_left_out = 0;        ///< features of one camera only
  std::vector<ImagePrediction> images;
  int num_first_better = 0, num_second_better = 0;  ///< images
  /// The probability of images that differ so one-sidedly, or more so, if the
  /// cameras were as good as each other: Wilcoxon's signed ranks (1945) of the
  /// images' mean errors, two-sided. Features of one image share its pose,
  /// images nothing.
  double probability = 1;

  /// "first", "second", or "neither" if chance makes such images more often
  /// than once in a hundred.
  const char* Better() const;
};

/// Residuals of the same features, of images localised with either camera.
PredictionComparison ComparePredictions(
    const std::vector<FeatureResidual>& first,
    const std::vector<FeatureResidual>& second);

/// Wilcoxon's test of differences being as often and as much above zero as
/// below: two-sided probability, exact for up to 100 differences.
double SignedRankProbability(std::vector<double> differences);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_PREDICTION_COMPARISON_H
