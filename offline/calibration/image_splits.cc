#include "calibration/image_splits.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cctype>
#include <map>
#include <optional>

#include "evaluation/assessment.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// Removes the digits from a name.
std::string RemoveDigits(const std::string& name) {
  std::string stem;
  for (const char c : name)
    if (!std::isdigit(static_cast<unsigned char>(c))) stem += c;
  return stem;
}

std::optional<ImageNames> SelectFirstStem(const Dataset& dataset) {
  std::map<std::string, ImageNames> by_stem;
  for (const ImageFeatures& image : dataset.images)
    by_stem[RemoveDigits(image.image)].insert(image.image);
  if (by_stem.size() != 2) return std::nullopt;
  return by_stem.begin()->second;
}

// Splits the images by the sign of their residual fields, relative to the mean
// field, along each of the first principal directions of variation.
std::vector<ImageNames> SplitsByResiduals(
    const std::vector<FeatureResidual>& residuals, const ImageSize& size) {
  constexpr int kNumSplits = 3;
  constexpr int kCells = 3;
  constexpr int kNumValues = 2 * kCells * kCells;
  std::map<std::string, std::pair<Eigen::VectorXd, Eigen::VectorXd>> fields;
  for (const FeatureResidual& r : residuals) {
    auto& [sum, count] =
        fields
            .try_emplace(r.image, Eigen::VectorXd::Zero(kNumValues),
                         Eigen::VectorXd::Zero(kNumValues))
            .first->second;
    const auto cell = [](double x, int width) {
      return std::clamp(static_cast<int>(kCells * x / width), 0, kCells - 1);
    };
    const int k = 2 * (cell(r.pixel.y(), size.height) * kCells +
                       cell(r.pixel.x(), size.width));
    sum.segment<2>(k) += r.error_px;
    count.segment<2>(k).array() += 1;
  }
  Eigen::MatrixXd rows(fields.size(), kNumValues);
  int row = 0;
  for (const auto& [image, field] : fields)
    rows.row(row++) =
        (field.first.array() / field.second.array().max(1)).matrix();
  const Eigen::RowVectorXd mean = rows.colwise().mean();
  rows.rowwise() -= mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(rows.transpose() *
                                                              rows);
  std::vector<ImageNames> splits(kNumSplits);
  for (int k = 0; k < kNumSplits; ++k) {
    const Eigen::VectorXd along =
        rows * solver.eigenvectors().col(kNumValues - 1 - k);
    row = 0;
    for (const auto& [image, field] : fields)
      if (along[row++] > 0) splits[k].insert(image);
  }
  return splits;
}

// The first half of the sorted images, for files of two cameras in one folder.
ImageNames SelectFirstHalf(const Dataset& dataset) {
  ImageNames all;
  for (const ImageFeatures& image : dataset.images) all.insert(image.image);
  return {all.begin(), std::next(all.begin(), all.size() / 2)};
}

}  // namespace

std::vector<std::string> ListImageNames(const Dataset& dataset) {
  std::vector<std::string> names;
  for (const ImageFeatures& image : dataset.images)
    names.push_back(image.image);
  return names;
}

std::vector<ImageNames> ListSplitsToTry(
    const Dataset& dataset, const std::vector<FeatureResidual>& residuals) {
  if (const auto stems = SelectFirstStem(dataset)) return {*stems};
  std::vector<ImageNames> splits =
      SplitsByResiduals(residuals, dataset.image_size);
  splits.push_back(SelectFirstHalf(dataset));
  return splits;
}

bool HasCorrelatedErrors(const std::vector<FeatureResidual>& residuals) {
  return !residuals.empty() &&
         HasCorrelatedErrors(ComputeNeighborCorrelation(residuals).value_or(0),
                             ComputeErrorMetrics(residuals));
}

}  // namespace raygrid
