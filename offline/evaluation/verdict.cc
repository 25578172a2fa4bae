#include "evaluation/verdict.h"

#include <fmt/format.h>

#include <cmath>

namespace raygrid {
namespace {

constexpr int kEnoughImages = 10;
constexpr int kEnoughViews = 3;
constexpr double kEnoughTiltRad = 5 * M_PI / 180;
constexpr double kEnoughArea = 0.5;    // part of the image
constexpr double kGoodMedianPx = 0.3;  // corners of a sharp chessboard
constexpr double kUsableMedianPx = 2;
constexpr double kOverfitRatio = 1.5;
// What views may leave open of a camera: with a warning, and at all.
constexpr double kOpenPx = 1, kLostPx = 5;
constexpr double kEnoughTrusted = 0.5;  // part of the calibrated area
// Of the squared residuals; five standard errors where there are fewest pairs.
constexpr double kSystematicPart = 0.25;

}  // namespace

double PartOfImage(const Area& area, const ImageSize& size) {
  return area.width() * area.height() /
         (static_cast<double>(size.width) * size.height);
}

Verdict JudgeCalibration(const CalibrationFigures& figures) {
  Verdict verdict = {"pass", {}};
  const auto warn = [&verdict](const std::string& reason) {
    if (verdict.word == "pass") verdict.word = "warn";
    verdict.reasons.push_back(reason);
  };
  const auto fail = [&verdict](const std::string& reason) {
    verdict.word = "fail";
    verdict.reasons.push_back(reason);
  };

  if (figures.interrupted)
    fail("interrupted before it was done; go on with --resume");
  else if (!figures.converged)
    fail("the adjustment did not converge; add images or remove blurred ones");
  if (figures.images_used < kEnoughImages)
    warn(fmt::format("only {} images; take {} or more", figures.images_used,
                     kEnoughImages));
  const double part = PartOfImage(figures.area, figures.image_size);
  if (part < kEnoughArea)
    warn(fmt::format(
        "features reach only {:.0f} % of the image; hold the board into the "
        "corners",
        100 * part));
  if (figures.different_views < kEnoughViews)
    fail(fmt::format(
        "the board is seen in only {} different ways in {} images; move it and "
        "tilt it between them",
        figures.different_views, figures.images_used));
  else if (figures.tilt_rad < kEnoughTiltRad)
    fail(fmt::format(
        "all boards are parallel to within {:.1f} degrees, which leaves the "
        "focal length open; tilt them by 30 degrees or more, each time another "
        "way",
        *figures.tilt_rad * 180 / M_PI));
  if (2 * figures.boards_seen_from_behind > figures.boards_seen)
    warn(fmt::format(
        "{} of {} times the board is seen from behind: its columns or rows are "
        "counted the other way round in pattern or features, or the images are "
        "mirrored",
        figures.boards_seen_from_behind, figures.boards_seen));
  if (!figures.images_apart.empty())
    warn(fmt::format(
        "{} images do not fit the others ({}{}): another camera, focus or "
        "board, or misread features; calibrate without them",
        figures.images_apart.size(), figures.images_apart.front(),
        figures.images_apart.size() > 1 ? ", ..." : ""));
  if (figures.median_deviation_px > kOpenPx) {
    const std::string reason = fmt::format(
        "the views leave the camera open by {:.2g} px: tilt the board by 30 "
        "degrees or more, each time another way, and change the distance",
        *figures.median_deviation_px);
    if (figures.median_deviation_px > kLostPx)
      fail(reason);
    else
      warn(reason);
  } else if (figures.trusted_part < kEnoughTrusted) {
    warn(
        fmt::format("only {:.0f} % of the calibrated area is known to {:.2g} "
                    "px; take more views, "
                    "tilted all ways, near and far, into the corners",
                    100 * *figures.trusted_part, *figures.trusted_px));
  }
  if (figures.images_rejected > figures.images_used / 5)
    warn(fmt::format("{} images were rejected; see which and why",
                     figures.images_rejected));
  if (figures.neighbor_correlation > kSystematicPart) {
    const ErrorFigures& errors =
        figures.held_out ? *figures.held_out : figures.training;
    warn(fmt::format(
        "neighbouring features err alike (correlation {:.2f}): about {:.2f} px "
        "are not noise, but the model's error or the detector's; try smaller "
        "cells, or noncentral-generic if lines may not meet in a point, as "
        "behind glass",
        *figures.neighbor_correlation,
        errors.rms_px * std::sqrt(*figures.neighbor_correlation)));
  }
  if (!figures.held_out) {
    warn("no held-out error: too few images to hold some out");
    return verdict;
  }
  const double held_out = figures.held_out->median_px;
  if (held_out > kUsableMedianPx)
    fail(fmt::format("the held-out error is {:.2f} px", held_out));
  else if (held_out > kGoodMedianPx)
    warn(fmt::format(
        "the held-out error is {:.2f} px; sharper images or a flatter board "
        "would lower it",
        held_out));
  if (held_out > kOverfitRatio * figures.training.median_px)
    warn(fmt::format(
        "the held-out error is {:.1f} times the training error; take more "
        "images",
        held_out / figures.training.median_px));
  return verdict;
}

}  // namespace raygrid
