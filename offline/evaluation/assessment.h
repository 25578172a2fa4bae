#ifndef RAYGRID_EVALUATION_ASSESSMENT_H
#define RAYGRID_EVALUATION_ASSESSMENT_H

#include <optional>
#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/camera_file.h"
#include "evaluation/budget_assessment.h"
#include "evaluation/fleet_distance.h"
#include "evaluation/fold_over.h"
#include "evaluation/uncertainty_summary.h"

namespace raygrid {

/// Another model, and the held-out errors of both models with rigid boards
/// (errors with per-view deformation are not comparable).
struct BetterModel {
  std::string model;
  double median_px = 0;
  double own_median_px = 0;  ///< error of the requested model
};

/// Images from two cameras that were assumed to be from one camera.
struct MixedCameras {
  std::vector<std::string> first, second;
};

/// Images whose pixel coordinates are transformed relative to the other images.
struct TransformedImages {
  enum class Kind {
    kRotated,  ///< by 180 degrees
    kScaled,
  };
  Kind kind = Kind::kRotated;
  double scale = 1;  ///< relative to the other images
  std::vector<std::string> images;
  size_t num_images = 0;  ///< all images
};

/// An image from which many features were removed as outliers.
struct MisreadImage {
  std::string image;
  int num_rejected = 0, num_features = 0;
};

/// The metrics from which the status is derived.
struct CalibrationMetrics {
  bool converged = false, interrupted = false;
  bool has_known_intrinsics = false;  ///< the camera itself is not assessed
  ImageSize image_size;
  Area features_area;  ///< bounding rectangle of the features
  int images_used = 0, images_rejected = 0;
  /// Images that are used or held out, and their near-duplicates.
  int images_kept = 0, num_duplicate_images = 0;
  /// Held-out images that are near-duplicates of calibration images.
  std::vector<std::string> held_out_duplicates;
  int images_with_too_few_features = 0;  ///< images with too few features,
                                         ///< among the rejected images
  ErrorMetrics training;
  /// The held-out errors; with per-view deformation if training has it.
  std::optional<ErrorMetrics> held_out;
  bool per_view_deformation = false;
  /// Correlation of held-out errors, or of training errors if smaller (model
  /// errors due to few images are only in the former); without outlier images.
  std::optional<double> neighbor_correlation;
  // Images with much larger errors than the others.
  std::vector<std::string> outlier_images;
  /// Images with large errors only when held out, because they alone cover some
  /// regions of the image, and these regions.
  std::vector<std::string> unique_coverage_images, unique_coverage_regions;
  std::vector<std::string>
      ambiguous_rotation_images;  ///< see CalibrationResult
  int num_misread_images = 0;
  MisreadImage most_misread;  ///< image with the most removed outliers, if any
  std::optional<MixedCameras> mixed_cameras;
  std::optional<TransformedImages> transformed_images;
  int boards_seen = 0, different_views = 0;
  /// One image for each rear view of a board.
  std::vector<std::string> mirrored_images;
  std::optional<double> tilt_rad;  ///< between two boards; only if planar
  /// Median predicted uncertainty over the bounding rectangle of the features;
  /// fraction of the image in the valid region, and its limit.
  std::optional<double> median_stddev_px, valid_share, valid_limit_px;
  std::optional<ExtrapolatedRegion> extrapolated;
  FoldOver fold_over;
  /// RMS deviation from planarity of boards assumed to be planar, if it is
  /// significant; otherwise 0.
  double flatness_error_m = 0;
  std::optional<FleetDistance> fleet_distance;
  /// The model with the smallest held-out error, if it is better than the
  /// chosen model.
  std::optional<BetterModel> better_model;
  BudgetSummary tried;     ///< models and options already tried
  BudgetAssessment limit;  ///< limiting cause of the residuals, if any
  /// Explains why timestamps contradict the motion; empty if they are
  /// consistent.
  std::string timestamp_error;
  std::optional<double> pixel_aspect;  ///< pixel width / height, image centre
};

/// Status: "pass": the camera is acceptable for the purpose of its images;
/// "warn": acceptable only in some regions or after inspection; "fail":
/// unusable. Reasons, with remedies, are sorted by severity; with "pass" they
/// are informative.
struct Assessment {
  std::string word;
  std::vector<std::string> reasons;
  std::string failure = {};  ///< the first reason of a "fail"
};

/// Returns whether correlated errors exceed the noise by a relevant amount.
bool HasCorrelatedErrors(double neighbor_correlation,
                         const ErrorMetrics& errors);

double ComputeImageShare(const Area& area, const ImageSize& size);

/// Formats pixels with two significant digits, or all integer digits.
std::string FormatPx(double px);

Assessment AssessCalibration(const CalibrationMetrics& metrics);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_ASSESSMENT_H
