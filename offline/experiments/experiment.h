/// Experiments on simulated truth, as in the paper: each has a name, and gives
/// a table and a chart of it. A new one is a function and a line in
/// Experiments().
#ifndef RAYGRID_EXPERIMENTS_EXPERIMENT_H
#define RAYGRID_EXPERIMENTS_EXPERIMENT_H

#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "camera/area.h"
#include "experiments/chart.h"

namespace raygrid {

/// What all experiments are asked for.
struct ExperimentOptions {
  int num_images = 24;
  ImageSize size = {640, 480};
  double blur_px = 0.7;   ///< of the lens, standard deviation
  double read_noise = 2;  ///< standard deviation, grey levels
  uint64_t seed = 0;
  int num_threads = 0;                   ///< 0 means all cores
  std::function<void(double)> progress;  ///< from 0 to 1, if any
};

struct Condition {
  std::string name, value;
};

using Cell = std::variant<std::string, int, double>;

struct ExperimentResult {
  std::vector<Condition> conditions;  ///< under which it was done
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;
  Chart chart;
};

struct Experiment {
  std::string name, summary;
  ExperimentResult (*run)(const ExperimentOptions&);
};

const std::vector<Experiment>& Experiments();

/// The error of the localisation against the number of star segments (paper,
/// "Calibration Pattern Evaluation"; there by reprojection errors).
ExperimentResult ComparePatternSegments(const ExperimentOptions& options);

/// The error that each refinement leaves (paper, "Feature Refinement
/// Evaluation"; there by reprojection errors).
ExperimentResult CompareFeatureRefinements(const ExperimentOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_EXPERIMENTS_EXPERIMENT_H
