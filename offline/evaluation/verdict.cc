#include "evaluation/verdict.h"

#include <fmt/format.h>

#include <cmath>

namespace raygrid {
namespace {

constexpr int kEnoughImages = 10;
constexpr double kEnoughArea = 0.5;    // part of the image
constexpr double kGoodMedianPx = 0.3;  // corners of a sharp chessboard
constexpr double kUsableMedianPx = 2;
constexpr double kOverfitRatio = 1.5;
// Of the squared residuals; five standard errors where there are fewest pairs.
constexpr double kSystematicPart = 0.25;

}  // namespace

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
  const double part = figures.area.width() * figures.area.height() /
                      (static_cast<double>(figures.image_size.width) *
                       figures.image_size.height);
  if (part < kEnoughArea)
    warn(fmt::format(
        "features reach only {:.0f} % of the image; hold the board into the "
        "corners",
        100 * part));
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
