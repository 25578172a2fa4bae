#ifndef RAYGRID_EVALUATION_VERDICT_H
#define RAYGRID_EVALUATION_VERDICT_H

#include <optional>
#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/camera_file.h"
#include "evaluation/budget_verdict.h"
#include "evaluation/fleet_distance.h"
#include "evaluation/fold_over.h"
#include "evaluation/uncertainty_summary.h"

namespace raygrid {

/// Another model, and the held-out errors of both, with rigid boards: other
/// figures of a model whose boards bend do not compare with these.
struct BetterModel {
  std::string model;
  double median_px = 0;
  double own_median_px = 0;  ///< of the model that was asked for
};

/// The images of two cameras that were taken for one's.
struct TwoCameras {
  std::vector<std::string> first, second;
};

/// An image that lost many of its features to outlier rejection.
struct MisreadImage {
  std::string image;
  int num_rejected = 0, num_features = 0;
};

/// The figures that a verdict is formed on.
struct CalibrationFigures {
  bool converged = false, interrupted = false;
  ImageSize image_size;
  Area features_area;  ///< the rectangle of the features
  int images_used = 0, images_rejected = 0;
  /// Images that are used or held out, and those that show the same views.
  int images_kept = 0, images_alike = 0;
  /// Images held out that show views which the camera was calibrated with.
  std::vector<std::string> held_out_copies;
  int images_with_too_few_features = 0;  ///< of those rejected
  ErrorFigures training;
  /// The held-out errors; their boards bend where those of training do.
  std::optional<ErrorFigures> held_out;
  bool boards_bend = false;
  /// Without images apart: of held-out errors, or of training errors if that
  /// is less; what a camera of few images errs by, only the former share.
  std::optional<double> neighbor_correlation;
  std::vector<std::string> images_apart;  ///< that err far more than others
  /// Images that err far more than others only where they are held out, since
  /// they alone show some places of the image, and these places.
  std::vector<std::string> images_alone, places_alone;
  std::vector<std::string> images_of_doubtful_turn;  ///< CalibrationResult's
  int num_misread_images = 0;
  MisreadImage most_misread;  ///< if there is one
  std::optional<TwoCameras> two_cameras;
  int boards_seen = 0, different_views = 0;
  /// The image of each time that a board is seen from behind.
  std::vector<std::string> images_from_behind;
  std::optional<double> tilt_rad;  ///< between two boards; of flat ones only
  /// The predicted uncertainty, median over the rectangle of the features; the
  /// share of the image that is valid, and the limit that makes it so.
  std::optional<double> median_deviation_px, valid_share, valid_limit_px;
  std::optional<ExtrapolatedRegion> extrapolated;
  FoldOver fold_over;
  /// How far from flat boards are that were taken for flat, RMS: where they may
  /// be, they surely are. 0 where nothing says so.
  double flat_board_height_m = 0;
  std::optional<FleetDistance> fleet_distance;
  /// The model that predicts held-out images best, of those that were tried and
  /// are better.
  std::optional<BetterModel> better_model;
  BudgetFacts tried;    ///< what needs no advice any more
  BudgetVerdict limit;  ///< by the residuals' causes; may be untold
  /// Why the times of images are none of their motion's; empty if they may be.
  std::string wrong_times;
  std::optional<double> pixel_aspect;  ///< width by height, in the middle
};

/// "pass": a careful engineer would accept the camera for its images; "warn":
/// not everywhere, or not without a look; "fail": no use. And why, with what to
/// do: the worst reason first. Reasons of a "pass" are worth knowing, no more.
struct Verdict {
  std::string word;
  std::vector<std::string> reasons;
  std::string failure = {};  ///< the first reason of a "fail"
};

/// Whether more of the errors than noise is shared by neighbours, and so much
/// that it matters.
bool ErrAlike(double neighbor_correlation, const ErrorFigures& errors);

double ShareOfImage(const Area& area, const ImageSize& size);

/// Pixels with two digits, or all before the point.
std::string RoundedPx(double px);

Verdict JudgeCalibration(const CalibrationFigures& figures);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_VERDICT_H
