/// The localization error of features in rendered images.
#ifndef RAYGRID_EXPERIMENTS_LOCALIZATION_ERROR_H
#define RAYGRID_EXPERIMENTS_LOCALIZATION_ERROR_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "experiments/experiment.h"
#include "features/board_view/detection.h"

namespace raygrid {

/// A board, and the detection methods to compare.
struct DetectedBoard {
  Board board;
  std::vector<DetectionOptions> ways;
};

/// The error of one board and one detection method, over all images.
struct LocalizationError {
  int num_visible = 0, num_found = 0;
  int num_compared = 0;      ///< features found with every board and method
  Eigen::Array2d median_px;  ///< medians of |x| and |y|
  Eigen::Array2d rms_px;     ///< RMS of x and y
  double max_error_px = 0;   ///< maximum distance
};

/// Returns the boards of all experiments: 12 x 9 features, squares of 12 mm.
Board ExperimentStarBoard(int segments);
Board ExperimentChessboard();

/// Renders every board in the same poses, fully visible, with the same noise.
/// Evaluates only features that are found in all boards by all methods (paper,
/// "Calibration Pattern Evaluation": "for fairness"). Ordered by board and
/// method. Throws Error(kUsage) if the boards do not fit into the image,
/// Error(kInsufficientData) if no feature is found by all.
std::vector<LocalizationError> MeasureLocalization(
    const std::vector<DetectedBoard>& boards, const ExperimentOptions& options);

/// Describes the conditions of MeasureLocalization().
std::vector<Condition> ListLocalizationConditions(
    const ExperimentOptions& options);
/// Returns the conditions of MeasureLocalization() in one line.
std::string LocalizationNote(const ExperimentOptions& options);

/// Appends the columns of an error to a table; its cells to a row.
std::vector<std::string> LocalizationColumns(std::vector<std::string> first);
std::vector<Cell> LocalizationCells(std::vector<Cell> first,
                                    const LocalizationError& error);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_LOCALIZATION_ERROR_H
