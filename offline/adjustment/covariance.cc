#include "adjustment/covariance.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "adjustment/normal_equations.h"

namespace raygrid {
namespace {

constexpr int kMinObservations = 3;  // around a pixel that is trusted

// How the projections of the lattice's rays move, two rows a pixel: with the
// parameters, and when the camera turns.
struct LatticeDerivatives {
  Eigen::MatrixXd by_parameters;
  Eigen::MatrixX3d by_rotation;
};

void AddPixel(const CameraModel& camera, const Eigen::Vector2d& pixel,
              Eigen::Index row, LatticeDerivatives* derivatives) {
  const auto ray = camera.Unproject(pixel);
  LinearizedProjection linear;
  if (!ray || !camera.Linearize(*ray, &pixel, 1, &linear)) return;
  auto rows = derivatives->by_parameters.middleRows<2>(row);
  for (int k = 0; k < linear.num_nodes; ++k)
    rows.middleCols(linear.node_parameter[k], linear.num_per_node) +=
        linear.node_weight[k] * linear.by_node.leftCols(linear.num_per_node);
  if (linear.num_global > 0)
    rows.middleCols(linear.first_global, linear.num_global) +=
        linear.by_global.leftCols(linear.num_global);
  Eigen::Matrix3d minus_cross;            // omega x ray = -[ray]x omega
  minus_cross << 0, ray->z(), -ray->y(),  //
      -ray->z(), 0, ray->x(),             //
      ray->y(), -ray->x(), 0;
  derivatives->by_rotation.middleRows<2>(row) = linear.by_point * minus_cross;
}

std::vector<PixelUncertainty> LatticePixels(const Area& area,
                                            const UncertaintyLattice& lattice) {
  std::vector<PixelUncertainty> pixels(lattice.columns * lattice.rows);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const int column = static_cast<int>(i) % lattice.columns;
    const int row = static_cast<int>(i) / lattice.columns;
    const double x = area.width() * column / (lattice.columns - 1);
    const double y = area.height() * row / (lattice.rows - 1);
    pixels[i].pixel = {std::min(area.x0 + x, area.x1),
                       std::min(area.y0 + y, area.y1)};
  }
  return pixels;
}

void CountObservations(const std::vector<View>& views, int camera,
                       const Area& area, const UncertaintyLattice& lattice,
                       std::vector<PixelUncertainty>* pixels) {
  const auto nearest = [](double position, double start, double extent,
                          int count) {
    const double index = (position - start) / extent * (count - 1);
    return std::clamp(static_cast<int>(std::lround(index)), 0, count - 1);
  };
  for (const View& view : views) {
    if (view.camera != camera) continue;
    for (const Observation& o : view.observations) {
      const int column =
          nearest(o.pixel.x(), area.x0, area.width(), lattice.columns);
      const int row =
          nearest(o.pixel.y(), area.y0, area.height(), lattice.rows);
      ++(*pixels)[row * lattice.columns + column].num_observations;
    }
  }
}

}  // namespace

double PixelUncertainty::StandardDeviationPx() const {
  const double mean = covariance_px2.trace() / 2;
  const double root =
      std::sqrt(std::max(0.0, mean * mean - covariance_px2.determinant()));
  return std::sqrt(mean + root);
}

std::vector<PixelUncertainty> ProjectionUncertainty(
    const std::vector<View>& views, const GaussianPrior& prior,
    const AdjustmentOptions& options, double noise_px,
    const AdjustmentState& state, int camera,
    const UncertaintyLattice& lattice) {
  const FixedParameters fixed = {false, options.fix_points};
  const ParameterLayout layout(state, fixed);
  const CameraModel& model = *state.cameras[camera];
  std::vector<PixelUncertainty> pixels = LatticePixels(model.area(), lattice);
  CountObservations(views, camera, model.area(), lattice, &pixels);

  LatticeDerivatives derivatives;
  const Eigen::Index num_rows = 2 * static_cast<Eigen::Index>(pixels.size());
  derivatives.by_parameters.setZero(num_rows, model.NumParameters());
  derivatives.by_rotation.setZero(num_rows, 3);
  for (size_t i = 0; i < pixels.size(); ++i)
    AddPixel(model, pixels[i].pixel, 2 * static_cast<Eigen::Index>(i),
             &derivatives);

  // J H^-1 J^T, column by column.
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(layout.size, num_rows);
  right.middleRows(layout.first_camera[camera], model.NumParameters()) =
      derivatives.by_parameters.transpose();
  Eigen::MatrixXd solution;
  EquationsBuilder builder(views, options.huber_px, options.num_threads);
  if (!builder.Build(prior, fixed, state)->SolveFor(0, right, &solution))
    return {};
  Eigen::MatrixXd covariance =
      derivatives.by_parameters *
      solution.middleRows(layout.first_camera[camera], model.NumParameters());

  // The rotation of least squares over pixels among observations is taken out
  // on both sides.
  const Eigen::MatrixXd& r = derivatives.by_rotation;
  Eigen::MatrixXd supported = r;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (pixels[i].num_observations < kMinObservations)
      supported.middleRows<2>(2 * static_cast<Eigen::Index>(i)).setZero();
  const Eigen::Matrix3d square = supported.transpose() * supported;
  const Eigen::LDLT<Eigen::Matrix3d> turns(square);
  covariance -= r * turns.solve(supported.transpose() * covariance);
  covariance -= (covariance * supported) * turns.solve(r.transpose());
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Matrix2d block = covariance.block<2, 2>(
        2 * static_cast<Eigen::Index>(i), 2 * static_cast<Eigen::Index>(i));
    pixels[i].covariance_px2 =
        noise_px * noise_px * (block + block.transpose()) / 2;
  }
  return pixels;
}

std::vector<bool> TrustMask(const std::vector<PixelUncertainty>& pixels,
                            double max_px) {
  std::vector<bool> mask;
  for (const PixelUncertainty& pixel : pixels)
    mask.push_back(pixel.num_observations >= kMinObservations &&
                   pixel.StandardDeviationPx() <= max_px);
  return mask;
}

}  // namespace raygrid
