#include "fleet/population_estimation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "camera/lens_displacements.h"
#include "fleet/area_polynomials.h"

namespace raygrid {
namespace {

// Smooth displacements have one coefficient per polynomial, first for x and
// then for y. The mean square of each polynomial over the area is 1, so a
// coefficient is an RMS displacement.
constexpr int kDisplacementDegree = 7;
constexpr int kNumShapes = NumPolynomials(kDisplacementDegree);
constexpr int kNumFactors = 2 * kNumShapes;

Eigen::VectorXd EvaluateShapes(const Area& area, const Eigen::Vector2d& pixel) {
  Eigen::VectorXd shapes =
      EvaluatePolynomials(area, pixel, kDisplacementDegree);
  int k = 0;
  for (int sum = 0; sum <= kDisplacementDegree; ++sum)
    for (int j = 0; j <= sum; ++j, ++k)
      shapes[k] *= std::sqrt((2 * (sum - j) + 1) * (2 * j + 1));
  return shapes;
}

// Fits coefficients to displacements over an area.
class SmoothFactors {
 public:
  explicit SmoothFactors(const Area& area) : area_(area) {
    constexpr int kColumns = 32, kRows = 24;
    for (int j = 0; j < kRows; ++j)
      for (int i = 0; i < kColumns; ++i) {
        positions_.emplace_back(area.x0 + area.width() * (i + 0.5) / kColumns,
                                area.y0 + area.height() * (j + 0.5) / kRows);
        shapes_.push_back(EvaluateShapes(area, positions_.back()));
      }
  }
  const std::vector<Eigen::Vector2d>& positions() const { return positions_; }

  // Pixels without a value are ignored.
  Eigen::VectorXd Of(const PixelField& displacements) const {
    constexpr double kHold = 1e-3;
    Eigen::MatrixXd square =
        kHold * Eigen::MatrixXd::Identity(kNumShapes, kNumShapes);
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(kNumShapes, 2);
    for (size_t i = 0; i < positions_.size(); ++i) {
      if (!displacements[i]) continue;
      square.noalias() += shapes_[i] * shapes_[i].transpose();
      right += shapes_[i] * displacements[i]->transpose();
    }
    const Eigen::MatrixXd factors = square.llt().solve(right);
    return Eigen::Map<const Eigen::VectorXd>(factors.data(), kNumFactors);
  }

  // Returns the coefficients' covariance according to the uncertainty stored in
  // a unit's file.
  Eigen::MatrixXd ComputeErrors(const CameraFile& unit) const {
    constexpr double kMinPx = 1e-4;
    // The effective number of independent residuals in an image.
    constexpr double kRestVarianceDivisor = 192;
    Eigen::MatrixXd errors =
        kMinPx * kMinPx * Eigen::MatrixXd::Identity(kNumFactors, kNumFactors);
    if (!unit.uncertainty) return errors;
    const ErrorModes& modes = unit.uncertainty->modes;
    errors.diagonal().array() +=
        modes.residual_px * modes.residual_px / kRestVarianceDivisor;
    for (size_t m = 0; m < modes.displacements_px.size(); ++m) {
      PixelField field;
      for (const Eigen::Vector2d& place : positions_)
        field.emplace_back(modes.At(m, unit.camera->area(), place));
      const Eigen::VectorXd factors = Of(field);
      errors.noalias() += factors * factors.transpose();
    }
    return errors;
  }

 private:
  Area area_;
  std::vector<Eigen::Vector2d> positions_;
  std::vector<Eigen::VectorXd> shapes_;
};

// Returns the maximum-likelihood estimate of C for zero-mean differences with
// covariance C plus their individual error covariances (expectation
// maximization).
Eigen::MatrixXd EstimateMaxLikelihoodCovariance(
    const std::vector<Eigen::VectorXd>& differences,
    const std::vector<Eigen::MatrixXd>& errors) {
  constexpr int kRounds = 60;
  const double count = static_cast<double>(differences.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kNumFactors, kNumFactors);
  for (const Eigen::VectorXd& difference : differences)
    covariance += difference * difference.transpose() / count;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kNumFactors, kNumFactors);
    for (size_t u = 0; u < differences.size(); ++u) {
      const Eigen::LLT<Eigen::MatrixXd> root(covariance + errors[u]);
      const Eigen::MatrixXd whitened = root.matrixL().solve(covariance);
      const Eigen::VectorXd expected = covariance * root.solve(differences[u]);
      sum += expected * expected.transpose() + covariance -
             whitened.transpose() * whitened;
    }
    covariance = (sum + sum.transpose()) / (2 * count);
  }
  return covariance;
}

// Returns the principal directions with standard deviations that are not
// negligible.
std::vector<Eigen::VectorXd> Directions(const Eigen::MatrixXd& covariance) {
  constexpr double kMinPx = 0.002;
  constexpr int kMost = 24;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  std::vector<Eigen::VectorXd> directions;
  for (int k = kNumFactors - 1; k >= 0; --k) {
    const double stddev_px = std::sqrt(std::max(eigen.eigenvalues()[k], 0.0));
    if (stddev_px < kMinPx || directions.size() == kMost) break;
    Eigen::VectorXd direction = stddev_px * eigen.eigenvectors().col(k);
    Eigen::Index largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    directions.push_back(direction[largest] < 0 ? Eigen::VectorXd(-direction)
                                                : direction);
  }
  return directions;
}

}  // namespace

std::optional<PopulationCovariance> EstimatePopulationCovariance(
    const CameraModel& mean, const std::vector<CameraFile>& units) {
  constexpr size_t kFewest = 8;
  if (units.size() < kFewest) return std::nullopt;
  const Area& area = mean.area();
  const SmoothFactors factors(area);
  std::vector<Eigen::VectorXd> differences;
  std::vector<Eigen::MatrixXd> errors;
  const double count = static_cast<double>(units.size());
  Eigen::MatrixXd mean_covariance =
      Eigen::MatrixXd::Zero(kNumFactors, kNumFactors);
  for (const CameraFile& unit : units) {
    differences.push_back(factors.Of(
        ComputeDisplacements(mean, *unit.camera, factors.positions())));
    errors.push_back(factors.ComputeErrors(unit));
    mean_covariance += errors.back() / (count * count);
  }
  // Corrects the bias: units are closer to their own mean than a new unit is.
  const Eigen::MatrixXd covariance =
      (count + 1) / (count - 1) *
          EstimateMaxLikelihoodCovariance(differences, errors) +
      mean_covariance;
  constexpr int kColumns = 17;
  constexpr int kMinRows = 5;
  PopulationCovariance spread;
  spread.columns = kColumns;
  spread.rows = std::clamp(static_cast<int>(std::lround(
                               (kColumns - 1) * area.height() / area.width())) +
                               1,
                           kMinRows, 2 * kColumns);
  const std::vector<Eigen::Vector2d> positions = spread.GetPositions(area);
  for (const Eigen::VectorXd& direction : Directions(covariance)) {
    auto& field = spread.displacements_px.emplace_back();
    for (const Eigen::Vector2d& place : positions) {
      const Eigen::VectorXd shapes = EvaluateShapes(area, place);
      field.emplace_back(shapes.dot(direction.head(kNumShapes)),
                         shapes.dot(direction.tail(kNumShapes)));
    }
  }
  if (spread.displacements_px.empty()) return std::nullopt;
  return spread;
}

}  // namespace raygrid
