#include "evaluation/verdict.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "evaluation/enough_images.h"

namespace raygrid {
namespace {

constexpr int kEnoughViews = 3;
constexpr double kEnoughTiltRad = 5 * M_PI / 180;
constexpr double kEnoughArea = 0.5;    // part of the image
constexpr double kGoodMedianPx = 0.3;  // corners of a sharp chessboard
constexpr double kUsableMedianPx = 2;
constexpr double kOverfitRatio = 1.5;
// Nothing is said of less than this, nor of a tenth of the noise.
constexpr double kNegligiblePx = 0.02, kNegligiblePart = 0.1;
// The error that views may leave open in a camera: with a warning, and at all.
constexpr double kOpenPx = 1, kLostPx = 5;
constexpr double kMaxAspect = 4;        // anamorphic lenses have 2
constexpr double kEnoughTrusted = 0.5;  // part of the calibrated area
// The systematic part of the squared residuals that is too much; five standard
// errors where there are fewest pairs.
constexpr double kSystematicPart = 0.25;
constexpr double kStrangePart = 0.9;

void Remark(const std::string& reason, Verdict* verdict) {
  verdict->reasons.push_back(reason);
}

void Warn(const std::string& reason, Verdict* verdict) {
  if (verdict->word == "pass") verdict->word = "warn";
  verdict->reasons.push_back(reason);
}

void Fail(const std::string& reason, Verdict* verdict) {
  if (verdict->word != "fail") verdict->failure = reason;
  verdict->word = "fail";
  verdict->reasons.push_back(reason);
}

bool IsNegligible(double error_px, const ErrorFigures& noise) {
  return error_px < std::max(kNegligiblePx, kNegligiblePart * noise.rms_px);
}

// The first of several images.
std::string Named(const std::vector<std::string>& images) {
  return images.front() + (images.size() > 1 ? ", ..." : "");
}

void JudgeConvergence(const CalibrationFigures& figures, Verdict* verdict) {
  if (figures.interrupted)
    Fail("interrupted before it was done; go on with --resume", verdict);
  else if (!figures.converged)
    Fail("the adjustment did not converge; add images or remove blurred ones",
         verdict);
}

// Rows that moved bend the camera, and nothing could be done about it.
void JudgeTimes(const CalibrationFigures& figures, Verdict* verdict) {
  if (!figures.wrong_times.empty())
    Fail("the time of a row is not observable: " + figures.wrong_times,
         verdict);
}

void JudgeNumberOfImages(const CalibrationFigures& figures, Verdict* verdict) {
  if (figures.images_used < kEnoughImages)
    Warn(fmt::format("only {} {}; take {} or more", figures.images_used,
                     figures.images_alike > 0 ? "different views" : "images",
                     kEnoughImages),
         verdict);
  if (figures.images_alike > 0)
    Remark(fmt::format("{} images show {} different views, each of which "
                       "counts once",
                       figures.images_kept + figures.images_alike,
                       figures.images_kept),
           verdict);
}

void JudgeArea(const CalibrationFigures& figures, Verdict* verdict) {
  // Positions count from the upper left corner: there lies what was measured in
  // smaller images.
  constexpr double kHalf = 0.55;
  const Area& area = figures.features_area;
  const ImageSize& size = figures.image_size;
  const double part = PartOfImage(area, size);
  if (area.x1 < kHalf * size.width && area.y1 < kHalf * size.height)
    Warn(fmt::format("all features lie in the upper left quarter of the {} x "
                     "{} image, up to ({:.0f}, {:.0f}); check --image-size, or "
                     "hold the board into the other corners",
                     size.width, size.height, area.x1, area.y1),
         verdict);
  else if (part < kEnoughArea)
    Warn(fmt::format("features reach only {:.0f} % of the image; hold the "
                     "board into the corners",
                     100 * part),
         verdict);
}

void JudgeViews(const CalibrationFigures& figures, Verdict* verdict) {
  if (figures.different_views < kEnoughViews)
    Fail(fmt::format("the board is seen in only {} different ways in {} "
                     "images; move it and tilt it between them",
                     figures.different_views,
                     figures.images_used + figures.images_alike),
         verdict);
  else if (figures.tilt_rad && *figures.tilt_rad < kEnoughTiltRad)
    Fail(fmt::format(
             "all boards are parallel to within {:.1f} degrees, which leaves "
             "the focal length open; tilt them by 30 degrees or more, each "
             "time another way",
             *figures.tilt_rad * 180 / M_PI),
         verdict);
}

void JudgeSides(const CalibrationFigures& figures, Verdict* verdict) {
  if (figures.images_from_behind.empty()) return;
  Warn(fmt::format(
           "{} of {} times the board is seen from behind ({}): its columns or "
           "rows are counted the other way round in pattern or features, or "
           "the images are mirrored",
           figures.images_from_behind.size(), figures.boards_seen,
           Named(figures.images_from_behind)),
       verdict);
}

std::string Counted(const std::vector<std::string>& images) {
  return fmt::format("{} images ({})", images.size(), Named(images));
}

void JudgeImagesApart(const CalibrationFigures& figures, Verdict* verdict) {
  if (figures.two_cameras) {
    Warn(fmt::format("these images look like two cameras: {} and {}, or one "
                     "whose focus changed; calibrate each alone",
                     Counted(figures.two_cameras->first),
                     Counted(figures.two_cameras->second)),
         verdict);
    return;
  }
  if (figures.images_apart.empty()) return;
  Warn(fmt::format("{} images do not fit the others ({}): another camera, "
                   "focus or board, or misread features; calibrate without "
                   "them",
                   figures.images_apart.size(), Named(figures.images_apart)),
       verdict);
}

// Large errors of images held out, with errors as all others have in training,
// are those of a camera that extrapolates.
void JudgeImagesAlone(const CalibrationFigures& figures, Verdict* verdict) {
  if (figures.images_alone.empty()) return;
  Warn(fmt::format("only {} show the {} of the image, where the camera is "
                   "extrapolated without them; keep them, and take more views "
                   "there",
                   Counted(figures.images_alone),
                   fmt::join(figures.places_alone, ", ")),
       verdict);
}

void JudgeTurns(const CalibrationFigures& figures, Verdict* verdict) {
  if (figures.images_of_doubtful_turn.empty()) return;
  Warn(
      fmt::format("the board looks alike after a turn, and {} do not "
                  "determine which way it is turned there: errors of the print "
                  "may be attributed to the lens; leave them out, or print one "
                  "row of squares more",
                  Counted(figures.images_of_doubtful_turn)),
      verdict);
}

void JudgeFlatBoard(const CalibrationFigures& figures, Verdict* verdict) {
  if (figures.flat_board_height_m > 0)
    Warn(fmt::format(
             "--fix-target-geometry is believed, but a board is {:.3f} mm from "
             "flat (RMS) where it may be, and bends the camera "
             "instead; calibrate without --fix-target-geometry",
             1e3 * figures.flat_board_height_m),
         verdict);
}

void JudgeFleetDistance(const CalibrationFigures& figures, Verdict* verdict) {
  const auto& distance = figures.fleet_distance;
  if (distance && distance->IsStranger()) Warn(distance->Warning(), verdict);
}

void JudgeUncertainty(const CalibrationFigures& figures, Verdict* verdict) {
  if (!figures.median_deviation_px) {
    Warn(
        "the images do not tell how well the camera is known; take more, "
        "tilted all ways",
        verdict);
    return;
  }
  const double median_px = *figures.median_deviation_px;
  if (median_px > kOpenPx) {
    const std::string reason = fmt::format(
        "the views leave the camera open by {:.2g} px: tilt the board by 30 "
        "degrees or more, each time another way, and change the distance",
        median_px);
    if (median_px > kLostPx)
      Fail(reason, verdict);
    else
      Warn(reason, verdict);
  } else if (*figures.trusted_part <
                 kEnoughTrusted *
                     PartOfImage(figures.features_area, figures.image_size) &&
             !IsNegligible(median_px, figures.training)) {
    Warn(fmt::format(
             "only {:.0f} % of the image is trusted, known to {:.4f} px: "
             "uncertainty.png shows where; take more views, tilted all ways, "
             "near and far, into the corners",
             100 * *figures.trusted_part, *figures.trusted_px),
         verdict);
  }
}

void JudgePixels(const CalibrationFigures& figures, Verdict* verdict) {
  const double aspect = figures.pixel_aspect.value_or(1);
  if (aspect > 1 / kMaxAspect && aspect < kMaxAspect) return;
  Fail(fmt::format("pixels are {:.2g} times as wide as high, which no camera's "
                   "are; check the images' size and the pattern",
                   aspect),
       verdict);
}

// Corners beyond a fisheye's image circle fold over in good calibrations too.
void JudgeFoldOver(const CalibrationFigures& figures, Verdict* verdict) {
  const FoldOver& fold_over = figures.fold_over;
  if (fold_over.trusted_part > 0)
    Fail(fmt::format("{:.2g} % of the calibrated area folds over where it is "
                     "trusted: two pixels look along one ray; remove misread "
                     "features, or try larger cells",
                     100 * fold_over.trusted_part),
         verdict);
  else if (fold_over.part > 0)
    Remark(fmt::format("{:.2g} % of the calibrated area folds over, none of it "
                       "trusted, as beyond a fisheye's image circle: use "
                       "trusted pixels only",
                       100 * fold_over.part),
           verdict);
}

void JudgeRejectedImages(const CalibrationFigures& figures, Verdict* verdict) {
  const int fit = figures.images_used + figures.images_alike;
  const int images = fit + figures.images_rejected;
  if (2 * figures.images_with_too_few_features > images)
    Warn(fmt::format("{} of {} images have too few features; check the "
                     "pattern's columns and rows",
                     figures.images_with_too_few_features, images),
         verdict);
  else if (figures.images_rejected > fit / 5)
    Warn(fmt::format("{} images were rejected; see which and why",
                     figures.images_rejected),
         verdict);
}

void JudgeOtherModels(const CalibrationFigures& figures, Verdict* verdict) {
  if (!figures.better_model) return;
  const BetterModel& better = *figures.better_model;
  Remark(fmt::format("{} predicts held-out images better, with {:.4f} px "
                     "(median{}) against {:.4f} px: raygrid calibrate ... "
                     "--model {}",
                     better.model, better.median_px,
                     figures.boards_bend ? ", rigid boards" : "",
                     better.own_median_px, better.model),
         verdict);
}

bool WarnsOfNeighbors(const CalibrationFigures& figures) {
  return !figures.two_cameras &&
         ErrAlike(figures.neighbor_correlation.value_or(0),
                  figures.held_out ? *figures.held_out : figures.training);
}

// The cause that residuals tell comes before what one could guess.
void JudgeNeighbors(const CalibrationFigures& figures, Verdict* verdict) {
  if (!WarnsOfNeighbors(figures)) return;
  const double correlation = *figures.neighbor_correlation;
  const ErrorFigures& errors =
      figures.held_out ? *figures.held_out : figures.training;
  const std::string found = fmt::format(
      "neighbouring features err alike (correlation {:.2f}): about {:.2f} px "
      "are not noise",
      correlation, errors.rms_px * std::sqrt(correlation));
  if (figures.limit.IsCause())
    Warn(fmt::format("{}; {}; {}", found, figures.limit.sentence,
                     figures.limit.advice),
         verdict);
  else
    Warn(fmt::format(
             "{}, but the model's error or the detector's{}; {}", found,
             correlation > kStrangePart ? ", or images of several cameras" : "",
             AdviceAgainstSharedErrors(figures.tried)),
         verdict);
}

// The cause, and what would help, unless the neighbours' warning has it.
std::string AdviceAgainstError(const CalibrationFigures& figures) {
  if (!figures.limit.IsTold())
    return "; sharper images or a flatter board would lower it";
  if (WarnsOfNeighbors(figures) && figures.limit.limit != "noise")
    return "; the same would lower it";
  return fmt::format("; {}; {}", figures.limit.sentence, figures.limit.advice);
}

void JudgeHeldOutError(const CalibrationFigures& figures, Verdict* verdict) {
  if (!figures.held_out) {
    Warn("no held-out error: too few images to hold some out", verdict);
    return;
  }
  const double held_out = figures.held_out->median_px;
  if (held_out > kUsableMedianPx)
    Fail(fmt::format("the held-out error is {:.2f} px", held_out), verdict);
  else if (held_out > kGoodMedianPx)
    Warn(fmt::format("the held-out error is {:.2f} px{}", held_out,
                     AdviceAgainstError(figures)),
         verdict);
}

void JudgeHeldOutCopies(const CalibrationFigures& figures, Verdict* verdict) {
  const auto& copies = figures.held_out_copies;
  if (copies.empty()) return;
  Warn(fmt::format("images held out show views that the camera was calibrated "
                   "with ({}: {}), so the held-out error is too small; hold "
                   "out all images of a view",
                   copies.size(), Named(copies)),
       verdict);
}

void JudgeOverfit(const CalibrationFigures& figures, Verdict* verdict) {
  if (!figures.held_out) return;
  const double held_out = figures.held_out->median_px;
  const double training = figures.training.median_px;
  if (held_out > kOverfitRatio * training &&
      !IsNegligible(held_out - training, figures.training))
    Warn(fmt::format("the held-out error is {:.2g} px, the training error "
                     "{:.2g} px; take more images",
                     held_out, training),
         verdict);
}

}  // namespace

bool ErrAlike(double neighbor_correlation, const ErrorFigures& errors) {
  return neighbor_correlation > kSystematicPart &&
         errors.rms_px * std::sqrt(neighbor_correlation) >= kNegligiblePx;
}

double PartOfImage(const Area& area, const ImageSize& size) {
  return area.width() * area.height() /
         (static_cast<double>(size.width) * size.height);
}

Verdict JudgeCalibration(const CalibrationFigures& figures) {
  Verdict verdict = {"pass", {}};
  // First what else would be better.
  if (!figures.interrupted) JudgeOtherModels(figures, &verdict);
  for (const auto judge : {JudgeConvergence, JudgeNumberOfImages, JudgeArea,
                           JudgeViews, JudgeSides, JudgeRejectedImages})
    judge(figures, &verdict);
  // Errors of a state on its way say nothing.
  if (figures.interrupted) return verdict;
  for (const auto judge :
       {JudgeTimes, JudgeImagesApart, JudgeImagesAlone, JudgeTurns,
        JudgeFlatBoard, JudgeFleetDistance, JudgeUncertainty, JudgeFoldOver,
        JudgePixels, JudgeNeighbors, JudgeHeldOutError, JudgeHeldOutCopies,
        JudgeOverfit})
    judge(figures, &verdict);
  return verdict;
}

}  // namespace raygrid
