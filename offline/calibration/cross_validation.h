#ifndef RAYGRID_CALIBRATION_CROSS_VALIDATION_H
#define RAYGRID_CALIBRATION_CROSS_VALIDATION_H

#include <functional>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "evaluation/calibration_result.h"

namespace raygrid {

/// Images to calibrate with, and those to test with.
struct Split {
  Dataset training, test;
};
Split SplitImages(const Dataset& dataset,
                  const std::function<bool(size_t)>& is_test);
Split SplitImages(const Dataset& dataset,
                  const std::vector<std::string>& test_images);

/// The part of the images that each camera is calibrated with.
constexpr double kCrossValidatingPart = 0.75;

/// The number of folds to try, of four: none for few images, one for many,
/// which take long and need no more.
int NumFoldsToTry(const Dataset& dataset);

/// Cells as parts of the longer side: coarse enough for a handful of images,
/// and as fine as is quick.
std::vector<double> CellCandidates(const Dataset& dataset,
                                   const std::string& model);

struct ValidationOptions {
  std::string model;
  bool flat_board = false;
  int num_threads = 0;
  std::function<void(double)> progress;
  std::function<bool()> should_stop;
  /// Called when *done has grown, by one thread at a time.
  std::function<void()> on_done;
};

/// A grid resolution and the held-out residuals over all folds.
struct Trial {
  double cell_px = 0;
  std::vector<FeatureResidual> held_out;
};

/// Every resolution in every fold, in parallel: the images whose turn it is are
/// localised with a camera calibrated without them. Leaves out what is in *done
/// already, and adds to it; some is missing after a stop.
void CrossValidate(const Dataset& dataset, const Pattern& pattern,
                   const ValidationOptions& options,
                   const std::vector<double>& cells,
                   std::vector<Checkpoint::Trial>* done);

/// A trial for each resolution; nothing if some fold of one is missing.
std::vector<Trial> JoinFolds(const std::vector<Checkpoint::Trial>& done,
                             int num_folds, const std::vector<double>& cells);

CellCandidate Summarize(const Trial& trial);

/// The coarsest that is as good as the best, nearly.
size_t ChooseCandidate(const std::vector<CellCandidate>& candidates);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CROSS_VALIDATION_H
