#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "calibration/calibration.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"
#include "experiments/experiment.h"
#include "simulation/random.h"
#include "simulation/simulated_camera_models.h"
#include "simulation/simulated_observations.h"

namespace raygrid {
namespace {

constexpr int kNumPairs = 10;
constexpr double kKnownPx = 3;  // larger errors are not linear

// A set of images, whose halves should yield the same camera.
struct ImageSet {
  std::string name;
  Dataset dataset;
  Pattern pattern;
};

ImageSet Simulated(const std::string& name, const ExperimentOptions& options,
                   double flex_m, double shared_noise_px) {
  SimulationOptions simulation;
  simulation.num_images = options.num_images;
  simulation.seed = options.seed + 1;
  simulation.board_deformation_m = flex_m;
  simulation.shared_noise_px = shared_noise_px;
  simulation.shared_noise_features = 8;
  const Pattern pattern = ChessboardPattern(30, 24, 0.02);
  return {name,
          SimulateObservations(*MakeSimulatedCamera("example", options.size),
                               pattern, simulation)
              .dataset,
          pattern};
}

std::vector<ImageSet> MakeImageSets(const ExperimentOptions& options) {
  if (options.data.features)
    return {{"user-provided", *options.data.features, options.data.pattern}};
  return {Simulated("white noise", options, 0, 0),
          Simulated("target deformation", options, 3e-4, 0),
          Simulated("correlated noise", options, 0, 0.05)};
}

// Splits the image names randomly into two halves.
std::array<std::vector<std::string>, 2> SplitInHalves(const Dataset& dataset,
                                                      Random* random) {
  std::vector<int> order(dataset.images.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  for (int i = static_cast<int>(order.size()) - 1; i > 0; --i)
    std::swap(order[i], order[random->Index(i + 1)]);
  std::array<std::vector<std::string>, 2> halves;
  for (size_t i = 0; i < order.size(); ++i)
    halves[i % 2].push_back(dataset.images[order[i]].image);
  return halves;
}

// A pixel surrounded by features of both cameras and in both valid regions, and
// its Jacobian with respect to the camera's rotation.
struct Place {
  int index = 0;  // index in the list of candidates
  Eigen::Vector2d pixel, difference_px;
  Eigen::Matrix<double, 2, 3> J_rotation;
  double stated_px = 0;        // 1 sigma of both as predicted
  double noise_stddev_px = 0;  // 1 sigma due to noise, RMS of both axes
  bool is_valid = false;
};

// Whether features surround a pixel within a maximum distance along x and y.
// Elsewhere, a camera is extrapolated.
bool IsNearFeature(const Dataset& features, const Eigen::Vector2d& pixel,
                   double near_px) {
  std::array<bool, 4> sides = {};
  for (const ImageFeatures& image : features.images)
    for (const Feature& feature : image.features) {
      const Eigen::Vector2d offset = feature.pixel - pixel;
      if (offset.lpNorm<Eigen::Infinity>() <= near_px)
        sides[(offset.x() > 0 ? 1 : 0) + (offset.y() > 0 ? 2 : 0)] = true;
    }
  return sides[0] && sides[1] && sides[2] && sides[3];
}

std::vector<Place> CollectFeaturePositions(const CalibrationResult& first,
                                           const CalibrationResult& second) {
  constexpr int kColumns = 64;
  constexpr double kNearFraction = 1 / 16.0;  // relative to the width
  const CameraModel &a = *first.camera.camera, &b = *second.camera.camera;
  const Area& area = a.area();
  const double near_px = kNearFraction * area.width();
  const auto &ua = *first.camera.uncertainty, &ub = *second.camera.uncertainty;
  std::vector<Place> places;
  int index = 0;
  const double step_px = area.width() / kColumns;
  for (double y = area.y0 + step_px / 2; y < area.y1; y += step_px)
    for (double x = area.x0 + step_px / 2; x < area.x1; x += step_px) {
      Place place;
      place.index = index++;
      place.pixel = {x, y};
      const auto ray = b.Unproject(place.pixel);
      const auto seen_at = ray ? a.Project(*ray) : std::nullopt;
      LinearizedProjection linear;
      if (!seen_at || !IsNearFeature(first.features, place.pixel, near_px) ||
          !IsNearFeature(second.features, place.pixel, near_px) ||
          !a.Linearize(*ray, &place.pixel, 1, &linear))
        continue;
      place.difference_px = *seen_at - place.pixel;
      Eigen::Matrix3d minus_cross;
      minus_cross << 0, ray->z(), -ray->y(), -ray->z(), 0, ray->x(), ray->y(),
          -ray->x(), 0;
      place.J_rotation = linear.J_point * minus_cross;
      const double stated_px[] = {ua.lattice.At(area, place.pixel),
                                  ub.lattice.At(b.area(), place.pixel)};
      if (!(std::max(stated_px[0], stated_px[1]) <= kKnownPx)) continue;
      place.stated_px = std::hypot(stated_px[0], stated_px[1]);
      place.noise_stddev_px = std::hypot(ua.scatter.At(area, place.pixel),
                                         ub.scatter.At(b.area(), place.pixel));
      place.is_valid =
          ua.mask.IsValidAt(place.pixel) && ub.mask.IsValidAt(place.pixel);
      places.push_back(place);
    }
  return places;
}

// Removes the rotation, a gauge freedom, by iteratively reweighted least
// squares: weights decrease with the uncertainty, and for differences that
// exceed the prediction.
void RemoveRotation(std::vector<Place>* places) {
  constexpr int kSteps = 10;
  constexpr double kFar = 2;  // standard deviations
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Place& place : *places) {
      const double far = place.difference_px.norm() / (kFar * place.stated_px);
      const Eigen::Matrix<double, 3, 2> weighted =
          place.J_rotation.transpose() /
          (std::pow(place.stated_px, 2) * std::max(1.0, far));
      square += weighted * place.J_rotation;
      right += weighted * place.difference_px;
    }
    const Eigen::Vector3d rotation = square.ldlt().solve(right);
    for (Place& place : *places)
      place.difference_px -= place.J_rotation * rotation;
  }
}

// Sums over pixels: of squared differences per coordinate, of predicted
// variances and of noise variances; and the ratios of squared differences to
// both variances.
struct Spread {
  double difference2 = 0, stated2 = 0, squared_noise = 0;
  std::vector<double> stated_variances, noise_variances;

  void Add(const Place& place) {
    const double own2 = place.difference_px.squaredNorm() / 2;
    const double own_stated2 = place.stated_px * place.stated_px;
    const double own_scatter2 = place.noise_stddev_px * place.noise_stddev_px;
    difference2 += own2;
    stated2 += own_stated2;
    squared_noise += own_scatter2;
    stated_variances.push_back(own2 / own_stated2);
    noise_variances.push_back(own2 / own_scatter2);
  }
  void Add(const Spread& other) {
    const auto append = [](const std::vector<double>& from,
                           std::vector<double>* to) {
      to->insert(to->end(), from.begin(), from.end());
    };
    difference2 += other.difference2;
    stated2 += other.stated2;
    squared_noise += other.squared_noise;
    append(other.stated_variances, &stated_variances);
    append(other.noise_variances, &noise_variances);
  }
  int count() const { return static_cast<int>(stated_variances.size()); }
};

double RootMean(const std::vector<double>& squares) {
  double sum = 0;
  for (const double square : squares) sum += square;
  return std::sqrt(sum / static_cast<double>(squares.size()));
}

// Returns a robust RMS: it approximates the RMS for two independent normal
// axes, is smaller if all pixels are displaced equally, and ignores a few
// outliers.
double ComputeTypicalRoot(const std::vector<double>& squares) {
  constexpr double kMedianOfSquaredNormal =
      M_LN2;  // for half the sum of two squares
  return std::sqrt(Quantile(squares, 0.5) / kMedianOfSquaredNormal);
}

struct Repetition {
  Spread valid_region, known;
  // Each pixel's difference relative to its noise.
  std::map<int, Eigen::Vector2d> by_scatter;
};

// Returns the 90 % interval of the RMS of this many independent standard normal
// numbers, from the quantiles of chi-squared (Wilson and Hilferty 1931).
std::array<double, 2> ComputeRandomRange(double numbers) {
  constexpr double kQuantile95 = 1.6449;
  const double variance = 2 / (9 * numbers);
  const auto root = [&](double sign) {
    const double cube_root =
        1 - variance + sign * kQuantile95 * std::sqrt(variance);
    return std::pow(std::max(0.0, cube_root), 1.5);
  };
  return {root(-1), root(1)};
}

// Returns the effective number of independent differences, estimated from all
// pairs: independent random fields with n degrees of freedom have a mean
// squared cosine of 1 / n.
std::optional<double> ComputeIndependentParameters(
    const std::vector<std::optional<Repetition>>& repetitions) {
  std::map<int, size_t> times;
  size_t num_pairs = 0;
  for (const auto& repetition : repetitions) {
    if (!repetition) continue;
    ++num_pairs;
    for (const auto& place : repetition->by_scatter) ++times[place.first];
  }
  std::vector<Eigen::VectorXd> fields;
  for (const auto& repetition : repetitions) {
    if (!repetition) continue;
    std::vector<double> field;
    for (const auto& [index, difference] : repetition->by_scatter)
      if (times[index] == num_pairs)
        field.insert(field.end(), difference.begin(), difference.end());
    fields.push_back(Eigen::Map<const Eigen::VectorXd>(
        field.data(), static_cast<Eigen::Index>(field.size())));
  }
  double sum = 0, count = 0;
  for (size_t i = 0; i < fields.size(); ++i)
    for (size_t j = 0; j < i; ++j, ++count)
      sum += std::pow(fields[i].normalized().dot(fields[j].normalized()), 2);
  if (!(sum > 0)) return std::nullopt;
  return static_cast<double>(num_pairs) * count / sum;
}

// Calibrates from both halves, with the knot spacing and per-view deformation
// selected for all images together.
std::optional<Repetition> Repeat(const ImageSet& set,
                                 const CalibrationResult& all, uint64_t seed) {
  Random random(seed);
  std::vector<CalibrationResult> results;
  for (const std::vector<std::string>& half :
       SplitInHalves(set.dataset, &random)) {
    CalibrationOptions calibration;
    calibration.num_threads = 1;
    calibration.knot_spacing_px = all.knot_spacing_px;
    calibration.rigid_board = !all.bends;
    calibration.hold_out = half;
    calibration.duplicate_px = 0;
    results.push_back(Calibrate(set.dataset, set.pattern, calibration));
    if (!results.back().camera.uncertainty) return std::nullopt;
  }
  std::vector<Place> places = CollectFeaturePositions(results[0], results[1]);
  if (places.empty()) return std::nullopt;
  RemoveRotation(&places);
  Repetition repetition;
  for (const Place& place : places) {
    repetition.known.Add(place);
    repetition.by_scatter[place.index] =
        place.difference_px / place.noise_stddev_px;
    if (place.is_valid) repetition.valid_region.Add(place);
  }
  return repetition;
}

std::vector<std::optional<Repetition>> RepeatAll(
    const ImageSet& set, const ExperimentOptions& options) {
  CalibrationOptions calibration;
  calibration.num_threads = options.num_threads;
  const CalibrationResult together =
      Calibrate(set.dataset, set.pattern, calibration);
  std::vector<std::optional<Repetition>> repetitions(kNumPairs);
  ParallelFor(kNumPairs, NumThreads(options.num_threads), [&](int k) {
    try {
      repetitions[k] = Repeat(set, together, options.seed + k);
    } catch (const Error&) {
      // Half of the images may not suffice.
    }
  });
  return repetitions;
}

std::vector<Cell> MakeRow(const std::string& set, const std::string& pair,
                          const Repetition& repetition,
                          const std::optional<double>& numbers) {
  const auto chance = [&](int end) -> Cell {
    if (!numbers) return std::string("none");
    return ComputeRandomRange(*numbers)[end];
  };
  const Spread &valid_region = repetition.valid_region,
               &known = repetition.known;
  const auto root = [&](double sum, double count) -> Cell {
    if (valid_region.count() == 0) return std::string("none");
    return std::sqrt(sum / count);
  };
  return {set,
          pair,
          valid_region.count(),
          root(valid_region.difference2, valid_region.count()),
          root(valid_region.stated2, valid_region.count()),
          root(valid_region.difference2, valid_region.stated2),
          root(valid_region.difference2, valid_region.squared_noise),
          known.count(),
          RootMean(known.stated_variances),
          ComputeTypicalRoot(known.stated_variances),
          RootMean(known.noise_variances),
          ComputeTypicalRoot(known.noise_variances),
          chance(0),
          chance(1)};
}

}  // namespace

ExperimentResult MeasureRepeatability(const ExperimentOptions& options) {
  ExperimentResult table;
  table.columns = {"set",
                   "pair",
                   "trusted_places",
                   "trusted_px",
                   "stated_px",
                   "trusted_ratio",
                   "trusted_scatter_ratio",
                   "known_places",
                   "known_ratio",
                   "known_median_ratio",
                   "known_scatter_ratio",
                   "known_median_scatter_ratio",
                   "chance_least",
                   "chance_most"};
  table.chart.title = "Calibrations of random halves of the images";
  table.chart.note =
      "difference divided by the predicted uncertainty (1: exact prediction), "
      "RMS over pixels near features, predicted below 3 px";
  table.chart.x_label = "pair of halves";
  table.chart.y_label = "ratio";
  for (int k = 1; k <= kNumPairs; ++k)
    table.chart.ticks.push_back({double(k), std::to_string(k)});
  const std::vector<ImageSet> sets = MakeImageSets(options);
  for (size_t i = 0; i < sets.size(); ++i) {
    const auto repetitions = RepeatAll(sets[i], options);
    ChartSeries ratios = {sets[i].name, {}, false};
    Repetition all;
    for (int k = 0; k < kNumPairs; ++k) {
      if (!repetitions[k]) continue;
      const Repetition& own = *repetitions[k];
      table.rows.push_back(
          MakeRow(sets[i].name, std::to_string(k + 1), own, {}));
      ratios.points.push_back({k + 1.0, RootMean(own.known.noise_variances)});
      all.valid_region.Add(own.valid_region);
      all.known.Add(own.known);
    }
    if (all.known.count() == 0)
      throw Error(
          ExitCode::kInsufficientData,
          "no two halves give overlapping valid regions; use more images");
    table.rows.push_back(MakeRow(sets[i].name, "all", all,
                                 ComputeIndependentParameters(repetitions)));
    table.chart.series.push_back(ratios);
    if (options.progress)
      options.progress(static_cast<double>(i + 1) /
                       static_cast<double>(sets.size()));
  }
  table.conditions = {
      {"halves",
       fmt::format("{} pairs of calibrations, each from one half of the images",
                   kNumPairs)},
      {"ratio",
       "difference per axis relative to the predicted standard deviation, "
       "smoothing bias included: RMS over the common valid region; RMS and "
       "median over all pixels near features and predicted below 3 px in both"},
      {"scatter ratio",
       "relative to the effect of noise alone, mean of both axes: smoothing "
       "bias is common to both cameras"},
      {"chance",
       "90 % interval of the scatter ratio if the prediction is exact, with "
       "the effective number of degrees of freedom estimated from the "
       "similarity of pairs"}};
  return table;
}

}  // namespace raygrid
