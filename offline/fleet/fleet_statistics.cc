#include "fleet/fleet_statistics.h"

#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "fleet/principal_directions.h"
#include "fleet/robust_series.h"

namespace raygrid {
namespace {

// Returns the control limit in standard deviations for a probability, if the
// standard deviation is estimated by EstimateNeighbourStdDev(), which has
// 0.31 times as many degrees of freedom as values.
double ComputeSigmaLimit(double false_alarm_probability, double count) {
  return boost::math::quantile(boost::math::complement(
      boost::math::students_t(0.31 * count), false_alarm_probability));
}

// Returns the limit of T^2 for a new unit, from count inliers.
double ComputeHotellingLimit(double false_alarm_probability, double count,
                             double size) {
  const boost::math::fisher_f f(size, count - size);
  return size * (count * count - 1) / (count * (count - size)) *
         boost::math::quantile(
             boost::math::complement(f, false_alarm_probability));
}

// Returns the limit of a sum of squares, from the mean and variance over the
// units (Box 1954).
double SquaresLimit(double false_alarm_probability,
                    const std::vector<double>& usual) {
  double mean = 0, variance = 0;
  for (const double value : usual) mean += value / usual.size();
  for (const double value : usual)
    variance += (value - mean) * (value - mean) / (usual.size() - 1.0);
  if (!(mean > 0 && variance > 0)) return std::numeric_limits<double>::max();
  const double degrees_of_freedom = 2 * mean * mean / variance;
  const boost::math::fisher_f distribution(degrees_of_freedom,
                                           static_cast<double>(usual.size()));
  return mean * boost::math::quantile(boost::math::complement(
                    distribution, false_alarm_probability));
}

// Returns the limit of T^2 for a unit that contributed to the directions and
// variances (Tracy, Young, Mason, "Multivariate control charts for individual
// observations", 1992): its T^2 cannot exceed (n - 1)^2 / n, unlike that of a
// new unit.
double ComputeHotellingLimitOfOthers(double false_alarm_probability,
                                     double count, double num_directions) {
  const double rest = count - num_directions - 1;
  if (rest < 1) return INFINITY;
  const boost::math::beta_distribution<> distribution(num_directions / 2,
                                                      rest / 2);
  return (count - 1) * (count - 1) / count *
         boost::math::quantile(
             boost::math::complement(distribution, false_alarm_probability));
}

// Returns the design matrix of the mean: one column for each segment, or a
// line.
Eigen::MatrixXd MakeMeanDesign(const MeanChanges& changes, Eigen::Index count) {
  if (!changes.drifts.empty()) {
    Eigen::MatrixXd line(count, 2);
    line << Eigen::VectorXd::Ones(count),
        Eigen::VectorXd::LinSpaced(count, -1, 1);
    return line;
  }
  std::vector<int> ends = changes.Cuts();
  ends.push_back(static_cast<int>(count));
  Eigen::MatrixXd parts = Eigen::MatrixXd::Zero(count, ends.size());
  int begin = 0;
  for (size_t k = 0; k < ends.size(); ++k) {
    parts.col(k).segment(begin, ends[k] - begin).setOnes();
    begin = ends[k];
  }
  return parts;
}

// Lenses relative to the medians of pixels, and the design matrix of their
// mean.
struct CenteredProjections {
  Eigen::MatrixXd rows, means;
};

// Centres lenses about the mean of inliers, which is a possible lens. The
// medians of pixels are not: the difference would appear in the shape of all
// units of a segment.
Eigen::MatrixXd CenterAboutInliers(const CenteredProjections& lenses,
                                   const std::vector<bool>& is_usual) {
  Eigen::MatrixXd rows = lenses.rows, means = lenses.means;
  for (size_t i = 0; i < is_usual.size(); ++i)
    if (!is_usual[i]) {
      rows.row(i).setZero();
      means.row(i).setZero();
    }
  return lenses.rows -
         lenses.means * means.completeOrthogonalDecomposition().solve(rows);
}

// The two control charts of lenses after removing jumps, and the principal
// directions.
struct ProjectionCharts {
  std::vector<double> lens, shape;
  double lens_limit = 0, shape_limit = 0;
  PrincipalDirections directions;
};

// A segment whose mean is distorted by an outlier would be rejected entirely
// and never recover: therefore, the half nearest to the mean is always accepted
// as inliers.
void KeepInliersBySegment(const CenteredProjections& lenses,
                          const std::vector<double>& shape,
                          std::vector<bool>* is_usual) {
  for (Eigen::Index part = 0; part < lenses.means.cols(); ++part) {
    std::vector<double> shapes;
    bool has_usual = false;
    for (size_t i = 0; i < shape.size(); ++i) {
      if (lenses.means(i, part) == 0) continue;
      shapes.push_back(shape[i]);
      has_usual = has_usual || (*is_usual)[i];
    }
    if (has_usual) continue;
    const double median = Median(shapes);
    for (size_t i = 0; i < shape.size(); ++i)
      if (lenses.means(i, part) != 0 && shape[i] <= median)
        (*is_usual)[i] = true;
  }
}

// Limits are computed from inliers only: outliers are removed iteratively.
ProjectionCharts ComputeProjectionCharts(const CenteredProjections& lenses,
                                         double false_alarm_probability) {
  const auto count = static_cast<size_t>(lenses.rows.rows());
  std::vector<bool> is_usual(count, true);
  // The initial inliers are the half closest to the median, by pixels.
  std::vector<double> distances;
  for (Eigen::Index i = 0; i < lenses.rows.rows(); ++i)
    distances.push_back(lenses.rows.row(i).squaredNorm());
  const double median = Median(distances);
  for (size_t i = 0; i < count; ++i) is_usual[i] = distances[i] <= 4 * median;
  ProjectionCharts charts;
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::MatrixXd rows = CenterAboutInliers(lenses, is_usual);
    charts.directions = ComputeDirections(rows, is_usual);
    const Eigen::MatrixXd scores = rows * charts.directions.axes;
    const Eigen::VectorXd rest =
        (rows - scores * charts.directions.axes.transpose())
            .rowwise()
            .squaredNorm();
    charts.lens.clear();
    charts.shape.assign(rest.data(), rest.data() + rest.size());
    std::vector<double> usual_rest;
    for (size_t i = 0; i < count; ++i) {
      charts.lens.push_back((scores.row(i).array().square() /
                             charts.directions.variances.transpose().array())
                                .sum());
    }
    // Extreme outliers would inflate the control limit and mask themselves.
    constexpr double kMaxMedianRatio = 20;
    const double max_shape = kMaxMedianRatio * Median(charts.shape);
    for (size_t i = 0; i < count; ++i)
      if (is_usual[i] && charts.shape[i] <= max_shape)
        usual_rest.push_back(charts.shape[i]);
    charts.lens_limit = ComputeHotellingLimit(
        false_alarm_probability, static_cast<double>(usual_rest.size()),
        static_cast<double>(charts.directions.variances.size()));
    charts.shape_limit = SquaresLimit(false_alarm_probability, usual_rest);
    const double hotelling_limit = ComputeHotellingLimitOfOthers(
        false_alarm_probability, static_cast<double>(usual_rest.size()),
        static_cast<double>(charts.directions.variances.size()));
    std::vector<bool> next;
    for (size_t i = 0; i < count; ++i)
      next.push_back(charts.lens[i] <=
                         (is_usual[i] ? hotelling_limit : charts.lens_limit) &&
                     charts.shape[i] <= charts.shape_limit);
    KeepInliersBySegment(lenses, charts.shape, &next);
    if (next == is_usual) break;
    is_usual = next;
  }
  return charts;
}

// Returns the principal directions of differences between neighbouring units,
// which are robust to jumps.
PrincipalDirections NeighbourDirections(const Eigen::MatrixXd& pixels) {
  const Eigen::Index count = pixels.rows() - 1;
  const Eigen::MatrixXd differences =
      (pixels.bottomRows(count) - pixels.topRows(count)) / M_SQRT2;
  std::vector<double> sizes;
  for (Eigen::Index i = 0; i < count; ++i)
    sizes.push_back(differences.row(i).squaredNorm());
  const double most = 4 * Median(sizes);
  std::vector<bool> is_usual;
  for (const double size : sizes) is_usual.push_back(size <= most);
  return ComputeDirections(differences, is_usual);
}

void AppendChanges(const std::string& name, const MeanChanges& changes,
                   FleetStatistics* statistics) {
  for (MeanJump jump : changes.jumps) {
    jump.name = name;
    statistics->jumps.push_back(jump);
  }
  for (MeanDrift drift : changes.drifts) {
    drift.name = name;
    statistics->drifts.push_back(drift);
  }
}

// Removes the changes of the mean along the principal directions.
CenteredProjections CenterAboutMean(const Eigen::MatrixXd& pixels,
                                    double false_alarm_probability,
                                    FleetStatistics* statistics) {
  const Eigen::Index count = pixels.rows();
  const Eigen::MatrixXd scores = pixels * NeighbourDirections(pixels).axes;
  std::vector<std::vector<double>> series;
  for (Eigen::Index k = 0; k < scores.cols(); ++k)
    series.emplace_back(scores.col(k).data(), scores.col(k).data() + count);
  const MeanChanges changes = FindMeanChanges(series, false_alarm_probability);
  AppendChanges("lens", changes, statistics);
  Eigen::MatrixXd rows = pixels;
  for (Eigen::Index k = 0; k < rows.cols(); ++k) {
    const std::vector<double> center_line = ComputeCenterLine(
        {rows.col(k).data(), rows.col(k).data() + count}, changes);
    rows.col(k) -= Eigen::Map<const Eigen::VectorXd>(center_line.data(), count);
  }
  return {rows, MakeMeanDesign(changes, count)};
}

void AddMetricChart(const FleetMetric& metric, double false_alarm_probability,
                    double change_probability, FleetStatistics* statistics) {
  const std::vector<double> values = metric.TransformedValues();
  MeanChanges changes = FindMeanChanges({values}, change_probability);
  const std::vector<double> center_line = ComputeCenterLine(values, changes);
  const auto get_metric = [&](double value) {
    return metric.is_positive ? std::exp(value) : value;
  };
  for (MeanJump& jump : changes.jumps) {
    jump.before = get_metric(center_line[jump.unit - 1]);
    jump.after = get_metric(center_line[jump.unit]);
  }
  for (MeanDrift& drift : changes.drifts) {
    drift.first = get_metric(center_line.front());
    drift.last = get_metric(center_line.back());
  }
  AppendChanges(metric.name, changes, statistics);
  // No limit can be estimated if most neighbours are equal, for example due to
  // few digits.
  const double deviation = EstimateNeighbourStdDev(values);
  const auto count = static_cast<double>(values.size());
  const double most =
      deviation > 0
          ? ComputeSigmaLimit(false_alarm_probability / 2, count) * deviation
          : std::numeric_limits<double>::infinity();
  statistics->charts.push_back(
      {metric.name, values, center_line, -most, most, metric.is_positive});
}

std::vector<OutlierUnit> FindOutlierUnits(
    const std::vector<ControlChart>& charts) {
  std::map<int, std::vector<std::string>> outliers;
  for (const ControlChart& chart : charts)
    for (size_t i = 0; i < chart.values.size(); ++i) {
      const double offset = chart.values[i] - chart.center_line[i];
      if (offset < chart.lower || offset > chart.upper)
        outliers[static_cast<int>(i)].push_back(chart.name);
    }
  std::vector<OutlierUnit> units;
  for (auto& [unit, names] : outliers) units.push_back({unit, names});
  return units;
}

}  // namespace

std::vector<double> FleetMetric::TransformedValues() const {
  std::vector<double> transformed = values;
  if (is_positive)
    for (double& value : transformed)
      value = value > 0 ? std::log(value) : std::nan("");
  return transformed;
}

FleetStatistics FindOutliers(const FleetInput& input) {
  FleetStatistics statistics;
  const Eigen::Index count = input.pixels.rows();
  if (count < kMinFleetUnits || input.pixels.cols() == 0) return statistics;
  // The false-alarm probability is split between lenses and each metric.
  const double change_probability =
      kFleetFalseAlarmProbability /
      (1 + static_cast<double>(input.metrics.size()));
  const CenteredProjections centered =
      CenterAboutMean(input.pixels, change_probability, &statistics);
  const double false_alarm_probability =
      kFleetFalseAlarmProbability /
      (static_cast<double>(2 + input.metrics.size()) * count);
  const ProjectionCharts lenses =
      ComputeProjectionCharts(centered, false_alarm_probability);
  statistics.num_directions =
      static_cast<int>(lenses.directions.variances.size());
  const std::vector<double> zeros(count, 0.0);
  const double none = -std::numeric_limits<double>::infinity();
  statistics.charts.push_back(
      {"lens", lenses.lens, zeros, none, lenses.lens_limit});
  statistics.charts.push_back(
      {"shape", lenses.shape, zeros, none, lenses.shape_limit});
  for (const FleetMetric& metric : input.metrics)
    AddMetricChart(metric, false_alarm_probability, change_probability,
                   &statistics);
  std::stable_sort(
      statistics.jumps.begin(), statistics.jumps.end(),
      [](const MeanJump& a, const MeanJump& b) { return a.unit < b.unit; });
  statistics.outliers = FindOutlierUnits(statistics.charts);
  return statistics;
}

}  // namespace raygrid
