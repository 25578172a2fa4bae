#ifndef RAYGRID_CALIBRATION_CROSS_VALIDATION_H
#define RAYGRID_CALIBRATION_CROSS_VALIDATION_H

#include <functional>
#include <string>
#include <vector>

#include "calibration/bodies.h"
#include "calibration/model_adjustment.h"
#include "dataset/dataset.h"
#include "evaluation/checkpoint.h"

namespace raygrid {

/// A camera's images to calibrate with, and those to test with.
struct Split {
  std::string camera;  ///< its name in a rig
  Dataset training, test;
};
Split SplitImages(const std::string& camera, const Dataset& dataset,
                  const std::vector<std::string>& test_images);

/// The part of the images that each camera is calibrated with.
constexpr double kCrossValidatingPart = 0.75;

/// The number of folds to try, of four: none for few images, one for many,
/// which take long and need no more.
int NumFoldsToTry(const std::vector<Split>& cameras);

struct ValidationOptions {
  std::string model;
  AreaChoice area = AreaChoice::kWholeImage;
  bool flat_board = false;
  bool rigid_boards = true;  ///< in calibrating
  Bodies bodies;
  int num_threads = 0;
  std::function<void(double)> progress;
  std::function<bool()> should_stop;
  /// Called when *done has grown, by one thread at a time.
  std::function<void()> on_done;
};

/// Candidates, the cells of each camera, in every fold of the training images,
/// in parallel: the images whose turn it is are localised with cameras
/// calibrated without them. Leaves out what is in *done already, and adds to
/// it; some is missing after a stop.
void CrossValidate(const std::vector<Split>& cameras, const Pattern& pattern,
                   const ValidationOptions& options,
                   const std::vector<std::vector<double>>& candidates,
                   std::vector<Trial>* done);

/// Tests adjusted cameras with their test images or, where no camera has any,
/// cells by cross-validation, with what is done of it.
HeldOut EvaluateHeldOut(const Adjusted& adjusted, const Pattern& pattern,
                        const std::vector<Split>& cameras,
                        const ValidationOptions& options,
                        const std::vector<double>& cells_px,
                        std::vector<Trial>* done);

/// The residuals over all folds of one candidate; nothing if a fold is missing.
HeldOut JoinFolds(const std::vector<Trial>& done, int num_folds,
                  const std::vector<double>& cells_px, bool rigid_boards,
                  bool has_bodies = false);

}  // namespace raygrid

#endif  // RAYGRID_CALIBRATION_CROSS_VALIDATION_H
