#include "evaluation/assessment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "evaluation/min_images.h"

namespace raygrid {
namespace {

constexpr int kMinViews = 3;
constexpr double kMinTiltRad = 5 * M_PI / 180;
constexpr double kMinAreaFraction = 0.5;  // fraction of the image
constexpr double kGoodMedianPx = 0.3;     // corners of a sharp chessboard
constexpr double kUsableMedianPx = 2;
constexpr double kOverfitRatio = 1.5;
// Larger systematic errors cause a warning, smaller ones a note.
constexpr double kWarningErrorPx = 0.15;
// Errors below this limit, or below a tenth of the noise, are not reported.
constexpr double kNegligiblePx = 0.02, kNegligibleFraction = 0.1;
// Median uncertainties that cause a warning and a failure, respectively.
constexpr double kWarningUncertaintyPx = 1, kFailureUncertaintyPx = 5;
// Fraction of images with wrong pixel coordinates that makes a camera unusable.
constexpr double kMaxMisorientedFraction = 0.25;
constexpr double kMaxAspect = 4;  // anamorphic lenses reach 2
// Fractions of the image: minimum valid, maximum extrapolated.
constexpr double kMinValidFraction = 0.5, kMaxExtrapolatedFraction = 0.05;
// Correlations of neighbouring residuals: significant at five standard errors
// for the minimum number of pairs, and dominant.
constexpr double kSignificantCorrelation = 0.25, kDominantCorrelation = 0.9;

// Severity of a finding.
enum class Severity { kNote, kWarning, kFailure };
struct Finding {
  Severity severity;
  std::string text;
};

class Findings {
 public:
  void Note(const std::string& text) { Add(Severity::kNote, text); }
  void Warn(const std::string& text) { Add(Severity::kWarning, text); }
  void Fail(const std::string& text) { Add(Severity::kFailure, text); }
  void Add(Severity severity, const std::string& text) {
    findings_.push_back({severity, text});
  }

  // Sorts the findings by severity, most serious first.
  Assessment MakeAssessment() const {
    Assessment assessment = {"pass", {}};
    for (const Severity severity :
         {Severity::kFailure, Severity::kWarning, Severity::kNote})
      for (const Finding& finding : findings_)
        if (finding.severity == severity)
          assessment.reasons.push_back(finding.text);
    if (Has(Severity::kFailure)) {
      assessment.word = "fail";
      assessment.failure = assessment.reasons.front();
    } else if (Has(Severity::kWarning)) {
      assessment.word = "warn";
    }
    return assessment;
  }

 private:
  bool Has(Severity severity) const {
    return std::any_of(
        findings_.begin(), findings_.end(),
        [&](const Finding& finding) { return finding.severity == severity; });
  }

  std::vector<Finding> findings_;
};

bool IsNegligible(double error_px, const ErrorMetrics& noise) {
  return error_px < std::max(kNegligiblePx, kNegligibleFraction * noise.rms_px);
}

// Names the first of several images.
std::string FormatFirstName(const std::vector<std::string>& images) {
  return images.front() + (images.size() > 1 ? ", ..." : "");
}

// Formats images as "3 images (a.png, ...)".
std::string FormatCountAndNames(const std::vector<std::string>& images) {
  return fmt::format("{} image{} ({})", images.size(),
                     images.size() == 1 ? "" : "s", FormatFirstName(images));
}

void AssessConvergence(const CalibrationMetrics& metrics, Findings* findings) {
  if (metrics.interrupted)
    findings->Fail("interrupted before completion; continue with --resume");
  else if (!metrics.converged)
    findings->Fail(
        "bundle adjustment did not converge; add images, or remove blurred "
        "ones");
}

// Uncompensated rolling-shutter motion biases the camera.
void AssessTimestamps(const CalibrationMetrics& metrics, Findings* findings) {
  if (!metrics.timestamp_error.empty())
    findings->Fail("the line delay is not observable: " +
                   metrics.timestamp_error);
}

void AssessNumberOfImages(const CalibrationMetrics& metrics,
                          Findings* findings) {
  if (metrics.images_used < kMinReliableImages)
    findings->Warn(fmt::format(
        "only {} {}, too few to assess the camera; at least {} are required",
        metrics.images_used,
        metrics.num_duplicate_images > 0 ? "different views" : "images",
        kMinReliableImages));
  if (metrics.num_duplicate_images > 0)
    findings->Note(fmt::format(
        "{} images show {} different views; near-duplicates are counted once",
        metrics.images_kept + metrics.num_duplicate_images,
        metrics.images_kept));
}

void AssessImageSize(const CalibrationMetrics& metrics, Findings* findings) {
  // Pixel coordinates start at the top left corner, so features detected in
  // smaller images cover only that region of a larger image.
  constexpr double kHalf = 0.55;
  const Area& area = metrics.features_area;
  const ImageSize& size = metrics.image_size;
  if (area.x1 < kHalf * size.width && area.y1 < kHalf * size.height)
    findings->Warn(fmt::format(
        "all features lie in the top left quarter of the {} x {} image, up to "
        "({:.0f}, {:.0f}); check --image-size, or move the target into the "
        "other corners",
        size.width, size.height, area.x1, area.y1));
}

void AssessViews(const CalibrationMetrics& metrics, Findings* findings) {
  if (metrics.different_views < kMinViews)
    findings->Fail(fmt::format(
        "{} images show only {} different {} of the target; move and tilt it "
        "between images",
        metrics.images_used + metrics.num_duplicate_images,
        metrics.different_views,
        metrics.different_views == 1 ? "view" : "views"));
  else if (metrics.tilt_rad && *metrics.tilt_rad < kMinTiltRad)
    findings->Fail(
        fmt::format("the focal length is not observable: the target has the "
                    "same orientation in all images, within {:.1f} degrees; "
                    "tilt it by 30 degrees or more, in different directions",
                    *metrics.tilt_rad * 180 / M_PI));
}

// If all views show the back of the board, the order of the features is
// mirrored relative to the pattern. Many such views among others bias the
// camera, which cannot fit both.
void AssessSides(const CalibrationMetrics& metrics, Findings* findings) {
  if (metrics.mirrored_images.empty()) return;
  const size_t count = metrics.mirrored_images.size();
  const auto boards_seen = static_cast<size_t>(metrics.boards_seen);
  const std::string text = fmt::format(
      "the target is seen from behind in {} of {} views ({}): the "
      "images are mirrored, or the row or column order of the "
      "pattern or the features is reversed",
      count, metrics.boards_seen, FormatFirstName(metrics.mirrored_images));
  if (count < boards_seen &&
      static_cast<double>(count) >=
          kMaxMisorientedFraction * static_cast<double>(boards_seen))
    findings->Fail(text);
  else
    findings->Warn(text);
}

std::string DescribeTransform(const TransformedImages& found) {
  if (found.kind == TransformedImages::Kind::kRotated)
    return "rotated by 180 degrees";
  return fmt::format("scaled by {:.2g} (another resolution)", found.scale);
}

// Transformed images bias the camera, as views from behind do.
void AssessTransformedImages(const CalibrationMetrics& metrics,
                             Findings* findings) {
  if (!metrics.transformed_images) return;
  const TransformedImages& found = *metrics.transformed_images;
  const size_t count = found.images.size();
  const bool are_many =
      static_cast<double>(count) >=
      kMaxMisorientedFraction * static_cast<double>(found.num_images);
  findings->Add(
      are_many ? Severity::kFailure : Severity::kWarning,
      fmt::format("{} of {} images ({}) {} {} relative to the "
                  "others; undo this in the image files, or "
                  "calibrate without {}",
                  count, found.num_images, FormatFirstName(found.images),
                  count == 1 ? "is" : "are", DescribeTransform(found),
                  count == 1 ? "it" : "them"));
}

void AssessRejectedImages(const CalibrationMetrics& metrics,
                          Findings* findings) {
  const int fit = metrics.images_used + metrics.num_duplicate_images;
  const int images = fit + metrics.images_rejected;
  if (2 * metrics.images_with_too_few_features > images)
    findings->Warn(
        fmt::format("{} of {} images have too few features; check the "
                    "pattern's columns and rows",
                    metrics.images_with_too_few_features, images));
  else if (metrics.images_rejected > fit)
    findings->Warn(
        fmt::format("{} of {} images were rejected; check the listed reasons",
                    metrics.images_rejected, images));
  else if (metrics.images_rejected > fit / 5)
    findings->Note(
        fmt::format("{} of {} images were rejected; check the listed reasons",
                    metrics.images_rejected, images));
}

void AssessOutlyingImages(const CalibrationMetrics& metrics,
                          Findings* findings) {
  if (metrics.mixed_cameras) {
    findings->Warn(fmt::format(
        "these images appear to come from two cameras, or from one whose focus "
        "changed: {} and {}; calibrate each group separately",
        FormatCountAndNames(metrics.mixed_cameras->first),
        FormatCountAndNames(metrics.mixed_cameras->second)));
    return;
  }
  if (metrics.outlier_images.empty()) return;
  findings->Warn(
      fmt::format("{} {} inconsistent with the others (another camera, focus "
                  "or target, or wrong features); calibrate without {}",
                  FormatCountAndNames(metrics.outlier_images),
                  metrics.outlier_images.size() == 1 ? "is" : "are",
                  metrics.outlier_images.size() == 1 ? "it" : "them"));
}

// Images with large held-out errors but normal training errors: without them,
// the camera is extrapolated in their region.
void AssessInfluentialImages(const CalibrationMetrics& metrics,
                             Findings* findings) {
  if (metrics.unique_coverage_images.empty()) return;
  findings->Warn(fmt::format(
      "the {} of the image is covered by {} only, so the camera cannot be "
      "verified there; keep {}, and add more views of this part",
      fmt::join(metrics.unique_coverage_regions, ", "),
      FormatCountAndNames(metrics.unique_coverage_images),
      metrics.unique_coverage_images.size() == 1 ? "it" : "them"));
}

// Images with more outliers than expected by chance or from a few corners at
// the edge of the target, although their remaining features fit.
void AssessMisreadImages(const CalibrationMetrics& metrics,
                         Findings* findings) {
  if (metrics.num_misread_images == 0) return;
  const MisreadImage& worst = metrics.most_misread;
  const bool is_one = metrics.num_misread_images == 1;
  findings->Warn(fmt::format(
      "many features of {} were rejected as outliers ({}: {} of {}): target "
      "columns or rows were misidentified, or corners are wrong; detect {} "
      "again, or calibrate without {}",
      is_one ? "an image"
             : fmt::format("{} images", metrics.num_misread_images),
      worst.image, worst.num_rejected, worst.num_features,
      is_one ? "that image" : "these images", is_one ? "it" : "them"));
}

void AssessAmbiguousRotations(const CalibrationMetrics& metrics,
                              Findings* findings) {
  if (metrics.ambiguous_rotation_images.empty()) return;
  findings->Warn(
      fmt::format("the orientation of the symmetric target is ambiguous in {}: "
                  "printing errors may be attributed to the lens; omit these "
                  "images, or print a target with one more row of squares",
                  FormatCountAndNames(metrics.ambiguous_rotation_images)));
}

void AssessFlatTarget(const CalibrationMetrics& metrics, Findings* findings) {
  if (metrics.flatness_error_m > 0)
    findings->Warn(
        fmt::format("the target's deformation biases the {}: the estimated "
                    "out-of-plane deformation of a board is {:.3f} mm RMS; "
                    "calibrate without --fix-target-geometry",
                    metrics.has_known_intrinsics ? "poses" : "camera",
                    1e3 * metrics.flatness_error_m));
}

void AssessPopulationDistance(const CalibrationMetrics& metrics,
                              Findings* findings) {
  const auto& distance = metrics.fleet_distance;
  if (distance && distance->IsOutlier()) findings->Warn(distance->Warning());
}

// Returns a sentence such as "the corners of the image are extrapolated: expect
// errors up to 0.7 px there".
std::string FormatExtrapolation(const ExtrapolatedRegion& region) {
  const bool is_plural =
      region.image_regions.back() == 's' ||
      region.image_regions.find(" and ") != std::string::npos;
  constexpr double kManyPx = 10;
  return fmt::format(
      "the {} of the image {} extrapolated: expect errors {} px there",
      region.image_regions, is_plural ? "are" : "is",
      region.p95_px > kManyPx ? "of more than 10"
                              : "up to " + FormatPx(region.p95_px));
}

void AssessExtrapolation(const CalibrationMetrics& metrics,
                         Findings* findings) {
  const double covered =
      ComputeImageShare(metrics.features_area, metrics.image_size);
  const auto& region = metrics.extrapolated;
  const bool is_large = region && metrics.valid_limit_px &&
                        region->p95_px > *metrics.valid_limit_px;
  if (is_large && region->share > kMaxExtrapolatedFraction)
    findings->Warn(
        fmt::format("{} ({:.0f} % of the image); move the target into that "
                    "part, or use the valid region only",
                    FormatExtrapolation(*region), 100 * region->share));
  else if (covered < kMinAreaFraction)
    findings->Warn(fmt::format(
        "features cover only {:.0f} % of the image, and the remainder is "
        "extrapolated; move the target into the corners",
        100 * covered));
  else if (is_large && region->share > 0)
    findings->Note(FormatExtrapolation(*region));
}

void AssessUncertainty(const CalibrationMetrics& metrics, Findings* findings) {
  if (!metrics.median_stddev_px) {
    findings->Warn(
        "the camera parameters are not fully observable; add images with the "
        "target tilted in different directions");
    return;
  }
  const double median_px = *metrics.median_stddev_px;
  if (median_px > kWarningUncertaintyPx) {
    findings->Add(
        median_px > kFailureUncertaintyPx ? Severity::kFailure
                                          : Severity::kWarning,
        fmt::format(
            "the views constrain the camera too weakly: expect errors of {} px "
            "in half of the image; tilt the target by 30 degrees or more, in "
            "different directions, and vary the distance",
            FormatPx(median_px)));
    return;
  }
  AssessExtrapolation(metrics, findings);
  if (*metrics.valid_share < kMinValidFraction &&
      !IsNegligible(median_px, metrics.training))
    findings->Warn(fmt::format(
        "only {:.0f} % of the image is supported by features and has a "
        "predicted uncertainty below {} px (see uncertainty.png); add views "
        "near and far, tilted in different directions, and in the corners",
        100 * *metrics.valid_share, FormatPx(*metrics.valid_limit_px)));
}

void AssessPixelAspect(const CalibrationMetrics& metrics, Findings* findings) {
  const double aspect = metrics.pixel_aspect.value_or(1);
  if (aspect > 1 / kMaxAspect && aspect < kMaxAspect) return;
  findings->Fail(
      fmt::format("the estimated pixel aspect ratio (width/height) is {:.2g}, "
                  "which is implausible; check the image size and the pattern",
                  aspect));
}

// Image corners outside a fisheye's image circle also fold in good
// calibrations.
void AssessFoldOver(const CalibrationMetrics& metrics, Findings* findings) {
  const FoldOver& fold_over = metrics.fold_over;
  if (fold_over.valid_fraction > 0)
    findings->Fail(fmt::format(
        "the model is not injective within the valid region ({:.2g} % of the "
        "calibrated area): two pixels have the same ray; remove "
        "misidentified features, or increase --knot-spacing-px",
        100 * fold_over.valid_fraction));
  else if (fold_over.part > 0)
    findings->Note(
        fmt::format("the model is not injective outside the valid region "
                    "({:.2g} % of the calibrated area), for example outside a "
                    "fisheye's image circle; use the valid region only",
                    100 * fold_over.part));
}

void AssessOtherModels(const CalibrationMetrics& metrics, Findings* findings) {
  if (!metrics.better_model) return;
  const BetterModel& better = *metrics.better_model;
  findings->Note(
      fmt::format("{} has a lower held-out error: median {:.4f} px{}, compared "
                  "with {:.4f} px; calibrate with --model {}",
                  better.model, better.median_px,
                  metrics.per_view_deformation ? ", rigid target" : "",
                  better.own_median_px, better.model));
}

bool HasCorrelatedResiduals(const CalibrationMetrics& metrics) {
  return !metrics.mixed_cameras && !metrics.transformed_images &&
         HasCorrelatedErrors(
             metrics.neighbor_correlation.value_or(0),
             metrics.held_out ? *metrics.held_out : metrics.training);
}

// Identified causes take precedence over hypotheses.
void AssessCorrelation(const CalibrationMetrics& metrics, Findings* findings) {
  if (!HasCorrelatedResiduals(metrics)) return;
  const double correlation = *metrics.neighbor_correlation;
  const ErrorMetrics& errors =
      metrics.held_out ? *metrics.held_out : metrics.training;
  const double systematic_px = errors.rms_px * std::sqrt(correlation);
  const std::string found = fmt::format(
      "systematic errors of about {} px (neighbouring residuals "
      "are correlated: {:.2f})",
      FormatPx(systematic_px), correlation);
  const Severity severity =
      systematic_px > kWarningErrorPx ? Severity::kWarning : Severity::kNote;
  if (metrics.has_known_intrinsics)
    findings->Add(severity,
                  fmt::format("{}, caused by known intrinsics that do not fit "
                              "these images (another focus, temperature or "
                              "camera), by the target or by the detector; "
                              "compare with a calibration without --intrinsics",
                              found));
  else if (metrics.limit.IsCause())
    findings->Add(severity,
                  fmt::format("{}: {}; {}", found, metrics.limit.sentence,
                              metrics.limit.advice));
  else
    findings->Add(
        severity,
        fmt::format("{}, caused by the model or the detector{}; {}", found,
                    correlation > kDominantCorrelation
                        ? ", or by images of several cameras"
                        : "",
                    AdviseOnCorrelatedErrors(metrics.tried)));
}

// Names the cause and the remedy, unless AssessCorrelation() reported them.
std::string AdviseOnError(const CalibrationMetrics& metrics) {
  if (metrics.has_known_intrinsics)
    return "; check that the known intrinsics belong to this camera and its "
           "focus, and use sharp images";
  if (!metrics.limit.IsDetermined())
    return "; use sharper images or a flatter target";
  if (HasCorrelatedResiduals(metrics) && metrics.limit.limit != "noise")
    return "; the remedy for systematic errors reduces it, too";
  return fmt::format(": {}; {}", metrics.limit.sentence, metrics.limit.advice);
}

void AssessHeldOutError(const CalibrationMetrics& metrics, Findings* findings) {
  if (!metrics.held_out) {
    findings->Warn("no held-out error: too few images to hold any out");
    return;
  }
  const double held_out_px = metrics.held_out->median_px;
  if (held_out_px > kUsableMedianPx)
    findings->Fail(
        fmt::format("the median held-out error of {} px is too large{}",
                    FormatPx(held_out_px), AdviseOnError(metrics)));
  else if (held_out_px > kGoodMedianPx)
    findings->Warn(fmt::format("the median held-out error is {} px{}",
                               FormatPx(held_out_px), AdviseOnError(metrics)));
}

void AssessHeldOutCopies(const CalibrationMetrics& metrics,
                         Findings* findings) {
  const auto& copies = metrics.held_out_duplicates;
  if (copies.empty()) return;
  findings->Warn(
      fmt::format("the held-out error is too optimistic, because the held-out "
                  "images include near-duplicates of training images: {}; hold "
                  "out all near-duplicates of an image together",
                  FormatCountAndNames(copies)));
}

void AssessOverfit(const CalibrationMetrics& metrics, Findings* findings) {
  if (!metrics.held_out) return;
  const double held_out_px = metrics.held_out->median_px;
  const double training_px = metrics.training.median_px;
  if (held_out_px <= kOverfitRatio * training_px ||
      IsNegligible(held_out_px - training_px, metrics.training))
    return;
  findings->Add(held_out_px - training_px > kWarningErrorPx ? Severity::kWarning
                                                            : Severity::kNote,
                fmt::format("too few images: the held-out error is {} px, the "
                            "training error {} px; add images",
                            FormatPx(held_out_px), FormatPx(training_px)));
}

}  // namespace

std::string FormatPx(double px) {
  return px < 99.5 ? fmt::format("{:.2g}", px) : fmt::format("{:.0f}", px);
}

bool HasCorrelatedErrors(double neighbor_correlation,
                         const ErrorMetrics& errors) {
  return neighbor_correlation > kSignificantCorrelation &&
         errors.rms_px * std::sqrt(neighbor_correlation) >= kNegligiblePx;
}

double ComputeImageShare(const Area& area, const ImageSize& size) {
  return area.width() * area.height() /
         (static_cast<double>(size.width) * size.height);
}

namespace {

// Assesses poses and errors, but not the camera.
Assessment AssessKnownCamera(const CalibrationMetrics& metrics) {
  Findings findings;
  for (const auto assess : {AssessTransformedImages, AssessConvergence,
                            AssessSides, AssessRejectedImages})
    assess(metrics, &findings);
  if (metrics.interrupted) return findings.MakeAssessment();
  for (const auto assess :
       {AssessTimestamps, AssessOutlyingImages, AssessAmbiguousRotations,
        AssessFlatTarget, AssessCorrelation, AssessHeldOutError,
        AssessHeldOutCopies, AssessOverfit, AssessMisreadImages})
    assess(metrics, &findings);
  return findings.MakeAssessment();
}

}  // namespace

Assessment AssessCalibration(const CalibrationMetrics& metrics) {
  if (metrics.has_known_intrinsics) return AssessKnownCamera(metrics);
  Findings findings;
  for (const auto assess :
       {AssessTransformedImages, AssessConvergence, AssessNumberOfImages,
        AssessImageSize, AssessViews, AssessSides, AssessRejectedImages})
    assess(metrics, &findings);
  // Error metrics of an interrupted calibration are meaningless.
  if (metrics.interrupted) return findings.MakeAssessment();
  for (const auto assess :
       {AssessTimestamps, AssessOutlyingImages, AssessInfluentialImages,
        AssessAmbiguousRotations, AssessFlatTarget, AssessPopulationDistance,
        AssessUncertainty, AssessFoldOver, AssessPixelAspect, AssessCorrelation,
        AssessHeldOutError, AssessHeldOutCopies, AssessOverfit,
        AssessMisreadImages, AssessOtherModels})
    assess(metrics, &findings);
  return findings.MakeAssessment();
}

}  // namespace raygrid
