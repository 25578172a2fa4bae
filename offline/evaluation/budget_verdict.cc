#include "evaluation/budget_verdict.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace raygrid {
namespace {

constexpr double kWorthwhile = 0.1;  // part of the squared residuals

std::string BetterModelAdvice(const BudgetFacts& facts) {
  return fmt::format(
      "calibrate with --model {}, which predicts held-out images better",
      facts.better_model);
}

std::string ImagePlaceAdvice(const BudgetFacts& facts) {
  if (!facts.better_model.empty()) return BetterModelAdvice(facts);
  if (!facts.IsGrid() && !facts.generic_tried)
    return "calibrate with --model central-generic";
  if (!facts.IsGrid())
    return "take more images: central-generic was tried, and these are too few "
           "for it";
  if (facts.tried_finer)
    return "take more images: a finer grid was tried, and these are too few "
           "for it";
  if (facts.cell_px > 0)
    return fmt::format("calibrate with a finer grid: --knot-spacing-px {:.3g}",
                       facts.cell_px / 2);
  return "calibrate with a finer grid: a smaller --knot-spacing-px";
}

// The thing to do against a cause, if it was not done yet.
std::string AdviceFor(ErrorCause cause, const BudgetFacts& facts) {
  switch (cause) {
    case ErrorCause::kImagePlace:
      return ImagePlaceAdvice(facts);
    case ErrorCause::kBoardPlace:
      if (!facts.points_free)
        return "calibrate without --fix-target-geometry, so that the board's "
               "points are "
               "estimated, too";
      return "print the board anew, on a better printer, or take more images "
             "of it";
    case ErrorCause::kBend:
      if (!facts.bends_tried && facts.IsGrid())
        return "calibrate without --rigid-target and --fix-target-geometry, so "
               "that "
               "bends are estimated, too";
      return "glue the pattern onto a stiffer board, of glass or aluminium, "
             "and hold it by its edges";
    case ErrorCause::kInPlane:
      return "use a board that keeps its size, of glass or aluminium instead "
             "of paper";
    case ErrorCause::kImageAffine:
      return "lock focus and zoom, and let the camera warm up before the first "
             "image";
    default:
      return "keep camera and board still in each image, use a global "
             "shutter, or record consecutive frames, and calibrate them with "
             "--rolling-shutter";
  }
}

const char* InWords(ErrorCause cause) {
  switch (cause) {
    case ErrorCause::kImagePlace:
      return "the model does not follow the lens: errors belong to places of "
             "the image";
    case ErrorCause::kBoardPlace:
      return "the board is not as it was taken to be: errors belong to its "
             "points";
    case ErrorCause::kBend:
      return "the board bends from image to image";
    case ErrorCause::kInPlane:
      return "the board is stretched in its plane from image to image";
    case ErrorCause::kImageAffine:
      return "the image's scale or place changes from image to image, as by "
             "focus or temperature";
    default:
      return "errors grow from row to row, as of a rolling shutter in motion";
  }
}

std::optional<ErrorCause> LargestCause(const ResidualBudget& budget) {
  std::optional<ErrorCause> largest;
  for (int k = 0; k < kNumErrorCauses; ++k) {
    const auto cause = static_cast<ErrorCause>(k);
    if (budget.Of(cause).in_turn < kWorthwhile) continue;
    if (!largest || budget.Of(cause).in_turn > budget.Of(*largest).in_turn)
      largest = cause;
  }
  return largest;
}

int Percent(double part) { return static_cast<int>(std::lround(100 * part)); }

// The causes that explain the views as well as the largest. Few tilts or a
// narrow field of view do not tell them apart. Nor is a cause told that
// explains no more than motion from column to column.
std::vector<std::string> AlikeCauses(const ResidualBudget& budget) {
  std::vector<std::string> names;
  for (int k = 0; k < kNumErrorCauses; ++k)
    if (budget.causes[static_cast<size_t>(k)].is_alike)
      names.emplace_back(NameOf(static_cast<ErrorCause>(k)));
  if (budget.column_time_is_alike) names.emplace_back("column time");
  return names;
}

// Models that do not follow the lens and boards that are not as told leave such
// errors, too, and cost no images to try.
std::string AdviceOnViewsAlike(const BudgetFacts& facts) {
  if (!facts.better_model.empty()) return BetterModelAdvice(facts);
  if (!facts.IsGrid() && !facts.generic_tried)
    return "calibrate with --model central-generic first, since a model that "
           "does not follow the lens leaves such errors, too";
  if (facts.IsGrid() && !facts.points_free)
    return "calibrate without --fix-target-geometry first, since a board that "
           "is not as "
           "told leaves such errors, too";
  if (facts.model == "central-generic" && !facts.noncentral_tried)
    return "calibrate with --model noncentral-generic first, since lines that "
           "do not meet in a point, as behind glass, leave such errors, too";
  return "take the images anew with camera and board still, a stiff board and "
         "focus locked; tilted boards tell these causes apart";
}

BudgetVerdict OfViewsAlike(const std::vector<std::string>& causes,
                           const ResidualBudget& budget) {
  return {"views",
          fmt::format("each image has errors of its own ({} % of the squared "
                      "residuals); these explain them alike: {}",
                      Percent(budget.OfViews()), fmt::join(causes, ", ")),
          AdviceOnViewsAlike(budget.facts)};
}

BudgetVerdict OfCause(ErrorCause cause, const ResidualBudget& budget) {
  const std::vector<std::string> alike = AlikeCauses(budget);
  if (cause >= ErrorCause::kBend && alike.size() > 1)
    return OfViewsAlike(alike, budget);
  return {NameOf(cause),
          fmt::format("{} ({} % of the squared residuals)", InWords(cause),
                      Percent(budget.Of(cause).in_turn)),
          AdviceFor(cause, budget.facts)};
}

BudgetVerdict OfLargeErrors(const ResidualBudget& budget) {
  return {"large errors",
          fmt::format("few features are far off ({} % of the squared residuals "
                      "are beyond five deviations)",
                      Percent(budget.large)),
          "look at the images of the largest errors, and leave out what is "
          "measured wrongly there"};
}

// "; image place and ... cannot be told", or nothing.
std::string UntoldCauses(const ResidualBudget& budget) {
  std::vector<std::string> names;
  for (int k = 0; k < kNumErrorCauses; ++k)
    if (!budget.causes[static_cast<size_t>(k)].can_be_told)
      names.emplace_back(NameOf(static_cast<ErrorCause>(k)));
  if (names.empty()) return "";
  return fmt::format("; it cannot be told of {}", fmt::join(names, ", "));
}

BudgetVerdict OfNoise(const ResidualBudget& budget) {
  return {"noise",
          fmt::format("noise of single features, {:.3f} px in x and {:.3f} px "
                      "in y ({} % of the squared residuals){}",
                      budget.noise_px.x(), budget.noise_px.y(),
                      Percent(budget.noise), UntoldCauses(budget)),
          "take more images, or sharper ones: more light, better focus"};
}

BudgetVerdict OfRest(const ResidualBudget& budget) {
  return {"rest",
          fmt::format("errors that neighbours share, and that none of these "
                      "causes explains ({} % of the squared residuals){}",
                      Percent(budget.rest), UntoldCauses(budget)),
          AdviceAgainstSharedErrors(budget.facts)};
}

BudgetVerdict JudgeToldBudget(const ResidualBudget& budget) {
  const std::optional<ErrorCause> cause = LargestCause(budget);
  const double largest = cause ? budget.Of(*cause).in_turn : 0;
  if (budget.large >= kWorthwhile && budget.large > largest)
    return OfLargeErrors(budget);
  if (cause) return OfCause(*cause, budget);
  return budget.noise >= budget.rest ? OfNoise(budget) : OfRest(budget);
}

}  // namespace

std::string AdviceAgainstSharedErrors(const BudgetFacts& facts) {
  constexpr char kLook[] =
      "look for blur, glare, motion and single images that stand out in the "
      "report";
  if (!facts.better_model.empty()) return BetterModelAdvice(facts);
  if (!facts.IsGrid())
    return facts.generic_tried ? fmt::format(
                                     "central-generic was tried and is "
                                     "not shown to be better; {}",
                                     kLook)
                               : "try --model central-generic";
  std::vector<std::string> advice;
  if (!facts.cells_chosen)
    advice.emplace_back(
        "try --knot-spacing-px auto, which looks for better cells");
  else if (!facts.tried_finer && facts.cell_px > 0)
    advice.push_back(fmt::format("try smaller cells, --knot-spacing-px {:.0f}",
                                 facts.cell_px / 2));
  if (facts.model == "central-generic" && !facts.noncentral_tried)
    advice.emplace_back(
        "try --model noncentral-generic if lines may not meet in a point, as "
        "behind glass");
  if (advice.empty())
    return fmt::format("other grids were tried and are no better; {}", kLook);
  return fmt::to_string(fmt::join(advice, ", or "));
}

BudgetVerdict JudgeBudget(const ResidualBudget& budget) {
  if (!budget.untold.empty())
    return {"", "it cannot be told: " + budget.untold,
            "take more images of the whole board"};
  BudgetVerdict verdict = JudgeToldBudget(budget);
  if (budget.facts.two_cameras && verdict.limit != "noise")
    verdict.advice = "calibrate the images of each of the two cameras alone";
  return verdict;
}

}  // namespace raygrid
