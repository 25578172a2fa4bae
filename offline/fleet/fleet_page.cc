#include "fleet/fleet_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "fleet/control_chart_svg.h"
#include "fleet/fleet_text.h"
#include "report/html.h"

namespace raygrid {
namespace {

std::string CapitalizeFirst(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] -= 'a' - 'A';
  return text;
}

std::string MakeHtmlList(const std::vector<std::string>& sentences) {
  std::string html = "<ul>\n";
  for (const std::string& sentence : sentences)
    html += "<li>" + EscapeHtml(CapitalizeFirst(sentence)) + ".</li>\n";
  return html + "</ul>\n";
}

// Units without a folder have no report.
bool HasReport(const UnitRow& row) {
  return row.status != "error" && row.status != "missing";
}

std::string UnitLink(const UnitRow& row) {
  return HasReport(row)
             ? fmt::format("<a href=\"{0}/report.html\">{0}</a>", row.serial)
             : row.serial;
}

// ---- Summary ---------------------------------------------------------------

std::string DescribeCounts(const std::vector<UnitRow>& rows) {
  std::map<std::string, int> counts;
  for (const UnitRow& row : rows) ++counts[row.status];
  std::string text;
  for (const char* status : {"pass", "warn", "fail", "error", "missing"})
    if (counts[status] > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts[status],
                          status);
  return text;
}

std::string MakeSummarySection(const FleetAnalysis& fleet) {
  bool has_failed = false;
  for (const UnitRow& row : fleet.rows)
    has_failed |= row.status == "fail" || !HasReport(row);
  const FleetStatistics& statistics = fleet.statistics;
  const bool is_unusual = !statistics.outliers.empty() ||
                          !statistics.jumps.empty() ||
                          !statistics.drifts.empty();
  std::vector<std::string> sentences = {DescribeCounts(fleet.rows)};
  if (statistics.charts.empty())
    sentences.push_back(
        fmt::format("{} units can be compared; outlier detection requires at "
                    "least {} units",
                    fleet.compared.size(), kMinFleetUnits));
  else
    sentences.push_back(
        fmt::format("{} of {} units are outliers, the mean changes {} times",
                    statistics.outliers.size(), fleet.compared.size(),
                    statistics.jumps.size() + statistics.drifts.size()));
  if (const std::string seconds = DescribeDuration(fleet.rows);
      !seconds.empty())
    sentences.push_back(seconds);
  return fmt::format("<div class=\"verdict {}\">\n{}</div>\n",
                     has_failed   ? "fail"
                     : is_unusual ? "warn"
                                  : "pass",
                     MakeHtmlList(sentences));
}

// ---- Out-of-control units --------------------------------------------------

std::string MakeUnusualSection(const FleetAnalysis& fleet) {
  if (fleet.statistics.outliers.empty()) return "";
  std::vector<HtmlRow> rows;
  for (const OutlierUnit& outliers : fleet.statistics.outliers) {
    std::string what;
    for (const std::string& piece :
         DescribeOutliers(fleet.statistics, outliers.unit))
      what += (what.empty() ? "" : "<br>") + EscapeHtml(CapitalizeFirst(piece));
    const UnitRow& row = fleet.rows[fleet.compared[outliers.unit]];
    rows.push_back({UnitLink(row), what});
  }
  return "<h2>Outliers</h2>\n<div class=\"told\">" +
         MakeHtmlTable({"unit", "outlying quantities"}, rows) + "</div>\n";
}

std::string MakeChangesSection(const FleetAnalysis& fleet) {
  const std::vector<std::string> sentences = DescribeChanges(fleet);
  if (sentences.empty()) return "";
  return "<h2>Changes over time</h2>\n" + MakeHtmlList(sentences);
}

// ---- Charts ----------------------------------------------------------------

std::string DescribeLimits(const ControlChart& chart,
                           const FleetAnalysis& fleet,
                           const std::vector<int>& jumps, bool has_drift) {
  const auto range = [&](size_t unit) {
    const auto metric = [&](double value) {
      return FormatChartValue(chart.is_logarithm ? std::exp(value) : value);
    };
    return fmt::format("{} to {}{}",
                       metric(chart.center_line[unit] + chart.lower),
                       metric(chart.center_line[unit] + chart.upper),
                       GetMetricUnit(chart.name));
  };
  if (!std::isfinite(chart.upper))
    return "No control limits: most consecutive units have equal values.";
  if (!std::isfinite(chart.lower))
    return fmt::format("Limit: {}{}.", FormatChartValue(chart.upper),
                       GetMetricUnit(chart.name));
  const size_t last = chart.values.size() - 1;
  if (has_drift)
    return fmt::format("Limits: {} at the beginning, {} at the end.", range(0),
                       range(last));
  std::string text = "Limits: " + range(0);
  for (const int jump : jumps)
    text += fmt::format(", from {} {}", fleet.rows[fleet.compared[jump]].serial,
                        range(jump));
  return text + ".";
}

std::string DescribeChart(const std::string& name, int num_directions) {
  if (name == "lens")
    return fmt::format(
        " (Hotelling's T²): distance from the mean along the {} principal "
        "components of this fleet's intrinsics, such as principal point, focal "
        "length and distortion. Changes of the mean are compensated.",
        num_directions);
  if (name == "shape")
    return ": squared distance from the subspace of these components. It is "
           "large for a tilted sensor or another lens type.";
  return fmt::format(" ({}).", name);
}

ChartAnnotations MakeChartAnnotations(const FleetAnalysis& fleet) {
  ChartAnnotations annotations;
  annotations.batch_names = fleet.batches.batches;
  for (const size_t row : fleet.compared) {
    annotations.serials.push_back(fleet.rows[row].serial);
    const auto& names = annotations.batch_names;
    const auto found =
        std::find(names.begin(), names.end(), fleet.rows[row].lens_batch);
    if (!names.empty())
      annotations.batches.push_back(
          found == names.end() ? -1 : static_cast<int>(found - names.begin()));
  }
  return annotations;
}

std::string MakeChartSection(const FleetAnalysis& fleet) {
  if (fleet.statistics.charts.empty()) return "";
  std::string html = fmt::format(
      "<h2>Control charts</h2>\n<p>Each point is a unit, in the order of "
      "serial numbers. Units beyond the dashed limits are marked by triangles "
      "and serial numbers. The solid line is the mean; dotted lines mark "
      "changes of the mean{}. In a fleet without outliers, the probability "
      "that any unit exceeds any limit is {:.0f} %. Outliers are excluded from "
      "the limits.</p>\n",
      fleet.batches.batches.empty()
          ? ""
          : "; the strip below shows the lens batches by colour",
      100 * kFleetFalseAlarmProbability);
  ChartAnnotations annotations = MakeChartAnnotations(fleet);
  for (const ControlChart& chart : fleet.statistics.charts) {
    annotations.jumps.clear();
    for (const MeanJump& jump : fleet.statistics.jumps)
      if (jump.name == chart.name) annotations.jumps.push_back(jump.unit);
    bool has_drift = false;
    for (const MeanDrift& drift : fleet.statistics.drifts)
      has_drift |= drift.name == chart.name;
    html += fmt::format(
        "<figure><figcaption><b>{}</b>{} {}</figcaption>\n<div "
        "class=\"scroll\">{}</div></figure>\n",
        EscapeHtml(CapitalizeFirst(GetMetricTitle(chart.name))),
        DescribeChart(chart.name, fleet.statistics.num_directions),
        DescribeLimits(chart, fleet, annotations.jumps, has_drift),
        MakeControlChartSvg(chart, annotations));
  }
  return html;
}

// ---- Batches and gauge -----------------------------------------------------

std::string MakeBatchesSection(const BatchComparison& batches) {
  if (batches.batches.empty()) return "";
  HtmlRow head = {"mean of"};
  for (size_t b = 0; b < batches.batches.size(); ++b)
    head.push_back(fmt::format(
        "<i class=\"part\" style=\"background: {}\"></i>{} ({} units)",
        GetBatchColor(static_cast<int>(b)), EscapeHtml(batches.batches[b]),
        batches.num_units[b]));
  for (const char* column : {"standard deviation within", "p value", ""})
    head.emplace_back(column);
  std::vector<HtmlRow> rows;
  for (const BatchedMetric& metric : batches.metrics) {
    HtmlRow row = {EscapeHtml(GetMetricTitle(metric.name))};
    for (size_t b = 0; b < batches.batches.size(); ++b)
      row.push_back(metric.means.empty() ? "&ndash;"
                                         : FormatChartValue(metric.means[b]));
    row.push_back(metric.means.empty()
                      ? "&ndash;"
                      : fmt::format("{:.3g}", metric.within_batch_stddev));
    row.push_back(EscapeHtml(FormatProbability(metric.p_value)));
    row.emplace_back(metric.differs ? "<b>differs</b>" : "");
    rows.push_back(row);
  }
  return "<h2>Lens batches</h2>\n" +
         (DescribeBatches(batches).empty()
              ? "<p>No significant difference between batches.</p>\n"
              : MakeHtmlList(DescribeBatches(batches))) +
         MakeHtmlTable(head, rows) +
         fmt::format(
             "<p>Analysis of variance; for the intrinsics, Pillai's trace "
             "along the principal components. The probability of any false "
             "difference is {:.0f} %. Outliers and batches of fewer than {} "
             "units are excluded. Standard deviations of errors are relative. "
             "Batches calibrated at different times may differ for other "
             "reasons.</p>\n",
             100 * kFleetFalseAlarmProbability, kMinBatchUnits);
}

// Returns a standard deviation without line breaks.
std::string FormatStdDevCell(const GaugeMetric& metric, double deviation) {
  std::string text = FormatGaugeStdDev(metric, deviation);
  return text.replace(text.find(' '), 1, "&nbsp;");
}

std::string PercentOrNone(const std::optional<double>& part) {
  return part ? fmt::format("{:.1f} %", 100 * *part) : "&ndash;";
}

HtmlRow MakeGaugeRow(const GaugeMetric& metric) {
  HtmlRow row = {EscapeHtml(GetMetricTitle(metric.name)),
                 FormatStdDevCell(metric, metric.repeatability)};
  for (const GaugeFactor& factor : metric.factors)
    row.push_back(
        FormatStdDevCell(metric, factor.deviation) +
        (factor.p_value
             ? fmt::format(" (p value {})", FormatProbability(*factor.p_value))
             : ""));
  row.push_back(FormatStdDevCell(metric, metric.gauge));
  row.push_back(PercentOrNone(metric.fraction_of_fleet));
  row.push_back(metric.num_classes ? fmt::format("{:.0f}", *metric.num_classes)
                                   : "&ndash;");
  row.push_back(PercentOrNone(metric.fraction_of_limits));
  return row;
}

std::string MakeGaugeSection(const GaugeStudy& gauge) {
  if (gauge.num_repeats == 0) return "";
  std::string html = fmt::format(
      "<h2>Gauge repeatability and reproducibility</h2>\n<p>{} repeated "
      "calibrations of {} golden unit{}, {} degrees of freedom.</p>\n",
      gauge.num_repeats, gauge.num_goldens, gauge.num_goldens == 1 ? "" : "s",
      gauge.degrees_of_freedom);
  if (!gauge.metrics.empty()) {
    HtmlRow head = {"standard deviation", "repeats"};
    for (const GaugeFactor& factor : gauge.metrics[0].factors)
      head.push_back(factor.name + "s");
    for (const char* column : {"total gauge", "of the fleet's variation",
                               "distinct categories", "of the tolerance"})
      head.emplace_back(column);
    std::vector<HtmlRow> rows;
    for (const GaugeMetric& metric : gauge.metrics)
      rows.push_back(MakeGaugeRow(metric));
    html += MakeHtmlTable(head, rows);
  }
  if (!gauge.unobservable_reason.empty())
    html += MakeHtmlList(gauge.unobservable_reason);
  return html +
         "<p>Standard deviations (1 sigma) by analysis of variance. Pixels are "
         "RMS over the image; errors are relative. According to AIAG, "
         "Measurement Systems Analysis, the gauge should contribute less than "
         "30 % of the fleet's variation and distinguish at least 5 categories, "
         "and 6 sigma should be below 30 % of the tolerance. With 10 degrees "
         "of freedom, the estimates are accurate to about 22 %.</p>\n";
}

// ---- All units -------------------------------------------------------------

std::string FormatMetricCell(const UnitRow& row, const char* name) {
  const auto metric = row.metrics.find(name);
  return metric == row.metrics.end() ? "" : FormatChartValue(metric->second);
}

std::string MakeUnitsSection(const std::vector<UnitRow>& units) {
  std::vector<HtmlRow> rows;
  for (const UnitRow& unit : units) {
    const std::string warning =
        unit.repeats.empty() ? unit.reason : "repeats " + unit.repeats;
    rows.push_back({UnitLink(unit), unit.status,
                    FormatMetricCell(unit, "focal_px"),
                    FormatMetricCell(unit, "center_x_px"),
                    FormatMetricCell(unit, "center_y_px"),
                    FormatMetricCell(unit, "held_out_median_px"),
                    FormatMetricCell(unit, "max_uncertainty_px"),
                    EscapeHtml(unit.lens_batch),
                    unit.seconds > 0 ? fmt::format("{:.1f}", unit.seconds) : "",
                    fmt::format("{}", fmt::join(unit.outliers, ", ")) +
                        (unit.outliers.empty() || warning.empty() ? "" : "; ") +
                        EscapeHtml(warning)});
  }
  return "<h2>All units</h2>\n<div class=\"told\">" +
         MakeHtmlTable({"unit", "status", "focal px", "centre x", "centre y",
                        "held-out median px", "max uncertainty px", "batch",
                        "s", "outlying quantities or remark"},
                       rows) +
         "</div>\n";
}

}  // namespace

std::string FormatFleetPage(const FleetAnalysis& fleet) {
  return PageStart(fmt::format("raygrid fleet: {} units", fleet.rows.size()),
                   "raygrid fleet") +
         MakeSummarySection(fleet) + MakeUnusualSection(fleet) +
         MakeChangesSection(fleet) + MakeChartSection(fleet) +
         MakeBatchesSection(fleet.batches) + MakeGaugeSection(fleet.gauge) +
         MakeUnitsSection(fleet.rows) + "</body></html>\n";
}

}  // namespace raygrid
