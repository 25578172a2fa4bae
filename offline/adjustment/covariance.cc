#include "adjustment/covariance.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "adjustment/dense_equations.h"
#include "adjustment/large_equations.h"
#include "adjustment/precision_root.h"
#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

constexpr int kMinObservations = 3;  // around a pixel that counts as seen

// How the projections of the lattice's rays move, two rows a pixel: with the
// parameters, and when the camera turns.
struct LatticeDerivatives {
  Eigen::MatrixXd by_parameters;
  Eigen::MatrixX3d by_rotation;
};

// False where the camera does not tell.
bool AddPixel(const CameraModel& camera, const Eigen::Vector2d& pixel,
              Eigen::Index row, LatticeDerivatives* derivatives) {
  constexpr double kFarM = 1e4;
  const auto line = camera.Line(pixel);
  LinearizedProjection linear;
  if (!line) return false;
  const Eigen::Vector3d point = line->origin + kFarM * line->direction;
  if (!camera.Linearize(point, &pixel, 1, &linear)) return false;
  auto rows = derivatives->by_parameters.middleRows<2>(row);
  for (int k = 0; k < linear.num_nodes; ++k)
    rows.middleCols(linear.node_parameter[k], linear.num_per_node) +=
        linear.node_weight[k] * linear.by_node.leftCols(linear.num_per_node);
  if (linear.num_global > 0)
    rows.middleCols(linear.first_global, linear.num_global) +=
        linear.by_global.leftCols(linear.num_global);
  Eigen::Matrix3d minus_cross;              // omega x point = -[point]x omega
  minus_cross << 0, point.z(), -point.y(),  //
      -point.z(), 0, point.x(),             //
      point.y(), -point.x(), 0;
  derivatives->by_rotation.middleRows<2>(row) = linear.by_point * minus_cross;
  return true;
}

std::vector<PixelUncertainty> LatticePixels(const Area& area,
                                            const UncertaintyOptions& lattice) {
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
                       const Area& area, const UncertaintyOptions& lattice,
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

// The linear system of adjustment around a state.
struct LinearSystem {
  ParameterLayout layout;
  PriorEquations prior;
  std::vector<ViewJacobian> jacobians;
  const AdjustmentState& state;
  int num_threads;
};

// F with F F^T = D H^-1 D^T, for derivatives D by a camera's parameters: with
// the Cholesky factor of H, F^T = L^-1 D^T.
bool ExactRoot(const LinearSystem& system, const Eigen::MatrixXd& derivatives,
               int camera, Eigen::MatrixXd* root) {
  Eigen::MatrixXd right =
      Eigen::MatrixXd::Zero(system.layout.size, derivatives.rows());
  right.middleRows(system.layout.first_camera[camera], derivatives.cols()) =
      derivatives.transpose();
  Eigen::MatrixXd half;
  const DenseEquations equations(system.layout, system.jacobians, system.prior,
                                 system.num_threads);
  if (!equations.HalfSolveFor(right, &half)) return false;
  *root = half.transpose();
  return true;
}

// F such that F F^T estimates D H^-1 D^T. With H = J^T J + B B^T + R R^T, a
// sample is x = H^-1 (J^T e + B u + R v) of random signs e, u, v: its
// covariance is H^-1 H H^-1 = H^-1.
bool SampledRoot(const LinearSystem& system, const Eigen::MatrixXd& derivatives,
                 int camera, int num_samples, Eigen::MatrixXd* root) {
  constexpr double kTolerance = 1e-2;
  std::mt19937 random_bits(1);  // the standard fixes its sequence
  const PrecisionRoot precision(system.prior.precision);
  const auto memory = std::make_shared<LargeEquations::Memory>();
  root->resize(derivatives.rows(), num_samples);
  for (int k = 0; k < num_samples; ++k) {
    std::vector<ViewJacobian> jacobians = system.jacobians;
    for (ViewJacobian& jacobian : jacobians)
      for (int i = 0; i < jacobian.count(); ++i)
        jacobian.error.col(i) = RandomSigns(2, &random_bits);
    PriorEquations prior = system.prior;
    prior.gradient =
        precision.Times(RandomSigns(precision.size(), &random_bits),
                        system.layout.size) +
        prior.root * RandomSigns(prior.root.cols(), &random_bits);
    const LargeEquations equations(system.layout, std::move(jacobians), prior,
                                   system.state.points, kTolerance,
                                   system.num_threads, memory);
    AdjustmentStep step;
    if (!equations.Solve(0, &step)) return false;
    root->col(k) = derivatives * step.cameras[camera];
  }
  *root /= std::sqrt(static_cast<double>(num_samples));
  return true;
}

// Takes the rotation of least squares over pixels among observations out of
// each of F's columns.
void RemoveRotation(const Eigen::MatrixX3d& by_rotation,
                    const std::vector<PixelUncertainty>& pixels,
                    Eigen::MatrixXd* root) {
  Eigen::MatrixX3d seen = by_rotation;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (pixels[i].num_observations < kMinObservations)
      seen.middleRows<2>(2 * static_cast<Eigen::Index>(i)).setZero();
  const Eigen::Matrix3d square = seen.transpose() * seen;
  *root -= by_rotation * square.ldlt().solve(seen.transpose() * *root);
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
    const UncertaintyOptions& lattice) {
  const CameraModel& model = *state.cameras[camera];
  std::vector<PixelUncertainty> pixels = LatticePixels(model.area(), lattice);
  CountObservations(views, camera, model.area(), lattice, &pixels);

  LatticeDerivatives derivatives;
  const Eigen::Index num_rows = 2 * static_cast<Eigen::Index>(pixels.size());
  derivatives.by_parameters.setZero(num_rows, model.NumParameters());
  derivatives.by_rotation.setZero(num_rows, 3);
  std::vector<bool> is_known;
  for (size_t i = 0; i < pixels.size(); ++i)
    is_known.push_back(AddPixel(model, pixels[i].pixel,
                                2 * static_cast<Eigen::Index>(i),
                                &derivatives));

  const int num_threads = NumThreads(options.num_threads);
  const ParameterLayout layout(state, {false, options.fix_points});
  const LinearSystem system = {
      layout, PriorEquations(prior, state, layout),
      WeightedJacobians(state, views, options.huber_px, num_threads), state,
      num_threads};
  Eigen::MatrixXd root;
  const bool is_regular =
      NumDenseUnknowns(layout) <= lattice.max_exact_unknowns
          ? ExactRoot(system, derivatives.by_parameters, camera, &root)
          : SampledRoot(system, derivatives.by_parameters, camera,
                        lattice.num_samples, &root);
  if (!is_regular) return {};
  RemoveRotation(derivatives.by_rotation, pixels, &root);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const auto rows = root.middleRows<2>(2 * static_cast<Eigen::Index>(i));
    pixels[i].covariance_px2 = noise_px * noise_px * rows * rows.transpose();
    if (!is_known[i])
      pixels[i].covariance_px2.setConstant(
          std::numeric_limits<double>::quiet_NaN());
  }
  return pixels;
}

}  // namespace raygrid
