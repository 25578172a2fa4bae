/// How far from the truth features are found in rendered images.
#ifndef RAYGRID_EXPERIMENTS_LOCALIZATION_ERROR_H
#define RAYGRID_EXPERIMENTS_LOCALIZATION_ERROR_H

#include <Eigen/Core>
#include <string>
#include <vector>

#include "experiments/experiment.h"
#include "features/board_view/detection.h"

namespace raygrid {

/// A board, and the ways in which its features are sought.
struct DetectedBoard {
  Board board;
  std::vector<DetectionOptions> ways;
};

/// The error of one board and one way of detecting it, over all images.
struct LocalizationError {
  int num_visible = 0, num_found = 0;
  int num_compared = 0;      ///< found in every board and way
  Eigen::Array2d median_px;  ///< of |x| and |y|
  Eigen::Array2d rms_px;     ///< of x and y
  double largest_px = 0;     ///< distance
};

/// The boards of all experiments: 12 x 9 features, squares of 12 mm.
Board ExperimentStarBoard(int segments);
Board ExperimentChessboard();

/// Renders every board in the same poses, wholly seen, with the same noise.
/// Compares with the truth what is found in all boards in all ways (paper,
/// "Calibration Pattern Evaluation": "for fairness"). In the order of the
/// boards and their ways. Throws Error(kUsage) if the boards do not fit the
/// image, Error(kTooFew) if nothing is found in all.
std::vector<LocalizationError> MeasureLocalization(
    const std::vector<DetectedBoard>& boards, const ExperimentOptions& options);

/// The conditions of MeasureLocalization(), in words.
std::vector<Condition> LocalizationConditions(const ExperimentOptions& options);
/// The conditions of MeasureLocalization() on a line.
std::string LocalizationNote(const ExperimentOptions& options);

/// Columns of a table after the first ones, and their cells.
std::vector<std::string> LocalizationColumns(std::vector<std::string> first);
std::vector<Cell> LocalizationCells(std::vector<Cell> first,
                                    const LocalizationError& error);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_LOCALIZATION_ERROR_H
