#include "evaluation/residual_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <tuple>

namespace raygrid {
namespace {

constexpr int kBins = 8;
constexpr size_t kMinResiduals = 5;
constexpr double kHistogramExtent = 2.5;
// Mean norm of a two-dimensional standard normal variable: sqrt(pi / 2).
constexpr double kNormalMeanNorm = 1.2533141373155003;

int GetBinIndex(double value) {
  const double position =
      (value + kHistogramExtent) / (2 * kHistogramExtent) * kBins;
  return std::clamp(static_cast<int>(std::floor(position)), 0, kBins - 1);
}

// Returns the probabilities of the bins for a standard normal variable; the
// outermost bins include the tails.
std::array<double, kBins> NormalBins() {
  std::array<double, kBins> bins;
  const auto cumulative = [](double x) {
    return 0.5 * std::erfc(-x / std::sqrt(2.0));
  };
  for (int i = 0; i < kBins; ++i) {
    const double width = 2 * kHistogramExtent / kBins;
    const double left = -kHistogramExtent + i * width;
    bins[i] = (i + 1 == kBins ? 1 : cumulative(left + width)) -
              (i == 0 ? 0 : cumulative(left));
  }
  return bins;
}

double DivergenceFromNormal(const std::vector<Eigen::Vector2d>& errors) {
  double mean_norm = 0;
  for (const Eigen::Vector2d& error : errors)
    mean_norm += error.norm() / static_cast<double>(errors.size());
  if (!(mean_norm > 0)) return 0;
  std::array<std::array<double, kBins>, kBins> histogram = {};
  for (const Eigen::Vector2d& error : errors) {
    const Eigen::Vector2d scaled = error * (kNormalMeanNorm / mean_norm);
    histogram[GetBinIndex(scaled.y())][GetBinIndex(scaled.x())] +=
        1.0 / static_cast<double>(errors.size());
  }
  const std::array<double, kBins> normal = NormalBins();
  double divergence = 0;
  for (int j = 0; j < kBins; ++j)
    for (int i = 0; i < kBins; ++i)
      if (histogram[j][i] > 0)
        divergence += histogram[j][i] *
                      std::log(histogram[j][i] / (normal[j] * normal[i]));
  return divergence;
}

}  // namespace

double Quantile(std::vector<double> values, double p) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double position = p * static_cast<double>(values.size() - 1);
  const size_t low = static_cast<size_t>(position);
  const size_t high = std::min(low + 1, values.size() - 1);
  return values[low] +
         (position - static_cast<double>(low)) * (values[high] - values[low]);
}

ErrorMetrics ComputeErrorMetrics(
    const std::vector<FeatureResidual>& residuals) {
  std::vector<double> norms;
  double sum = 0;
  for (const FeatureResidual& residual : residuals) {
    norms.push_back(residual.error_px.norm());
    sum += residual.error_px.squaredNorm();
  }
  if (norms.empty()) return {};
  const double largest = *std::max_element(norms.begin(), norms.end());
  const double rms = std::sqrt(sum / static_cast<double>(norms.size()));
  const int count = static_cast<int>(norms.size());
  return {Quantile(std::move(norms), 0.5), rms, largest, count};
}

std::optional<double> ComputeNeighborCorrelation(
    const std::vector<FeatureResidual>& residuals) {
  constexpr int kMinPairs = 200;  // for a standard error of 0.05
  using Place = std::tuple<std::string, int, int, int>;
  std::map<Place, Eigen::Vector2d> errors;
  for (const FeatureResidual& r : residuals)
    errors[{r.image, r.board, r.row, r.column}] = r.error_px;
  double products = 0, squares = 0;
  int count = 0;
  const auto add = [&](const Eigen::Vector2d& error, const Place& neighbor) {
    const auto found = errors.find(neighbor);
    if (found == errors.end()) return;
    products += error.dot(found->second);
    squares += (error.squaredNorm() + found->second.squaredNorm()) / 2;
    ++count;
  };
  for (const auto& [place, error] : errors) {
    const auto& [image, board, row, column] = place;
    add(error, {image, board, row, column + 1});
    add(error, {image, board, row + 1, column});
  }
  if (count < kMinPairs || !(squares > 0)) return std::nullopt;
  return products / squares;
}

std::vector<double> ComputeCellBias(
    const std::vector<FeatureResidual>& residuals, const Area& area) {
  std::vector<std::vector<Eigen::Vector2d>> cells(kBiasCells * kBiasCells);
  for (const FeatureResidual& residual : residuals) {
    const auto cell_of = [](double position, double start, double extent) {
      return std::clamp(
          static_cast<int>((position - start) / extent * kBiasCells), 0,
          kBiasCells - 1);
    };
    const int column = cell_of(residual.pixel.x(), area.x0, area.width());
    const int row = cell_of(residual.pixel.y(), area.y0, area.height());
    cells[row * kBiasCells + column].push_back(residual.error_px);
  }
  std::vector<double> divergences;
  for (const auto& errors : cells)
    divergences.push_back(errors.size() >= kMinResiduals
                              ? DivergenceFromNormal(errors)
                              : std::numeric_limits<double>::quiet_NaN());
  return divergences;
}

std::optional<double> ComputeBias(const std::vector<FeatureResidual>& residuals,
                                  const Area& area) {
  std::vector<double> divergences;
  for (const double divergence : ComputeCellBias(residuals, area))
    if (std::isfinite(divergence)) divergences.push_back(divergence);
  if (divergences.empty()) return std::nullopt;
  return Quantile(std::move(divergences), 0.5);
}

std::optional<double> ComputeNoiseBias(
    const std::vector<FeatureResidual>& residuals, const Area& area) {
  constexpr int kDraws = 5;
  std::mt19937_64 bits(1);  // sequence is standardized
  const auto uniform = [&bits] {
    return static_cast<double>((bits() >> 11) + 1) * 0x1p-53;
  };
  std::vector<FeatureResidual> noise = residuals;
  double sum = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    for (FeatureResidual& residual : noise) {  // Box-Muller
      const double radius = std::sqrt(-2 * std::log(uniform()));
      const double angle = 2 * M_PI * uniform();
      residual.error_px = {radius * std::cos(angle), radius * std::sin(angle)};
    }
    const std::optional<double> bias = ComputeBias(noise, area);
    if (!bias) return std::nullopt;
    sum += *bias;
  }
  return sum / kDraws;
}

std::optional<double> ComputeSystematicError(
    const std::vector<FeatureResidual>& residuals, const Area& area) {
  constexpr int kCells = 10;
  constexpr size_t kMinImages = 5;
  struct Sum {
    Eigen::Vector2d error = Eigen::Vector2d::Zero();
    int count = 0;
  };
  std::map<int, std::map<std::string, Sum>> cells;
  std::set<std::string> images;
  for (const FeatureResidual& residual : residuals) {
    images.insert(residual.image);
    const Eigen::Vector2d position =
        (residual.pixel - Eigen::Vector2d(area.x0, area.y0))
            .cwiseQuotient(Eigen::Vector2d(area.width(), area.height()));
    const Eigen::Vector2i cell =
        (kCells * position.array()).floor().max(0).min(kCells - 1).cast<int>();
    Sum& sum = cells[cell.y() * kCells + cell.x()][residual.image];
    sum.error += residual.error_px;
    ++sum.count;
  }
  if (images.size() < kMinImages) return std::nullopt;
  double weighted = 0, weight = 0;
  for (const auto& [cell, sums] : cells) {
    if (sums.size() < 2) continue;
    Eigen::Vector2d total = Eigen::Vector2d::Zero();
    double squares = 0;
    for (const auto& [image, sum] : sums) {
      const Eigen::Vector2d mean = sum.error / sum.count;
      total += mean;
      squares += mean.squaredNorm();
    }
    const auto n = static_cast<double>(sums.size());
    // The mean product of two different images' means.
    weighted += n * (total.squaredNorm() - squares) / (n * (n - 1));
    weight += n;
  }
  return std::sqrt(std::max(weight > 0 ? weighted / weight : 0, 0.0));
}

std::set<std::string> FindOutlierImages(
    const std::vector<FeatureResidual>& residuals) {
  constexpr double kManyTimes = 5, kNegligiblePx = 0.02;
  std::map<std::string, std::vector<double>> norms;
  for (const FeatureResidual& r : residuals)
    norms[r.image].push_back(r.error_px.norm());
  std::vector<double> medians;
  for (const auto& [image, values] : norms)
    medians.push_back(Quantile(values, 0.5));
  const double usual = Quantile(medians, 0.5);
  std::set<std::string> apart;
  size_t i = 0;
  for (const auto& [image, values] : norms)
    if (medians[i++] > std::max(kManyTimes * usual, kNegligiblePx))
      apart.insert(image);
  return apart;
}

}  // namespace raygrid
