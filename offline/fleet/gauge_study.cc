#include "fleet/gauge_study.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <map>
#include <set>

#include "fleet/robust_series.h"

namespace raygrid {
namespace {

// ---- The linear model ------------------------------------------------------

// Returns the indicator variables: one column per level, with 1 in the rows of
// that level.
Eigen::MatrixXd MakeIndicators(const std::vector<std::string>& levels) {
  std::map<std::string, Eigen::Index> columns;
  for (const std::string& level : levels) columns.emplace(level, 0);
  Eigen::Index next = 0;
  for (auto& column : columns) column.second = next++;
  Eigen::MatrixXd indicators =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(levels.size()), next);
  for (size_t i = 0; i < levels.size(); ++i)
    indicators(static_cast<Eigen::Index>(i), columns[levels[i]]) = 1;
  return indicators;
}

// Returns an orthonormal basis of the column space.
Eigen::MatrixXd ComputeBasis(const Eigen::MatrixXd& columns) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  return Eigen::MatrixXd(qr.householderQ()).leftCols(qr.rank());
}

// Returns the residual sum of squares after projection of columns onto a basis.
double ComputeRemaining(const Eigen::MatrixXd& basis,
                        const Eigen::MatrixXd& columns) {
  return (columns - basis * (basis.transpose() * columns)).squaredNorm();
}

struct GaugeTerm {
  std::string name;
  Eigen::MatrixXd without_term;   // basis of the model without this term
  double degrees_of_freedom = 0;  // degrees of freedom of this term
  double size = 0;                // factor of this term's variance in the
                                  // expected sum of squares
};

struct GaugeModel {
  Eigen::MatrixXd basis;
  double degrees_of_freedom = 0;  // degrees of freedom of the residuals
  std::vector<GaugeTerm> terms;
};

Eigen::MatrixXd ConcatenateColumns(const std::vector<Eigen::MatrixXd>& parts) {
  Eigen::MatrixXd all(parts[0].rows(), 0);
  for (const Eigen::MatrixXd& part : parts) {
    all.conservativeResize(Eigen::NoChange, all.cols() + part.cols());
    all.rightCols(part.cols()) = part;
  }
  return all;
}

size_t CountFactorLevels(const std::vector<std::string>& levels) {
  return std::set<std::string>(levels.begin(), levels.end()).size();
}

GaugeModel MakeModel(const std::vector<GaugeRepeat>& repeats,
                     std::vector<std::string>* unobservable_reason) {
  std::vector<std::string> goldens, persons, stations;
  for (const GaugeRepeat& repeat : repeats) {
    goldens.push_back(repeat.golden);
    persons.push_back(repeat.person);
    stations.push_back(repeat.station);
  }
  std::vector<Eigen::MatrixXd> parts = {MakeIndicators(goldens)};
  std::vector<std::string> names = {""};
  for (const auto& [name, levels] :
       {std::pair("operator", persons), std::pair("station", stations)})
    if (CountFactorLevels(levels) > 1) {
      parts.push_back(MakeIndicators(levels));
      names.emplace_back(name);
    }
  GaugeModel model;
  model.basis = ComputeBasis(ConcatenateColumns(parts));
  model.degrees_of_freedom =
      static_cast<double>(model.basis.rows() - model.basis.cols());
  for (size_t k = 1; k < parts.size(); ++k) {
    std::vector<Eigen::MatrixXd> others = parts;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    GaugeTerm term;
    term.name = names[k];
    term.without_term = ComputeBasis(ConcatenateColumns(others));
    term.degrees_of_freedom =
        static_cast<double>(model.basis.cols() - term.without_term.cols());
    term.size = ComputeRemaining(term.without_term, parts[k]);
    if (term.degrees_of_freedom > 0)
      model.terms.push_back(std::move(term));
    else
      unobservable_reason->push_back(
          fmt::format("the effect of {0}s cannot be separated from other "
                      "differences; calibrate a golden unit at more than one "
                      "{0}, with everything else unchanged",
                      names[k]));
  }
  return model;
}

// ---- Metrics ---------------------------------------------------------------

// values: one column per metric of a kind; their variances are averaged.
GaugeMetric AnalyzeMetric(const std::string& name,
                          const Eigen::MatrixXd& values,
                          const GaugeModel& model) {
  GaugeMetric metric;
  metric.name = name;
  const auto num_columns = static_cast<double>(values.cols());
  const double left = ComputeRemaining(model.basis, values);
  const double variance = left / model.degrees_of_freedom / num_columns;
  double sum = variance;
  for (const GaugeTerm& term : model.terms) {
    const double added = ComputeRemaining(term.without_term, values) - left;
    const double term_variance = std::max(
        0.0,
        (added / num_columns - term.degrees_of_freedom * variance) / term.size);
    GaugeFactor factor{term.name, std::sqrt(term_variance), {}};
    if (values.cols() == 1 && variance > 0)
      factor.p_value = boost::math::cdf(boost::math::complement(
          boost::math::fisher_f(term.degrees_of_freedom,
                                model.degrees_of_freedom),
          std::max(0.0, added / term.degrees_of_freedom / variance)));
    metric.factors.push_back(factor);
    sum += term_variance;
  }
  metric.repeatability = std::sqrt(variance);
  metric.gauge = std::sqrt(sum);
  return metric;
}

void CompareWithFleet(double fleet, GaugeMetric* metric) {
  if (!(fleet > 0)) return;
  metric->fleet = fleet;
  metric->fraction_of_fleet = metric->gauge / fleet;
  const double unit =
      std::sqrt(std::max(0.0, fleet * fleet - metric->gauge * metric->gauge));
  if (metric->gauge > 0)
    metric->num_classes = std::floor(M_SQRT2 * unit / metric->gauge);
}

double ComputePixelStdDev(const Eigen::MatrixXd& pixels) {
  double sum = 0;
  for (Eigen::Index k = 0; k < pixels.cols(); ++k)
    sum += std::pow(
        EstimateNeighbourStdDev(
            {pixels.col(k).data(), pixels.col(k).data() + pixels.rows()}),
        2);
  return std::sqrt(sum / static_cast<double>(pixels.cols()));
}

double ComputeFleetStdDev(const FleetInput& fleet, const std::string& name) {
  for (const FleetMetric& metric : fleet.metrics)
    if (metric.name == name)
      return EstimateNeighbourStdDev(metric.TransformedValues());
  return 0;
}

// Whether all values are known, and they are not all equal.
bool HasVariation(const std::vector<double>& values) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return std::all_of(values.begin(), values.end(),
                     [](double value) { return std::isfinite(value); }) &&
         *least < *most;
}

void CompareWithLimits(const MetricLimits& limits, GaugeMetric* metric) {
  const auto found = limits.find(metric->name);
  if (found == limits.end() || metric->is_logarithm) return;
  const double width = found->second.second - found->second.first;
  if (std::isfinite(width) && width > 0)
    metric->fraction_of_limits = 6 * metric->gauge / width;
}

}  // namespace

GaugeStudy StudyGauge(const FleetInput& input,
                      const std::vector<GaugeRepeat>& repeats,
                      const FleetInput& fleet, const MetricLimits& limits) {
  GaugeStudy study;
  if (repeats.empty()) return study;
  study.num_repeats = static_cast<int>(repeats.size());
  std::set<std::string> goldens;
  for (const GaugeRepeat& repeat : repeats) goldens.insert(repeat.golden);
  study.num_goldens = static_cast<int>(goldens.size());
  const GaugeModel model = MakeModel(repeats, &study.unobservable_reason);
  study.degrees_of_freedom = static_cast<int>(model.degrees_of_freedom);
  if (study.degrees_of_freedom == 0) {
    study.unobservable_reason = {
        "no golden unit was repeated by the same operator at the same station; "
        "repeat one calibration without changes"};
    return study;
  }
  const bool has_fleet = fleet.pixels.rows() >= kMinFleetUnits;
  if (input.pixels.cols() > 0) {
    GaugeMetric pixels = AnalyzeMetric("pixels", input.pixels, model);
    if (has_fleet && fleet.pixels.cols() > 0)
      CompareWithFleet(ComputePixelStdDev(fleet.pixels), &pixels);
    study.metrics.push_back(pixels);
  }
  for (const FleetMetric& metric : input.metrics) {
    const std::vector<double> values = metric.TransformedValues();
    if (metric.name == "sensor_temperature_c" || !HasVariation(values))
      continue;
    GaugeMetric analysed = AnalyzeMetric(
        metric.name,
        Eigen::Map<const Eigen::VectorXd>(
            values.data(), static_cast<Eigen::Index>(values.size())),
        model);
    analysed.is_logarithm = metric.is_positive;
    if (has_fleet)
      CompareWithFleet(ComputeFleetStdDev(fleet, metric.name), &analysed);
    CompareWithLimits(limits, &analysed);
    study.metrics.push_back(analysed);
  }
  return study;
}

}  // namespace raygrid
