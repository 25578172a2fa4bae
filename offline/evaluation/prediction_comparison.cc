#include "evaluation/prediction_comparison.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace raygrid {
namespace {

constexpr double kMaxPValue = 0.01;
constexpr size_t kMaxExactCount = 100;

using Key = std::tuple<std::string, int, int, int>;

Key MakeFeatureKey(const FeatureResidual& residual) {
  return {residual.image, residual.board, residual.column, residual.row};
}

// Returns the probability that, of the ranks 1 to n with random signs, the
// positive ones have a sum of at most `sum` (exact Wilcoxon signed-rank test).
double ExactProbability(size_t n, size_t sum) {
  std::vector<double> probability(n * (n + 1) / 2 + 1, 0);
  probability[0] = 1;
  for (size_t rank = 1; rank <= n; ++rank)
    for (size_t s = probability.size(); s-- > 0;)
      probability[s] =
          (probability[s] + (s >= rank ? probability[s - rank] : 0)) / 2;
  double total = 0;
  for (size_t s = 0; s <= sum; ++s) total += probability[s];
  return total;
}

double NormalProbability(size_t n, size_t sum) {
  const double count = static_cast<double>(n);
  const double mean = count * (count + 1) / 4;
  const double deviation =
      std::sqrt(count * (count + 1) * (2 * count + 1) / 24);
  const double below = (mean - static_cast<double>(sum) - 0.5) / deviation;
  return std::erfc(below / std::sqrt(2)) / 2;
}

}  // namespace

double SignedRankProbability(std::vector<double> differences) {
  differences.erase(std::remove(differences.begin(), differences.end(), 0.0),
                    differences.end());
  std::stable_sort(
      differences.begin(), differences.end(),
      [](double a, double b) { return std::abs(a) < std::abs(b); });
  const size_t n = differences.size();
  size_t above = 0;
  for (size_t i = 0; i < n; ++i)
    if (differences[i] > 0) above += i + 1;
  const size_t lesser = std::min(above, n * (n + 1) / 2 - above);
  return std::min(1.0,
                  2 * (n <= kMaxExactCount ? ExactProbability(n, lesser)
                                           : NormalProbability(n, lesser)));
}

const char* PredictionComparison::NameBetterCamera() const {
  if (probability > kMaxPValue) return "neither";
  return num_first_better > num_second_better ? "first" : "second";
}

PredictionComparison ComparePredictions(
    const std::vector<FeatureResidual>& first,
    const std::vector<FeatureResidual>& second) {
  std::map<Key, const FeatureResidual*> second_by_key;
  for (const FeatureResidual& residual : second)
    second_by_key[MakeFeatureKey(residual)] = &residual;
  std::vector<FeatureResidual> common[2];
  std::map<std::string, ImagePrediction> images;
  for (const FeatureResidual& residual : first) {
    const auto found = second_by_key.find(MakeFeatureKey(residual));
    if (found == second_by_key.end()) continue;
    common[0].push_back(residual);
    common[1].push_back(*found->second);
    ImagePrediction& image = images[residual.image];
    image.first_px += residual.error_px.norm();
    image.second_px += found->second->error_px.norm();
    ++image.num_features;
  }

  PredictionComparison comparison;
  comparison.first = ComputeErrorMetrics(common[0]);
  comparison.second = ComputeErrorMetrics(common[1]);
  comparison.num_left_out =
      static_cast<int>(first.size() + second.size() - 2 * common[0].size());
  std::vector<double> differences;
  for (auto& [name, image] : images) {
    image.image = name;
    image.first_px /= image.num_features;
    image.second_px /= image.num_features;
    differences.push_back(image.second_px - image.first_px);
    comparison.num_first_better += differences.back() > 0;
    comparison.num_second_better += differences.back() < 0;
    comparison.images.push_back(image);
  }
  comparison.probability = SignedRankProbability(differences);
  return comparison;
}

}  // namespace raygrid
