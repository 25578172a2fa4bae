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

// A column for each level, with 1 in the rows that have it.
Eigen::MatrixXd Indicators(const std::vector<std::string>& levels) {
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

// An orthonormal basis of what columns span.
Eigen::MatrixXd BasisOf(const Eigen::MatrixXd& columns) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  return Eigen::MatrixXd(qr.householderQ()).leftCols(qr.rank());
}

// The residual sum of squares of columns after projection to a basis.
double Remaining(const Eigen::MatrixXd& basis, const Eigen::MatrixXd& columns) {
  return (columns - basis * (basis.transpose() * columns)).squaredNorm();
}

struct GaugeTerm {
  std::string name;
  Eigen::MatrixXd without;  // a basis of the model without this term
  double freedoms = 0;      // that it adds to that model
  double size = 0;          // expected squares of a variance of 1
};

struct GaugeModel {
  Eigen::MatrixXd basis;
  double freedoms = 0;  // of what the model leaves
  std::vector<GaugeTerm> terms;
};

Eigen::MatrixXd Beside(const std::vector<Eigen::MatrixXd>& parts) {
  Eigen::MatrixXd all(parts[0].rows(), 0);
  for (const Eigen::MatrixXd& part : parts) {
    all.conservativeResize(Eigen::NoChange, all.cols() + part.cols());
    all.rightCols(part.cols()) = part;
  }
  return all;
}

size_t NumLevels(const std::vector<std::string>& levels) {
  return std::set<std::string>(levels.begin(), levels.end()).size();
}

GaugeModel MakeModel(const std::vector<GaugeRepeat>& repeats,
                     std::vector<std::string>* untold) {
  std::vector<std::string> goldens, persons, stations;
  for (const GaugeRepeat& repeat : repeats) {
    goldens.push_back(repeat.golden);
    persons.push_back(repeat.person);
    stations.push_back(repeat.station);
  }
  std::vector<Eigen::MatrixXd> parts = {Indicators(goldens)};
  std::vector<std::string> names = {""};
  for (const auto& [name, levels] :
       {std::pair("operator", persons), std::pair("station", stations)})
    if (NumLevels(levels) > 1) {
      parts.push_back(Indicators(levels));
      names.emplace_back(name);
    }
  GaugeModel model;
  model.basis = BasisOf(Beside(parts));
  model.freedoms = static_cast<double>(model.basis.rows() - model.basis.cols());
  for (size_t k = 1; k < parts.size(); ++k) {
    std::vector<Eigen::MatrixXd> others = parts;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    GaugeTerm term;
    term.name = names[k];
    term.without = BasisOf(Beside(others));
    term.freedoms =
        static_cast<double>(model.basis.cols() - term.without.cols());
    term.size = Remaining(term.without, parts[k]);
    if (term.freedoms > 0)
      model.terms.push_back(std::move(term));
    else
      untold->push_back(
          fmt::format("the effect of {0}s is not separable from other "
                      "differences; calibrate one golden unit at more than one "
                      "{0}, all else being equal",
                      names[k]));
  }
  return model;
}

// ---- Figures ---------------------------------------------------------------

// values: one column for each metric of a kind, combined by the mean of their
// variances.
GaugeFigure Analyse(const std::string& name, const Eigen::MatrixXd& values,
                    const GaugeModel& model) {
  GaugeFigure figure;
  figure.name = name;
  const auto num_columns = static_cast<double>(values.cols());
  const double left = Remaining(model.basis, values);
  const double variance = left / model.freedoms / num_columns;
  double sum = variance;
  for (const GaugeTerm& term : model.terms) {
    const double added = Remaining(term.without, values) - left;
    const double of_term = std::max(
        0.0, (added / num_columns - term.freedoms * variance) / term.size);
    GaugeFactor factor{term.name, std::sqrt(of_term), {}};
    if (values.cols() == 1 && variance > 0)
      factor.chance = boost::math::cdf(boost::math::complement(
          boost::math::fisher_f(term.freedoms, model.freedoms),
          std::max(0.0, added / term.freedoms / variance)));
    figure.factors.push_back(factor);
    sum += of_term;
  }
  figure.repeatability = std::sqrt(variance);
  figure.gauge = std::sqrt(sum);
  return figure;
}

void CompareWithFleet(double fleet, GaugeFigure* figure) {
  if (!(fleet > 0)) return;
  figure->fleet = fleet;
  figure->part_of_fleet = figure->gauge / fleet;
  const double unit =
      std::sqrt(std::max(0.0, fleet * fleet - figure->gauge * figure->gauge));
  if (figure->gauge > 0)
    figure->num_classes = std::floor(M_SQRT2 * unit / figure->gauge);
}

double PixelDeviation(const Eigen::MatrixXd& pixels) {
  double sum = 0;
  for (Eigen::Index k = 0; k < pixels.cols(); ++k)
    sum +=
        std::pow(DeviationByNeighbours({pixels.col(k).data(),
                                        pixels.col(k).data() + pixels.rows()}),
                 2);
  return std::sqrt(sum / static_cast<double>(pixels.cols()));
}

double FleetDeviation(const FleetInput& fleet, const std::string& name) {
  for (const FleetFigure& figure : fleet.figures)
    if (figure.name == name) return DeviationByNeighbours(figure.Scattering());
  return 0;
}

// Whether all values are known and not all are the same one.
bool Scatters(const std::vector<double>& values) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return std::all_of(values.begin(), values.end(),
                     [](double value) { return std::isfinite(value); }) &&
         *least < *most;
}

void CompareWithLimits(const FigureLimits& limits, GaugeFigure* figure) {
  const auto found = limits.find(figure->name);
  if (found == limits.end() || figure->is_logarithm) return;
  const double width = found->second.second - found->second.first;
  if (std::isfinite(width) && width > 0)
    figure->part_of_limits = 6 * figure->gauge / width;
}

}  // namespace

GaugeStudy StudyGauge(const FleetInput& input,
                      const std::vector<GaugeRepeat>& repeats,
                      const FleetInput& fleet, const FigureLimits& limits) {
  GaugeStudy study;
  if (repeats.empty()) return study;
  study.num_repeats = static_cast<int>(repeats.size());
  std::set<std::string> goldens;
  for (const GaugeRepeat& repeat : repeats) goldens.insert(repeat.golden);
  study.num_goldens = static_cast<int>(goldens.size());
  const GaugeModel model = MakeModel(repeats, &study.untold);
  study.freedoms = static_cast<int>(model.freedoms);
  if (study.freedoms == 0) {
    study.untold = {
        "no golden unit was repeated by the same operator at the same station; "
        "repeat one calibration without changes"};
    return study;
  }
  const bool has_fleet = fleet.pixels.rows() >= kFewestFleetUnits;
  if (input.pixels.cols() > 0) {
    GaugeFigure pixels = Analyse("pixels", input.pixels, model);
    if (has_fleet && fleet.pixels.cols() > 0)
      CompareWithFleet(PixelDeviation(fleet.pixels), &pixels);
    study.figures.push_back(pixels);
  }
  for (const FleetFigure& figure : input.figures) {
    const std::vector<double> values = figure.Scattering();
    if (figure.name == "sensor_temperature_c" || !Scatters(values)) continue;
    GaugeFigure analysed =
        Analyse(figure.name,
                Eigen::Map<const Eigen::VectorXd>(
                    values.data(), static_cast<Eigen::Index>(values.size())),
                model);
    analysed.is_logarithm = figure.is_positive;
    if (has_fleet)
      CompareWithFleet(FleetDeviation(fleet, figure.name), &analysed);
    CompareWithLimits(limits, &analysed);
    study.figures.push_back(analysed);
  }
  return study;
}

}  // namespace raygrid
