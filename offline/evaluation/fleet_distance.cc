#include "evaluation/fleet_distance.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "camera/lens_displacements.h"

namespace raygrid {
namespace {

// Returns the Jacobian of the mean camera's projections with respect to a
// rotation about each axis, two rows per pixel; zero where the camera is
// undefined.
Eigen::MatrixXd ComputeRotationJacobian(
    const CameraModel& mean, const std::vector<Eigen::Vector2d>& positions) {
  Eigen::MatrixXd J_rotation = Eigen::MatrixXd::Zero(2 * positions.size(), 3);
  for (size_t i = 0; i < positions.size(); ++i) {
    const auto ray = mean.Unproject(positions[i]);
    LinearizedProjection projection;
    if (!ray || !mean.Linearize(*ray, &positions[i], 1, &projection)) continue;
    Eigen::Matrix3d cross;  // w -> w x ray
    cross << 0, ray->z(), -ray->y(), -ray->z(), 0, ray->x(), ray->y(),
        -ray->x(), 0;
    J_rotation.middleRows<2>(2 * i) = projection.J_point * cross;
  }
  return J_rotation;
}

Eigen::MatrixXd StackVectors(const PopulationCovariance& spread,
                             const Area& area,
                             const std::vector<Eigen::Vector2d>& positions) {
  const std::vector<BSplineSurface> surfaces = spread.FitSurfaces(area);
  Eigen::MatrixXd columns(2 * positions.size(), surfaces.size());
  for (size_t k = 0; k < surfaces.size(); ++k)
    for (size_t i = 0; i < positions.size(); ++i)
      columns.block<2, 1>(2 * i, k) = surfaces[k].Evaluate(positions[i]);
  return columns;
}

// Returns the sum of squares of the columns after removing rotations.
double SumSquaresWithoutRotation(const Eigen::MatrixXd& J_rotation,
                                 const Eigen::MatrixXd& columns) {
  return (columns -
          J_rotation * J_rotation.colPivHouseholderQr().solve(columns))
      .squaredNorm();
}

// Returns the sum of squared distances between the rays of the camera and those
// of the mean.
double SquaredDistances(const CameraModel& mean, const CameraModel& camera,
                        const std::vector<Eigen::Vector2d>& positions) {
  const PixelField field = ComputeDisplacements(mean, camera, positions);
  std::vector<Eigen::Vector2d> projected;
  for (size_t i = 0; i < positions.size(); ++i)
    if (field[i]) projected.push_back(positions[i]);
  Eigen::VectorXd moved(2 * projected.size());
  Eigen::Index row = 0;
  for (const auto& displacement : field)
    if (displacement) {
      moved.segment<2>(row) = *displacement;
      row += 2;
    }
  const double out_of_area_cost =
      static_cast<double>(positions.size() - projected.size()) *
      std::pow(kDisplacementMarginPx, 2);
  return out_of_area_cost +
         SumSquaresWithoutRotation(ComputeRotationJacobian(mean, projected),
                                   moved);
}

double ComputeSquaredStdDevs(const CameraModel& camera,
                             const UncertaintyLattice& deviations,
                             const std::vector<Eigen::Vector2d>& positions) {
  double sum = 0;
  for (const Eigen::Vector2d& place : positions) {
    const double stddev_px = deviations.At(camera.area(), place);
    if (std::isfinite(stddev_px)) sum += 2 * std::pow(stddev_px, 2);
  }
  return sum;
}

}  // namespace

bool FleetDistance::IsOutlier() const {
  constexpr double kTimesUnits = 5, kMinPx = 0.1;
  return rms_px > std::max(kMinPx, kTimesUnits * units_px);
}

std::string FleetDistance::Text() const {
  // Uses two significant digits, or all integer digits.
  const auto digits = [](double px) {
    return px < 99.5 ? fmt::format("{:.2g}", px) : fmt::format("{:.0f}", px);
  };
  return fmt::format(
      "{} px RMS from the population mean at the features, compared with {} px "
      "for the units of the fleet",
      digits(rms_px), digits(units_px));
}

std::string FleetDistance::Warning() const {
  return fmt::format(
      "this camera is an outlier of its fleet ({}): if its lens type or focus "
      "differs, calibrate it without 'prior', which biases the camera where it "
      "has no features",
      Text());
}

std::optional<FleetDistance> MeasureFleetDistance(
    const CameraModel& mean, const PopulationCovariance& spread,
    const CameraModel& camera, const UncertaintyLattice* deviations,
    const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<Eigen::Vector2d> positions;
  for (const Eigen::Vector2d& pixel : pixels)
    if (mean.area().Contains(pixel)) positions.push_back(pixel);
  if (positions.empty()) return std::nullopt;
  const double count = static_cast<double>(positions.size());
  double population_part =
      SumSquaresWithoutRotation(ComputeRotationJacobian(mean, positions),
                                StackVectors(spread, mean.area(), positions));
  if (deviations)
    population_part += ComputeSquaredStdDevs(camera, *deviations, positions);
  return FleetDistance{
      std::sqrt(SquaredDistances(mean, camera, positions) / count),
      std::sqrt(population_part / count)};
}

}  // namespace raygrid
