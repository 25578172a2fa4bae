#include "fleet/mean_changes.h"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "fleet/robust_series.h"

namespace raygrid {
namespace {

// A segment [begin, end) of a series.
struct SeriesSegment {
  int begin = 0, end = 0;
};

// A standardized series, and its cumulative sums.
struct StandardSeries {
  std::vector<double> values, sums;

  double ComputeMean(const SeriesSegment& segment) const {
    return (sums[segment.end] - sums[segment.begin]) /
           (segment.end - segment.begin);
  }
};

std::vector<StandardSeries> Standardize(
    const std::vector<std::vector<double>>& series) {
  std::vector<StandardSeries> all;
  for (const std::vector<double>& values : series) {
    const double deviation = EstimateNeighbourStdDev(values);
    if (!(deviation > 0)) continue;
    StandardSeries standard{ClipOutliers(values, deviation), {0}};
    for (double& value : standard.values) {
      value = std::isfinite(value) ? value / deviation : 0;
      standard.sums.push_back(standard.sums.back() + value);
    }
    all.push_back(std::move(standard));
  }
  return all;
}

// Splits a segment at the largest change of the means, if the sum of squared
// changes exceeds the limit, and recurses into both segments.
void FindJumps(const std::vector<StandardSeries>& series,
               const SeriesSegment& segment, double limit,
               std::vector<MeanJump>* jumps) {
  constexpr int kFewest = 5;
  MeanJump best;
  for (int cut = segment.begin + kFewest; cut + kFewest <= segment.end; ++cut) {
    const double variance =
        1.0 / (cut - segment.begin) + 1.0 / (segment.end - cut);
    double squares = 0;
    for (const StandardSeries& one : series)
      squares += std::pow(one.ComputeMean({cut, segment.end}) -
                              one.ComputeMean({segment.begin, cut}),
                          2) /
                 variance;
    if (squares > best.sigmas * best.sigmas)
      best = {"", cut, 0, 0, std::sqrt(squares)};
  }
  if (!(best.sigmas * best.sigmas > limit)) return;
  FindJumps(series, {segment.begin, best.unit}, limit, jumps);
  jumps->push_back(best);
  FindJumps(series, {best.unit, segment.end}, limit, jumps);
}

// Returns the sum of squares explained by piecewise constant means, in addition
// to a single mean.
double ComputeExplainedBySegments(const StandardSeries& series,
                                  const std::vector<int>& cuts) {
  const int count = static_cast<int>(series.values.size());
  const double mean = series.ComputeMean({0, count});
  double explained = 0;
  int begin = 0;
  for (size_t k = 0; k <= cuts.size(); ++k) {
    const int end = k < cuts.size() ? cuts[k] : count;
    explained +=
        (end - begin) * std::pow(series.ComputeMean({begin, end}) - mean, 2);
    begin = end;
  }
  return explained;
}

double ComputeExplainedByLine(const StandardSeries& series) {
  const auto count = static_cast<double>(series.values.size());
  double products = 0;
  for (size_t i = 0; i < series.values.size(); ++i)
    products += (static_cast<double>(i) - (count - 1) / 2) * series.values[i];
  return products * products / (count * (count * count - 1) / 12);
}

}  // namespace

std::vector<int> MeanChanges::Cuts() const {
  std::vector<int> cuts;
  for (const MeanJump& jump : jumps) cuts.push_back(jump.unit);
  return cuts;
}

MeanChanges FindMeanChanges(const std::vector<std::vector<double>>& series,
                            double false_alarm_probability) {
  MeanChanges changes;
  const std::vector<StandardSeries> standard = Standardize(series);
  if (standard.empty()) return changes;
  const int count = static_cast<int>(standard[0].values.size());
  // The limit for a sum of squares of normal values with an estimated standard
  // deviation.
  const auto size = static_cast<double>(standard.size());
  const boost::math::fisher_f f(size, count - size - 1);
  const auto compute_limit = [&](double segment) {
    return size * (count - 2) / (count - size - 1) *
           boost::math::quantile(boost::math::complement(f, segment));
  };
  FindJumps(standard, {0, count},
            compute_limit(false_alarm_probability / 2 / count), &changes.jumps);
  double explained_by_segments = 0, explained_by_line = 0;
  for (const StandardSeries& one : standard) {
    explained_by_segments += ComputeExplainedBySegments(one, changes.Cuts());
    explained_by_line += ComputeExplainedByLine(one);
  }
  // The number of parameters: for each jump, a position, and a mean per series;
  // for the line, a slope per series.
  const double penalty = std::log(count);
  const auto num_jumps = static_cast<double>(changes.jumps.size());
  if (explained_by_line > compute_limit(false_alarm_probability / 2) &&
      explained_by_line - size * penalty >=
          explained_by_segments - num_jumps * (size + 1) * penalty)
    changes = {{}, {{"", 0, 0, std::sqrt(explained_by_line)}}};
  return changes;
}

std::vector<double> ComputeCenterLine(const std::vector<double>& values,
                                      const MeanChanges& changes) {
  return changes.drifts.empty() ? ComputeSegmentMedians(values, changes.Cuts())
                                : FitRobustLine(values);
}

}  // namespace raygrid
