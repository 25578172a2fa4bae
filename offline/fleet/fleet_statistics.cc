#include "fleet/fleet_statistics.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <map>

namespace raygrid {
namespace {

constexpr double kChance = 0.05;  // of any alarm in a usual fleet

double Median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The value that a standard normal one exceeds with that chance.
double NormalAt(double chance) {
  return boost::math::quantile(
      boost::math::complement(boost::math::normal(), chance));
}

// The standard deviation by the differences of neighbours, which neither jumps
// nor outliers enlarge.
double DeviationByNeighbours(const std::vector<double>& values) {
  std::vector<double> differences;
  for (size_t i = 1; i < values.size(); ++i)
    if (const double difference = std::abs(values[i] - values[i - 1]);
        std::isfinite(difference))
      differences.push_back(difference);
  constexpr double kMedianOfDifference = 0.6744897502 * M_SQRT2;
  return differences.empty() ? 0 : Median(differences) / kMedianOfDifference;
}

// A series without its extreme values, which are no jumps.
std::vector<double> Clipped(const std::vector<double>& values,
                            double deviation) {
  constexpr int kWidth = 5;
  constexpr double kMostSigmas = 3;
  std::vector<double> clipped = values;
  const int count = static_cast<int>(values.size());
  for (int i = 0; i < count; ++i) {
    std::vector<double> near;
    for (int k = std::max(0, i - kWidth); k <= std::min(count - 1, i + kWidth);
         ++k)
      if (std::isfinite(values[k])) near.push_back(values[k]);
    if (near.empty()) continue;
    const double middle = Median(near), most = kMostSigmas * deviation;
    clipped[i] = std::isfinite(values[i])
                     ? std::clamp(values[i], middle - most, middle + most)
                     : middle;
  }
  return clipped;
}

// A part of a series, from begin up to end.
struct Part {
  int begin = 0, end = 0;
};

double MeanOf(const std::vector<double>& values, const Part& part) {
  double sum = 0;
  for (int i = part.begin; i < part.end; ++i) sum += values[i];
  return sum / (part.end - part.begin);
}

// Series that jump together, in standard deviations of theirs.
using Standardized = std::vector<std::vector<double>>;

// Cuts a part where the means change most, if the sum of the changes' squares
// is beyond the limit, and searches both.
void FindJumps(const Standardized& series, const Part& part, double limit,
               std::vector<MeanJump>* jumps) {
  constexpr int kFewest = 5;
  MeanJump best;
  for (int cut = part.begin + kFewest; cut + kFewest <= part.end; ++cut) {
    const double variance = 1.0 / (cut - part.begin) + 1.0 / (part.end - cut);
    double squares = 0;
    for (const std::vector<double>& values : series)
      squares += std::pow(MeanOf(values, {cut, part.end}) -
                              MeanOf(values, {part.begin, cut}),
                          2) /
                 variance;
    if (squares > best.sigmas * best.sigmas)
      best = {"", cut, 0, 0, std::sqrt(squares)};
  }
  if (!(best.sigmas * best.sigmas > limit)) return;
  FindJumps(series, {part.begin, best.unit}, limit, jumps);
  jumps->push_back(best);
  FindJumps(series, {best.unit, part.end}, limit, jumps);
}

// The middle of the part that each unit is in.
std::vector<double> MiddleOfParts(const std::vector<double>& values,
                                  const std::vector<int>& cuts) {
  std::vector<double> middle(values.size());
  int begin = 0;
  for (size_t k = 0; k <= cuts.size(); ++k) {
    const int end = k < cuts.size() ? cuts[k] : static_cast<int>(values.size());
    std::vector<double> known;
    for (int i = begin; i < end; ++i)
      if (std::isfinite(values[i])) known.push_back(values[i]);
    std::fill(middle.begin() + begin, middle.begin() + end, Median(known));
    begin = end;
  }
  return middle;
}

// Principal directions of rows, and the variance along each.
struct Directions {
  Eigen::MatrixXd axes;  // columns
  Eigen::VectorXd variances;
};

Directions DirectionsOf(const Eigen::MatrixXd& rows,
                        const std::vector<bool>& is_usual) {
  const auto count =
      static_cast<double>(std::count(is_usual.begin(), is_usual.end(), true));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(rows.cols(), rows.cols());
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    if (is_usual[i])
      covariance.selfadjointView<Eigen::Lower>().rankUpdate(
          rows.row(i).transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance /
                                                              (count - 1));
  Directions all{solver.eigenvectors().rowwise().reverse(),
                 solver.eigenvalues().reverse()};
  // Those that make up nearly all of the variance, few against the units.
  constexpr double kPart = 0.999;
  const double total = all.variances.sum();
  const auto most = std::min<Eigen::Index>(
      all.variances.size(), static_cast<Eigen::Index>(count / 4));
  Eigen::Index size = 1;
  while (size < most && all.variances.head(size).sum() < kPart * total) ++size;
  return {all.axes.leftCols(size), all.variances.head(size)};
}

// T^2 of a new unit, of as many usual ones.
double HotellingLimit(double chance, double count, double size) {
  const boost::math::fisher_f f(size, count - size);
  return size * (count * count - 1) / (count * (count - size)) *
         boost::math::quantile(boost::math::complement(f, chance));
}

// The limit of a sum of squares by its mean and variance (Box 1954).
double SquaresLimit(double chance, const std::vector<double>& usual) {
  double mean = 0, variance = 0;
  for (const double value : usual) mean += value / usual.size();
  for (const double value : usual)
    variance += (value - mean) * (value - mean) / (usual.size() - 1.0);
  if (!(mean > 0 && variance > 0)) return std::numeric_limits<double>::max();
  const double freedoms = 2 * mean * mean / variance;
  const boost::math::chi_squared distribution(freedoms);
  return variance / (2 * mean) *
         boost::math::quantile(boost::math::complement(distribution, chance));
}

// The two charts of lenses whose jumps are taken out, and the directions.
struct LensCharts {
  std::vector<double> lens, shape;
  double lens_limit = 0, shape_limit = 0;
  Directions directions;
};

// Limits come from usual units alone: those beyond them are left out, and all
// is reckoned again.
LensCharts ChartLenses(const Eigen::MatrixXd& rows, double chance) {
  const auto count = static_cast<size_t>(rows.rows());
  std::vector<bool> is_usual(count, true);
  // At first the half that is nearest to the middle, by each pixel.
  std::vector<double> distances;
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    distances.push_back(rows.row(i).squaredNorm());
  const double median = Median(distances);
  for (size_t i = 0; i < count; ++i) is_usual[i] = distances[i] <= 4 * median;
  LensCharts charts;
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    charts.directions = DirectionsOf(rows, is_usual);
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
    // Units so far off would widen the limit that is to tell them.
    constexpr double kFarOff = 20;
    const double far_off = kFarOff * Median(charts.shape);
    for (size_t i = 0; i < count; ++i)
      if (is_usual[i] && charts.shape[i] <= far_off)
        usual_rest.push_back(charts.shape[i]);
    charts.lens_limit =
        HotellingLimit(chance, static_cast<double>(usual_rest.size()),
                       static_cast<double>(charts.directions.variances.size()));
    charts.shape_limit = SquaresLimit(chance, usual_rest);
    std::vector<bool> next;
    for (size_t i = 0; i < count; ++i)
      next.push_back(charts.lens[i] <= charts.lens_limit &&
                     charts.shape[i] <= charts.shape_limit);
    if (next == is_usual) break;
    is_usual = next;
  }
  return charts;
}

std::vector<double> Scattering(const FleetFigure& figure) {
  std::vector<double> values = figure.values;
  if (figure.is_positive)
    for (double& value : values)
      value = value > 0 ? std::log(value) : std::nan("");
  return values;
}

std::vector<int> CutsOf(const std::vector<MeanJump>& jumps) {
  std::vector<int> cuts;
  for (const MeanJump& jump : jumps) cuts.push_back(jump.unit);
  return cuts;
}

// Jumps of series together, with a chance that any of a steady fleet is one.
std::vector<MeanJump> JumpsOf(const std::vector<std::vector<double>>& series,
                              double chance) {
  Standardized standardized;
  for (const std::vector<double>& values : series) {
    const double deviation = DeviationByNeighbours(values);
    if (!(deviation > 0)) continue;
    standardized.push_back(Clipped(values, deviation));
    for (double& value : standardized.back()) value /= deviation;
  }
  std::vector<MeanJump> jumps;
  if (standardized.empty()) return jumps;
  const int count = static_cast<int>(series[0].size());
  // Two means of series whose scatter is estimated, too.
  const auto size = static_cast<double>(standardized.size());
  const boost::math::fisher_f f(size, count - size - 1);
  const double limit =
      size * (count - 2) / (count - size - 1) *
      boost::math::quantile(boost::math::complement(f, chance / count));
  FindJumps(standardized, {0, count}, limit, &jumps);
  return jumps;
}

// The directions in which neighbours differ, which jumps do not enlarge.
Directions NeighbourDirections(const Eigen::MatrixXd& pixels) {
  const Eigen::Index count = pixels.rows() - 1;
  const Eigen::MatrixXd differences =
      (pixels.bottomRows(count) - pixels.topRows(count)) / M_SQRT2;
  std::vector<double> sizes;
  for (Eigen::Index i = 0; i < count; ++i)
    sizes.push_back(differences.row(i).squaredNorm());
  const double most = 4 * Median(sizes);
  std::vector<bool> is_usual;
  for (const double size : sizes) is_usual.push_back(size <= most);
  return DirectionsOf(differences, is_usual);
}

}  // namespace

FleetStatistics FindOutliers(const FleetInput& input) {
  FleetStatistics statistics;
  const Eigen::Index count = input.pixels.rows();
  if (count < kFewestFleetUnits) return statistics;
  const Directions varied = NeighbourDirections(input.pixels);
  // Lenses share it with each figure.
  const double jump_chance =
      kChance / (1 + static_cast<double>(input.figures.size()));

  // The lenses, with jumps along their directions taken out.
  const Eigen::MatrixXd scores = input.pixels * varied.axes;
  std::vector<std::vector<double>> series;
  for (Eigen::Index k = 0; k < scores.cols(); ++k)
    series.emplace_back(scores.col(k).data(), scores.col(k).data() + count);
  statistics.jumps = JumpsOf(series, jump_chance);
  for (MeanJump& jump : statistics.jumps) jump.name = "lens";
  const std::vector<int> cuts = CutsOf(statistics.jumps);
  Eigen::MatrixXd rows = input.pixels;
  for (Eigen::Index k = 0; k < rows.cols(); ++k) {
    const std::vector<double> middle =
        MiddleOfParts({rows.col(k).data(), rows.col(k).data() + count}, cuts);
    rows.col(k) -= Eigen::Map<const Eigen::VectorXd>(middle.data(), count);
  }
  const double chance =
      kChance / (static_cast<double>(2 + input.figures.size()) * count);
  LensCharts lenses = ChartLenses(rows, chance);
  statistics.num_directions =
      static_cast<int>(lenses.directions.variances.size());
  const std::vector<double> zeros(count, 0.0);
  const double none = -std::numeric_limits<double>::infinity();
  statistics.charts.push_back(
      {"lens", lenses.lens, zeros, none, lenses.lens_limit});
  statistics.charts.push_back(
      {"shape", lenses.shape, zeros, none, lenses.shape_limit});

  for (const FleetFigure& figure : input.figures) {
    const std::vector<double> values = Scattering(figure);
    std::vector<MeanJump> jumps = JumpsOf({values}, jump_chance);
    const std::vector<double> middle =
        MiddleOfParts(figure.values, CutsOf(jumps));
    for (MeanJump& jump : jumps) {
      jump.name = figure.name;
      jump.before = middle[jump.unit - 1];
      jump.after = middle[jump.unit];
    }
    statistics.jumps.insert(statistics.jumps.end(), jumps.begin(), jumps.end());
    const double most = NormalAt(chance / 2) * DeviationByNeighbours(values);
    statistics.charts.push_back({figure.name, values,
                                 MiddleOfParts(values, CutsOf(jumps)), -most,
                                 most});
  }
  std::stable_sort(
      statistics.jumps.begin(), statistics.jumps.end(),
      [](const MeanJump& a, const MeanJump& b) { return a.unit < b.unit; });

  std::map<int, std::vector<std::string>> unusual;
  for (const ControlChart& chart : statistics.charts)
    for (int i = 0; i < count; ++i) {
      const double offset = chart.values[i] - chart.middle[i];
      if (offset < chart.lower || offset > chart.upper)
        unusual[i].push_back(chart.name);
    }
  for (auto& [unit, charts] : unusual)
    statistics.unusual.push_back({unit, charts});
  return statistics;
}

}  // namespace raygrid
