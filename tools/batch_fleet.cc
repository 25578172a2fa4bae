#include "batch_fleet.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "dataset/text_encoding.h"
#include "fleet/fleet_text.h"
#include "json_output.h"

namespace raygrid {
namespace {

using FleetJson = nlohmann::ordered_json;

const std::string& GetUnitSerial(const FleetAnalysis& fleet, int unit) {
  return fleet.rows[fleet.compared[unit]].serial;
}

FleetJson MakeUnitJson(const UnitRow& row) {
  FleetJson unit = {{"serial", row.serial}, {"status", row.status}};
  if (!row.reason.empty()) unit["reason"] = row.reason;
  if (!row.outliers.empty()) unit["outlying_metrics"] = row.outliers;
  for (const auto& [name, value] : row.metrics) unit[name] = value;
  for (const auto& [name, text] : {std::pair("lens_batch", &row.lens_batch),
                                   std::pair("repeats", &row.repeats)})
    if (!text->empty()) unit[name] = *text;
  if (row.seconds > 0) unit["elapsed_s"] = row.seconds;
  return unit;
}

FleetJson MakeChangesJson(const FleetAnalysis& fleet, FleetJson* drifts) {
  FleetJson jumps = FleetJson::array();
  for (const MeanJump& jump : fleet.statistics.jumps)
    jumps.push_back({{"serial", GetUnitSerial(fleet, jump.unit)},
                     {"metric", jump.name},
                     {"mean_before", jump.before},
                     {"mean_after", jump.after},
                     {"z_score", jump.sigmas}});
  for (const MeanDrift& drift : fleet.statistics.drifts)
    drifts->push_back({{"metric", drift.name},
                       {"first", drift.first},
                       {"last", drift.last},
                       {"z_score", drift.sigmas}});
  return jumps;
}

FleetJson MakeBatchesJson(const BatchComparison& batches) {
  FleetJson units = FleetJson::object(), metrics = FleetJson::object();
  for (size_t b = 0; b < batches.batches.size(); ++b)
    units[batches.batches[b]] = batches.num_units[b];
  for (const BatchedMetric& metric : batches.metrics) {
    FleetJson json = {{"differs", metric.differs}, {"p_value", metric.p_value}};
    for (size_t b = 0; b < metric.means.size(); ++b)
      json["means"][batches.batches[b]] = metric.means[b];
    if (!metric.means.empty())
      json["within_batch_sd"] = metric.within_batch_stddev;
    metrics[metric.name] = json;
  }
  return {{"units", units}, {"metrics", metrics}};
}

FleetJson MakeGaugeMetricJson(const GaugeMetric& metric) {
  FleetJson json = {{"repeatability_sd", metric.repeatability}};
  for (const GaugeFactor& factor : metric.factors) {
    json[factor.name] = {{"sd", factor.deviation}};
    if (factor.p_value) json[factor.name]["p_value"] = *factor.p_value;
  }
  json["gauge_rr_sd"] = metric.gauge;
  for (const auto& [name, value] :
       {std::pair("unit_to_unit_sd", metric.fleet),
        std::pair("gauge_rr_ratio", metric.fraction_of_fleet),
        std::pair("distinct_categories", metric.num_classes),
        std::pair("precision_to_tolerance_ratio", metric.fraction_of_limits)})
    if (value) json[name] = *value;
  if (metric.is_logarithm) json["relative"] = true;
  return json;
}

FleetJson MakeGaugeJson(const GaugeStudy& gauge) {
  FleetJson metrics = FleetJson::object();
  for (const GaugeMetric& metric : gauge.metrics)
    metrics[metric.name] = MakeGaugeMetricJson(metric);
  return {{"repeats", gauge.num_repeats},
          {"golden_units", gauge.num_goldens},
          {"degrees_of_freedom", gauge.degrees_of_freedom},
          {"metrics", metrics},
          {"not_observable", gauge.unobservable_reason}};
}

void PrintJson(const FleetAnalysis& fleet) {
  FleetJson units = FleetJson::array(), drifts = FleetJson::array();
  for (const UnitRow& row : fleet.rows) units.push_back(MakeUnitJson(row));
  const FleetJson jumps = MakeChangesJson(fleet, &drifts);
  FleetJson json = {{"units", units}, {"jumps", jumps}, {"drifts", drifts}};
  if (!fleet.batches.batches.empty())
    json["lens_batches"] = MakeBatchesJson(fleet.batches);
  if (fleet.gauge.num_repeats > 0)
    json["gauge_study"] = MakeGaugeJson(fleet.gauge);
  PrintCommandJson(json);
}

void PrintFleet(const FleetAnalysis& fleet) {
  for (const UnitRow& row : fleet.rows)
    if (!row.outliers.empty())
      fmt::print("{}: outlier in {}\n", row.serial,
                 fmt::join(row.outliers, ", "));
  for (const auto& sentences :
       {DescribeChanges(fleet), DescribeBatches(fleet.batches),
        DescribeGauge(fleet.gauge)})
    for (const std::string& sentence : sentences)
      fmt::print("{}\n", Printable(sentence));
  if (fleet.rows.size() > 1) fmt::print("{}\n", DescribeDuration(fleet.rows));
}

}  // namespace

void PrintUnits(const FleetAnalysis& fleet, const CommonOptions& common) {
  for (const UnitRow& row : fleet.rows)
    if (HasNoResult(row) || row.status == "fail")
      fmt::print(stderr, "raygrid: unit {}: {}: {}\n", row.serial, row.status,
                 Printable(row.reason));
    else if (!common.json && !common.quiet)
      fmt::print("{}: {}, {:.2f} s{}\n", row.serial, row.status, row.seconds,
                 row.reason.empty() ? "" : ": " + Printable(row.reason));
  if (common.json)
    PrintJson(fleet);
  else if (!common.quiet)
    PrintFleet(fleet);
}

bool HasNoResult(const UnitRow& row) {
  return row.status == "error" || row.status == "missing";
}

}  // namespace raygrid
