#include "report/budget_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "evaluation/budget_assessment.h"
#include "report/html.h"

namespace raygrid {
namespace {

// A component of the residual budget, in the bar and in the table.
struct BudgetShare {
  std::string name, meaning;
  double part = 0;
  const CauseShare* share = nullptr;  // nullptr for chance, which has no share
  const char* color = "";             // from the Okabe-Ito palette
};

const char* DescribeCause(ErrorCause cause) {
  switch (cause) {
    case ErrorCause::kImagePosition:
      return "residuals that depend on the position in the image";
    case ErrorCause::kBoardPosition:
      return "residuals that depend on the target point";
    case ErrorCause::kDeformation:
      return "out-of-plane target deformation per image";
    case ErrorCause::kInPlane:
      return "in-plane target deformation per image (stretch or shear)";
    case ErrorCause::kImageAffine:
      return "image scale or shift per image, such as from focus or "
             "temperature";
    default:
      return "motion with a rolling shutter";
  }
}

std::vector<BudgetShare> SplitText(const ResidualBudget& budget) {
  constexpr const char* kColors[kNumErrorCauses] = {
      "#0072b2", "#009e73", "#d55e00", "#f0e442", "#cc79a7", "#e69f00"};
  std::vector<BudgetShare> parts = {
      {"noise", "white noise, independent between features", budget.noise,
       nullptr, "#999999"},
      {"outliers", "single features beyond 5 standard deviations", budget.large,
       nullptr, "#000000"}};
  for (int k = 0; k < kNumErrorCauses; ++k) {
    const auto cause = static_cast<ErrorCause>(k);
    const CauseShare& share = budget.Of(cause);
    parts.push_back({ToString(cause), DescribeCause(cause),
                     share.sequential_share, &share, kColors[k]});
  }
  parts.push_back({"unexplained", "spatially correlated, of unknown cause",
                   budget.rest, nullptr, "#56b4e9"});
  return parts;
}

std::string MakeBar(const std::vector<BudgetShare>& parts) {
  double sum = 1e-9;
  for (const BudgetShare& part : parts) sum += std::max(part.part, 0.0);
  std::string html =
      "<figure><figcaption>Fractions of the squared residuals</figcaption><div "
      "class=\"parts\">";
  for (const BudgetShare& part : parts)
    if (part.part > 0)
      html += fmt::format(
          "<i style=\"width: {:.2f}%; background: {}\" title=\"{}: {:.1f} "
          "%\"></i>",
          100 * part.part / sum, part.color, part.name, 100 * part.part);
  return html + "</div></figure>\n";
}

std::string CapitalizeFirst(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] -= 'a' - 'A';
  return text;
}

std::string Percent(double part) {
  return fmt::format("{:.1f}&nbsp;%", 100 * part);
}

HtmlRow MakeRow(const BudgetShare& part) {
  HtmlRow row = {fmt::format("<i class=\"part\" style=\"background: "
                             "{}\"></i>{}",
                             part.color, part.name),
                 Percent(part.part), "", "", part.meaning};
  if (!part.share) return row;
  if (!part.share->is_observable) {
    row[1] = "&ndash;";
    row[4] = "not observable: " + EscapeHtml(part.share->unobservable_reason);
    return row;
  }
  row[2] = Percent(part.share->alone);
  row[3] = Percent(part.share->random_limit);
  return row;
}

}  // namespace

std::string MakeBudgetSection(const ResidualBudget& budget) {
  const BudgetAssessment assessment = AssessBudget(budget);
  std::string html = fmt::format(
      "<h2>What limits this calibration</h2>\n<p><b>{}.</b> Remedy: {}.</p>\n",
      EscapeHtml(CapitalizeFirst(assessment.sentence)),
      EscapeHtml(assessment.advice));
  if (!budget.unobservable_reason.empty()) return html;
  const std::vector<BudgetShare> parts = SplitText(budget);
  std::vector<HtmlRow> rows;
  for (const BudgetShare& part : parts) rows.push_back(MakeRow(part));
  return html + MakeBar(parts) + "<div class=\"causes\">" +
         MakeHtmlTable({"", "fraction", "alone", "chance level", "meaning"},
                       rows) +
         "</div>" +
         fmt::format(
             "<p>Training residuals: {:.3g} px RMS per axis. Feature noise: "
             "{:.2g} px in x, {:.2g} px in y. Each cause is estimated from "
             "half of the features and evaluated on the other half. "
             "<b>alone</b>: before removing other causes; <b>chance level</b>: "
             "upper bound for residuals with random signs.</p>\n",
             budget.rms_px, budget.noise_px.x(), budget.noise_px.y());
}

}  // namespace raygrid
