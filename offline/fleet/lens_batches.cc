#include "fleet/lens_batches.h"

#include <Eigen/LU>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <map>
#include <set>

#include "fleet/principal_directions.h"

namespace raygrid {
namespace {

using UnitsByBatch = std::map<std::string, std::vector<int>>;

UnitsByBatch SelectUnits(const std::vector<std::string>& batches,
                         const std::vector<OutlierUnit>& outliers) {
  std::set<int> excluded_units;
  for (const OutlierUnit& unit : outliers) excluded_units.insert(unit.unit);
  UnitsByBatch chosen;
  for (int u = 0; u < static_cast<int>(batches.size()); ++u)
    if (!batches[u].empty() && excluded_units.count(u) == 0)
      chosen[batches[u]].push_back(u);
  for (auto it = chosen.begin(); it != chosen.end();)
    it = static_cast<int>(it->second.size()) < kMinBatchUnits ? chosen.erase(it)
                                                              : std::next(it);
  if (chosen.size() < 2) chosen.clear();
  return chosen;
}

double ComputePValue(double f, double degrees_of_freedom,
                     double freedoms_within) {
  if (!std::isfinite(f)) return f > 0 ? 0 : 1;
  return boost::math::cdf(boost::math::complement(
      boost::math::fisher_f(degrees_of_freedom, freedoms_within),
      std::max(f, 0.0)));
}

double ComputeMean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

BatchedMetric CompareMetric(const FleetMetric& metric,
                            const UnitsByBatch& units) {
  BatchedMetric compared;
  compared.name = metric.name;
  const std::vector<double> values = metric.TransformedValues();
  std::vector<std::vector<double>> groups;
  std::vector<double> all;
  for (const auto& batch : units) {
    groups.emplace_back();
    for (const int unit : batch.second) {
      const double value = values[unit];
      if (!std::isfinite(value)) continue;
      groups.back().push_back(value);
      all.push_back(value);
    }
    const double mean = ComputeMean(groups.back());
    compared.means.push_back(metric.is_positive ? std::exp(mean) : mean);
  }
  double between = 0, within = 0, num_groups = 0, squares = 0;
  for (const std::vector<double>& group : groups) {
    if (group.empty()) continue;
    ++num_groups;
    const double mean = ComputeMean(group);
    between += static_cast<double>(group.size()) *
               std::pow(mean - ComputeMean(all), 2);
    for (const double value : group) {
      within += std::pow(value - mean, 2);
      squares += value * value;
    }
  }
  const double degrees_of_freedom = num_groups - 1,
               freedoms_within = static_cast<double>(all.size()) - num_groups;
  constexpr double kRounding = 1e-24;  // rounding error, relative to the sum of
                                       // squares of equal values
  if (degrees_of_freedom < 1 || freedoms_within < 1 ||
      between + within <= kRounding * squares)
    return compared;
  compared.within_batch_stddev = std::sqrt(within / freedoms_within);
  compared.p_value =
      ComputePValue(between / degrees_of_freedom / (within / freedoms_within),
                    degrees_of_freedom, freedoms_within);
  return compared;
}

// Returns Pillai's trace of the lenses' coefficients along the principal
// directions, and its F approximation.
BatchedMetric CompareProjections(const Eigen::MatrixXd& pixels,
                                 const UnitsByBatch& units) {
  BatchedMetric compared;
  compared.name = "lens";
  std::vector<int> rows;
  for (const auto& batch : units)
    rows.insert(rows.end(), batch.second.begin(), batch.second.end());
  const auto count = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd chosen(count, pixels.cols());
  for (Eigen::Index i = 0; i < count; ++i) chosen.row(i) = pixels.row(rows[i]);
  chosen.rowwise() -= chosen.colwise().mean().eval();
  const Eigen::MatrixXd scores =
      chosen *
      ComputeDirections(chosen, std::vector<bool>(rows.size(), true)).axes;
  const Eigen::MatrixXd total = scores.transpose() * scores;
  Eigen::MatrixXd between = Eigen::MatrixXd::Zero(total.rows(), total.cols());
  Eigen::Index begin = 0;
  for (const auto& batch : units) {
    const auto size = static_cast<Eigen::Index>(batch.second.size());
    const Eigen::RowVectorXd mean =
        scores.middleRows(begin, size).colwise().mean();
    between += static_cast<double>(size) * mean.transpose() * mean;
    begin += size;
  }
  const auto p = static_cast<double>(scores.cols());
  const double degrees_of_freedom = static_cast<double>(units.size()) - 1,
               freedoms_within =
                   static_cast<double>(count) - degrees_of_freedom - 1;
  const double s = std::min(p, degrees_of_freedom);
  const double t = freedoms_within - p + s;
  const double trace = total.fullPivLu().solve(between).trace();
  if (!(t > 0) || !std::isfinite(trace)) return compared;
  const double larger = std::max(p, degrees_of_freedom);
  compared.p_value =
      ComputePValue(t * trace / (larger * (s - trace)), s * larger, s * t);
  return compared;
}

}  // namespace

BatchComparison CompareLensBatches(const FleetInput& input,
                                   const std::vector<std::string>& batches,
                                   const std::vector<OutlierUnit>& outliers) {
  BatchComparison comparison;
  const UnitsByBatch units = SelectUnits(batches, outliers);
  if (units.empty() || input.pixels.cols() == 0) return comparison;
  for (const auto& batch : units) {
    comparison.batches.push_back(batch.first);
    comparison.num_units.push_back(static_cast<int>(batch.second.size()));
  }
  comparison.metrics.push_back(CompareProjections(input.pixels, units));
  for (const FleetMetric& metric : input.metrics)
    comparison.metrics.push_back(CompareMetric(metric, units));
  const auto num_metrics = static_cast<double>(comparison.metrics.size());
  for (BatchedMetric& metric : comparison.metrics)
    metric.differs = metric.p_value < kFleetFalseAlarmProbability / num_metrics;
  return comparison;
}

}  // namespace raygrid
