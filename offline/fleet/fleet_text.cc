#include "fleet/fleet_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "fleet/control_chart_svg.h"

namespace raygrid {
namespace {

const ControlChart* FindControlChart(const FleetStatistics& statistics,
                                     const std::string& name) {
  for (const ControlChart& chart : statistics.charts)
    if (chart.name == name) return &chart;
  return nullptr;
}

std::string WithUnit(const std::string& name, double value) {
  return FormatChartValue(value) + GetMetricUnit(name);
}

const std::string& GetSerial(const FleetAnalysis& fleet, int unit) {
  return fleet.rows[fleet.compared[unit]].serial;
}

// Returns " (its lens is the first of batch B2)", if applicable.
std::string BatchWarning(const FleetAnalysis& fleet, int unit) {
  const std::string& batch = fleet.rows[fleet.compared[unit]].lens_batch;
  if (batch.empty()) return "";
  for (int u = 0; u < unit; ++u)
    if (fleet.rows[fleet.compared[u]].lens_batch == batch) return "";
  return fmt::format(" (first lens of batch {})", batch);
}

std::string DescribeJump(const FleetAnalysis& fleet, const MeanJump& jump) {
  const std::string values =
      jump.name == "lens"
          ? ""
          : fmt::format(" from {} to {}", WithUnit(jump.name, jump.before),
                        WithUnit(jump.name, jump.after));
  return fmt::format("from {}{}, the mean of {} ({}) changes{} ({:.1f} sigma)",
                     GetSerial(fleet, jump.unit),
                     BatchWarning(fleet, jump.unit), GetMetricTitle(jump.name),
                     jump.name, values, jump.sigmas);
}

std::string DescribeDrift(const FleetAnalysis& fleet, const MeanDrift& drift) {
  const std::string values =
      drift.name == "lens"
          ? ""
          : fmt::format(": from {} to {}", WithUnit(drift.name, drift.first),
                        WithUnit(drift.name, drift.last));
  return fmt::format(
      "the mean of {} ({}) drifts from {} to {}{} (slope: {:.1f} sigma)",
      GetMetricTitle(drift.name), drift.name, GetSerial(fleet, 0),
      GetSerial(fleet, static_cast<int>(fleet.compared.size()) - 1), values,
      drift.sigmas);
}

}  // namespace

std::string GetMetricTitle(const std::string& name) {
  static const std::map<std::string, std::string> kTitles = {
      {"lens", "intrinsics as a whole"},
      {"shape", "deviation from the fleet's subspace"},
      {"focal_px", "focal length"},
      {"center_x_px", "principal point x"},
      {"center_y_px", "principal point y"},
      {"held_out_median_px", "held-out error"},
      {"max_uncertainty_px", "maximum predicted uncertainty"},
      {"sensor_temperature_c", "sensor temperature"},
      {"pixels", "projection over the whole image"}};
  const auto found = kTitles.find(name);
  return found == kTitles.end() ? name : found->second;
}

std::string GetMetricUnit(const std::string& name) {
  if (name == "lens") return "";
  if (name == "shape") return " px²";
  return name == "sensor_temperature_c" ? " °C" : " px";
}

std::vector<std::string> DescribeOutliers(const FleetStatistics& statistics,
                                          int unit) {
  std::vector<std::string> sentences;
  for (const OutlierUnit& outliers : statistics.outliers) {
    if (outliers.unit != unit) continue;
    for (const std::string& name : outliers.charts) {
      const ControlChart& chart = *FindControlChart(statistics, name);
      const auto metric = [&](double value) {
        return FormatChartValue(chart.is_logarithm ? std::exp(value) : value);
      };
      const double center_line = chart.center_line[unit];
      const std::string usual =
          std::isfinite(chart.lower)
              ? fmt::format("normal range {} to {}",
                            metric(center_line + chart.lower),
                            metric(center_line + chart.upper))
              : fmt::format("the limit is {}", metric(chart.upper));
      sentences.push_back(
          fmt::format("{} ({}) is {}, {}{}", GetMetricTitle(name), name,
                      metric(chart.values[unit]), usual, GetMetricUnit(name)));
    }
  }
  return sentences;
}

std::vector<std::string> DescribeChanges(const FleetAnalysis& fleet) {
  std::vector<std::string> sentences;
  for (const MeanJump& jump : fleet.statistics.jumps)
    sentences.push_back(DescribeJump(fleet, jump));
  for (const MeanDrift& drift : fleet.statistics.drifts)
    sentences.push_back(DescribeDrift(fleet, drift));
  return sentences;
}

std::vector<std::string> DescribeBatches(const BatchComparison& batches) {
  std::vector<std::string> sentences;
  for (const BatchedMetric& metric : batches.metrics) {
    if (!metric.differs) continue;
    std::string means;
    if (!metric.means.empty()) {
      const auto [least, most] =
          std::minmax_element(metric.means.begin(), metric.means.end());
      means = fmt::format(": {} in {}, {} in {}", WithUnit(metric.name, *least),
                          batches.batches[least - metric.means.begin()],
                          WithUnit(metric.name, *most),
                          batches.batches[most - metric.means.begin()]);
    }
    sentences.push_back(
        fmt::format("lens batches differ in {} ({}){} (p value {})",
                    GetMetricTitle(metric.name), metric.name, means,
                    FormatProbability(metric.p_value)));
  }
  return sentences;
}

std::vector<std::string> DescribeGauge(const GaugeStudy& gauge) {
  std::vector<std::string> sentences;
  for (const GaugeMetric& metric : gauge.metrics) {
    std::string sentence = fmt::format(
        "repeatability of {} ({}): {}", GetMetricTitle(metric.name),
        metric.name, FormatGaugeStdDev(metric, metric.repeatability));
    for (const GaugeFactor& factor : metric.factors)
      sentence += fmt::format(", {}s add {}", factor.name,
                              FormatGaugeStdDev(metric, factor.deviation));
    if (metric.fraction_of_fleet)
      sentence += fmt::format(", {:.1f} % of the fleet's variation",
                              100 * *metric.fraction_of_fleet);
    if (metric.fraction_of_limits)
      sentence += fmt::format("; 6 sigma is {:.1f} % of the tolerance",
                              100 * *metric.fraction_of_limits);
    sentences.push_back(sentence);
  }
  sentences.insert(sentences.end(), gauge.unobservable_reason.begin(),
                   gauge.unobservable_reason.end());
  return sentences;
}

std::string DescribeDuration(const std::vector<UnitRow>& rows) {
  std::vector<double> seconds;
  double sum = 0;
  for (const UnitRow& row : rows)
    if (row.seconds > 0) {
      seconds.push_back(row.seconds);
      sum += row.seconds;
    }
  if (seconds.empty()) return "";
  std::sort(seconds.begin(), seconds.end());
  return fmt::format(
      "run time per unit {:.1f} s (median), {:.1f} s (max); all {}: {:.0f} s",
      seconds[seconds.size() / 2], seconds.back(), seconds.size(), sum);
}

std::string FormatGaugeStdDev(const GaugeMetric& metric, double deviation) {
  return metric.is_logarithm
             ? fmt::format("{:.3g} %", 100 * deviation)
             : fmt::format("{:.3g}{}", deviation, GetMetricUnit(metric.name));
}

std::string FormatProbability(double p_value) {
  return p_value < 1e-4 ? "< 0.0001" : fmt::format("{:.2g}", p_value);
}

}  // namespace raygrid
