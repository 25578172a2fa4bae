#include "fleet/robust_series.h"

#include <algorithm>
#include <cmath>

namespace raygrid {

double Median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  const auto median = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), median, values.end());
  return *median;
}

double EstimateNeighbourStdDev(const std::vector<double>& values) {
  std::vector<double> differences;
  for (size_t i = 1; i < values.size(); ++i)
    if (const double difference = std::abs(values[i] - values[i - 1]);
        std::isfinite(difference))
      differences.push_back(difference);
  constexpr double kDifferenceMedian = 0.6744897502 * M_SQRT2;
  return differences.empty() ? 0 : Median(differences) / kDifferenceMedian;
}

std::vector<double> ClipOutliers(const std::vector<double>& values,
                                 double deviation) {
  constexpr int kWidth = 5;
  constexpr double kMaxSigmas = 3;
  std::vector<double> clipped = values;
  const int count = static_cast<int>(values.size());
  for (int i = 0; i < count; ++i) {
    std::vector<double> near;
    for (int k = std::max(0, i - kWidth); k <= std::min(count - 1, i + kWidth);
         ++k)
      if (std::isfinite(values[k])) near.push_back(values[k]);
    if (near.empty()) continue;
    const double median = Median(near), most = kMaxSigmas * deviation;
    clipped[i] = std::isfinite(values[i])
                     ? std::clamp(values[i], median - most, median + most)
                     : median;
  }
  return clipped;
}

std::vector<double> ComputeSegmentMedians(const std::vector<double>& values,
                                          const std::vector<int>& cuts) {
  std::vector<double> median(values.size());
  int begin = 0;
  for (size_t k = 0; k <= cuts.size(); ++k) {
    const int end = k < cuts.size() ? cuts[k] : static_cast<int>(values.size());
    std::vector<double> known;
    for (int i = begin; i < end; ++i)
      if (std::isfinite(values[i])) known.push_back(values[i]);
    std::fill(median.begin() + begin, median.begin() + end, Median(known));
    begin = end;
  }
  return median;
}

std::vector<double> FitRobustLine(const std::vector<double>& values) {
  const std::vector<double> clipped =
      ClipOutliers(values, EstimateNeighbourStdDev(values));
  const auto count = static_cast<double>(values.size());
  const double center_index = (count - 1) / 2;
  double mean = 0, products = 0, squares = 0, num_known = 0;
  for (const double value : clipped)
    if (std::isfinite(value)) {
      mean += value;
      ++num_known;
    }
  mean /= num_known;
  for (size_t i = 0; i < clipped.size(); ++i)
    if (const double place = static_cast<double>(i) - center_index;
        std::isfinite(clipped[i])) {
      products += place * (clipped[i] - mean);
      squares += place * place;
    }
  std::vector<double> line;
  for (size_t i = 0; i < clipped.size(); ++i)
    line.push_back(mean + products / squares *
                              (static_cast<double>(i) - center_index));
  return line;
}

}  // namespace raygrid
