#include "evaluation/budget_assessment.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace raygrid {
namespace {

constexpr double kWorthwhile = 0.1;  // fraction of the squared residuals

std::string AdviseOnBetterModel(const BudgetSummary& facts) {
  return fmt::format("use --model {}, which has a lower held-out error",
                     facts.better_model);
}

std::string AdviseOnImagePosition(const BudgetSummary& facts) {
  if (!facts.better_model.empty()) return AdviseOnBetterModel(facts);
  if (!facts.IsGrid() && !facts.has_tried_generic_model)
    return "use --model central-generic";
  if (!facts.IsGrid())
    return "add images: central-generic was tried, but requires more images";
  if (facts.has_tried_finer_grid)
    return "add images: a smaller knot spacing was tried, but requires more "
           "images";
  if (facts.knot_spacing_px > 0)
    return fmt::format("reduce the knot spacing: --knot-spacing-px {:.3g}",
                       facts.knot_spacing_px / 2);
  return "reduce --knot-spacing-px";
}

// Recommends a remedy for a cause, unless it was already tried.
std::string AdviseOnCause(ErrorCause cause, const BudgetSummary& facts) {
  switch (cause) {
    case ErrorCause::kImagePosition:
      return AdviseOnImagePosition(facts);
    case ErrorCause::kBoardPosition:
      if (!facts.has_estimated_points)
        return "calibrate without --fix-target-geometry, to estimate the "
               "target geometry";
      return "print the target on a better printer, or add images of it";
    case ErrorCause::kDeformation:
      if (!facts.has_tried_deformation && facts.IsGrid())
        return "calibrate without --rigid-target and --fix-target-geometry, to "
               "estimate per-view deformation";
      return "mount the pattern on a stiffer board, of glass or aluminium, and "
             "hold it by its edges";
    case ErrorCause::kInPlane:
      return "use a dimensionally stable target, of glass or aluminium instead "
             "of paper";
    case ErrorCause::kImageAffine:
      return "fix focus and zoom, and let the camera warm up before the first "
             "image";
    default:
      return "keep camera and target still in each image, use a global "
             "shutter, or calibrate consecutive frames with --rolling-shutter";
  }
}

const char* NameCause(ErrorCause cause) {
  switch (cause) {
    case ErrorCause::kImagePosition:
      return "systematic residuals that depend on the position in the image";
    case ErrorCause::kBoardPosition:
      return "systematic residuals that depend on the target point";
    case ErrorCause::kDeformation:
      return "out-of-plane target deformation that differs between images";
    case ErrorCause::kInPlane:
      return "in-plane target deformation that differs between images";
    case ErrorCause::kImageAffine:
      return "image scale or shift that differs between images, such as from "
             "focus or temperature";
    default:
      return "residuals that grow from row to row, due to motion and a rolling "
             "shutter";
  }
}

std::optional<ErrorCause> FindLargestCause(const ResidualBudget& budget) {
  std::optional<ErrorCause> largest;
  for (int k = 0; k < kNumErrorCauses; ++k) {
    const auto cause = static_cast<ErrorCause>(k);
    if (budget.Of(cause).sequential_share < kWorthwhile) continue;
    if (!largest || budget.Of(cause).sequential_share >
                        budget.Of(*largest).sequential_share)
      largest = cause;
  }
  return largest;
}

int Percent(double part) { return static_cast<int>(std::lround(100 * part)); }

// Lists the causes that explain the views as well as the largest cause does:
// with small tilts or a narrow field of view, they cannot be separated. A cause
// that explains no more than the control, column-wise motion, is not identified
// either.
std::vector<std::string> ListEquivalentCauses(const ResidualBudget& budget) {
  std::vector<std::string> names;
  for (int k = 0; k < kNumErrorCauses; ++k)
    if (budget.causes[static_cast<size_t>(k)].is_indistinguishable)
      names.emplace_back(ToString(static_cast<ErrorCause>(k)));
  return names;
}

// Model errors and an incorrect target geometry cause similar errors. Both can
// be tested without new images.
std::string AdviseOnEquivalentViewCauses(const BudgetSummary& facts) {
  if (!facts.better_model.empty()) return AdviseOnBetterModel(facts);
  if (!facts.IsGrid() && !facts.has_tried_generic_model)
    return "first use --model central-generic, since a model error causes such "
           "residuals, too";
  if (facts.IsGrid() && !facts.has_estimated_points)
    return "first calibrate without --fix-target-geometry, since a wrong "
           "target geometry causes such residuals, too";
  if (facts.model == models::kCentralGeneric &&
      !facts.has_tried_noncentral_model)
    return "first use --model noncentral-generic, since a non-central camera, "
           "for example one that looks through glass, causes such residuals, "
           "too";
  return "retake the images with camera and target still, a stiff target and "
         "fixed focus; tilted views separate these causes";
}

BudgetAssessment MakeEquivalentViewsAssessment(
    const std::vector<std::string>& causes, const ResidualBudget& budget) {
  return {"per-view effects",
          fmt::format("residuals specific to single images ({} % of the "
                      "squared residuals), whose cause is not observable in "
                      "these images; candidates: {}",
                      Percent(budget.PerViewShare()), fmt::join(causes, ", ")),
          AdviseOnEquivalentViewCauses(budget.facts)};
}

BudgetAssessment MakeCauseAssessment(ErrorCause cause,
                                     const ResidualBudget& budget) {
  const std::vector<std::string> equivalent_causes =
      ListEquivalentCauses(budget);
  if (cause >= ErrorCause::kDeformation &&
      (equivalent_causes.size() > 1 ||
       (budget.is_column_delay_indistinguishable &&
        !equivalent_causes.empty())))
    return MakeEquivalentViewsAssessment(equivalent_causes, budget);
  return {ToString(cause),
          fmt::format("{} ({} % of the squared residuals)", NameCause(cause),
                      Percent(budget.Of(cause).sequential_share)),
          AdviseOnCause(cause, budget.facts)};
}

BudgetAssessment MakeOutlierAssessment(const ResidualBudget& budget) {
  return {"outliers",
          fmt::format("outliers ({} % of the squared residuals are beyond 5 "
                      "standard deviations)",
                      Percent(budget.large)),
          "inspect the images with the largest errors, and remove wrong "
          "features there"};
}

// Returns "; effects that these images do not determine: ...", or an empty
// string.
std::string DescribeUnresolvedCauses(const ResidualBudget& budget) {
  std::vector<std::string> names;
  for (int k = 0; k < kNumErrorCauses; ++k)
    if (!budget.causes[static_cast<size_t>(k)].is_observable)
      names.emplace_back(ToString(static_cast<ErrorCause>(k)));
  if (names.empty()) return "";
  return fmt::format("; effects not observable in these images: {}",
                     fmt::join(names, ", "));
}

BudgetAssessment MakeNoiseAssessment(const ResidualBudget& budget) {
  return {"noise",
          fmt::format("feature noise, {:.2g} px in x and {:.2g} px in y ({} % "
                      "of the squared residuals){}",
                      budget.noise_px.x(), budget.noise_px.y(),
                      Percent(budget.noise), DescribeUnresolvedCauses(budget)),
          "add images, or improve their sharpness: more light, better focus"};
}

BudgetAssessment MakeRemainderAssessment(const ResidualBudget& budget) {
  return {"unexplained",
          fmt::format("spatially correlated residuals of unknown cause ({} % "
                      "of the squared residuals){}",
                      Percent(budget.rest), DescribeUnresolvedCauses(budget)),
          AdviseOnCorrelatedErrors(budget.facts)};
}

BudgetAssessment AssessDeterminedBudget(const ResidualBudget& budget) {
  const std::optional<ErrorCause> cause = FindLargestCause(budget);
  const double largest = cause ? budget.Of(*cause).sequential_share : 0;
  if (budget.large >= kWorthwhile && budget.large > largest)
    return MakeOutlierAssessment(budget);
  if (cause) return MakeCauseAssessment(*cause, budget);
  return budget.noise >= budget.rest ? MakeNoiseAssessment(budget)
                                     : MakeRemainderAssessment(budget);
}

}  // namespace

std::string AdviseOnCorrelatedErrors(const BudgetSummary& facts) {
  constexpr char kLook[] =
      "look for blur, glare, motion and outlier images in the report";
  if (!facts.better_model.empty()) return AdviseOnBetterModel(facts);
  if (!facts.IsGrid())
    return facts.has_tried_generic_model
               ? fmt::format(
                     "central-generic was tried and is not "
                     "significantly better; {}",
                     kLook)
               : "try --model central-generic";
  std::vector<std::string> advice;
  if (!facts.knot_spacing_selected)
    advice.emplace_back("try --knot-spacing-px auto");
  else if (!facts.has_tried_finer_grid && facts.knot_spacing_px > 0)
    advice.push_back(fmt::format("try a smaller --knot-spacing-px {:.0f}",
                                 facts.knot_spacing_px / 2));
  if (facts.model == models::kCentralGeneric &&
      !facts.has_tried_noncentral_model)
    advice.emplace_back(
        "try --model noncentral-generic if the camera may be non-central, for "
        "example because it looks through glass");
  if (advice.empty())
    return fmt::format("other knot spacings were tried and are no better; {}",
                       kLook);
  return fmt::to_string(fmt::join(advice, ", or "));
}

BudgetAssessment AssessBudget(const ResidualBudget& budget) {
  if (!budget.unobservable_reason.empty())
    return {"", "not observable: " + budget.unobservable_reason,
            "add images of the whole target"};
  BudgetAssessment assessment = AssessDeterminedBudget(budget);
  if (budget.facts.mixed_cameras && assessment.limit != "noise")
    assessment.advice = "calibrate the images of the two cameras separately";
  return assessment;
}

}  // namespace raygrid
