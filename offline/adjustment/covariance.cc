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
  int camera, num_threads;
};

// D less the rotation of least squares over pixels among observations.
Eigen::MatrixXd WithoutRotation(const LatticeDerivatives& derivatives,
                                const std::vector<PixelUncertainty>& pixels) {
  const Eigen::MatrixX3d& rotation = derivatives.by_rotation;
  Eigen::MatrixX3d seen = rotation;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (pixels[i].num_observations < kMinObservations)
      seen.middleRows<2>(2 * static_cast<Eigen::Index>(i)).setZero();
  const Eigen::Matrix3d square = seen.transpose() * seen;
  return derivatives.by_parameters -
         rotation *
             square.ldlt().solve(seen.transpose() * derivatives.by_parameters);
}

// With X = H^-1 D^T: D X in total, and D H^-1 J^T J H^-1 D^T = D X - X^T P X by
// noise, for derivatives D by the camera's parameters; D H^-1 g = X^T g by the
// prior's gradient g = P (c - c0).
bool AddExactCovariances(const LinearSystem& system,
                         const Eigen::MatrixXd& derivatives,
                         std::vector<PixelUncertainty>* pixels,
                         Eigen::MatrixXd* joint_px2) {
  const int first = system.layout.first_camera[system.camera];
  Eigen::MatrixXd right =
      Eigen::MatrixXd::Zero(system.layout.size, derivatives.rows());
  right.middleRows(first, derivatives.cols()) = derivatives.transpose();
  Eigen::MatrixXd x;
  if (!DenseEquations(system.layout, system.jacobians, system.prior,
                      system.num_threads)
           .SolveFor(0, right, &x))
    return false;
  if (joint_px2)
    *joint_px2 = derivatives * x.middleRows(first, derivatives.cols());
  const Eigen::MatrixXd prior_x = system.prior.Times(x);
  for (size_t i = 0; i < pixels->size(); ++i) {
    const Eigen::Index k = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Matrix2d total =
        derivatives.middleRows<2>(k) * x.block(first, k, derivatives.cols(), 2);
    const Eigen::Matrix2d prior =
        x.middleCols<2>(k).transpose() * prior_x.middleCols<2>(k);
    (*pixels)[i].total_px2 = (total + total.transpose()) / 2;
    (*pixels)[i].noise_px2 = (*pixels)[i].total_px2 - prior;
    (*pixels)[i].smoothing_px =
        x.middleCols<2>(k).transpose() * system.prior.gradient;
  }
  return true;
}

// H^-1 (J^T e + g), its part of the camera, for other residuals e and another
// gradient g of the prior.
class OtherRightSides {
 public:
  explicit OtherRightSides(const LinearSystem& system)
      : system_(system), prior_root_(system.prior.precision) {}

  // The covariance of this over the samples is H^-1 J^T J H^-1, with the flex
  // of each view as another error...
  bool SolveNoise(Eigen::VectorXd* camera_parameters) {
    const Eigen::VectorXd none =
        Eigen::VectorXd::Zero(system_.prior.gradient.size());
    Eigen::MatrixXd flex = NoFlex();
    for (Eigen::Index pose = 0; flex.rows() > 0 && pose < flex.cols(); ++pose)
      flex.col(pose) = system_.prior.flex_precision.cwiseSqrt().cwiseProduct(
          RandomSigns(flex.rows(), &random_bits_));
    return Solve([&] { return RandomSigns(2, &random_bits_); }, none, flex,
                 camera_parameters);
  }
  // ... and of this, with P = B B^T + R R^T, H^-1 P H^-1; in sum H^-1.
  bool SolvePrior(Eigen::VectorXd* camera_parameters) {
    const PriorEquations& prior = system_.prior;
    // Drawn in an order that no compiler chooses.
    const Eigen::VectorXd root_signs =
        RandomSigns(prior_root_.size(), &random_bits_);
    const Eigen::VectorXd other_signs =
        RandomSigns(prior.root.cols(), &random_bits_);
    const Eigen::VectorXd gradient =
        WithoutFree(prior.free, prior.freed,
                    prior_root_.Times(root_signs, system_.layout.size)) +
        prior.root * other_signs;
    return Solve(NoError, gradient, NoFlex(), camera_parameters);
  }
  bool SolveSmoothing(Eigen::VectorXd* camera_parameters) {
    return Solve(NoError, system_.prior.gradient, NoFlex(), camera_parameters);
  }

 private:
  static Eigen::VectorXd NoError() { return Eigen::VectorXd::Zero(2); }
  Eigen::MatrixXd NoFlex() const {
    return Eigen::MatrixXd::Zero(system_.prior.flex_gradient.rows(),
                                 system_.prior.flex_gradient.cols());
  }

  template <typename MakeError>
  bool Solve(const MakeError& make_error, const Eigen::VectorXd& gradient,
             const Eigen::MatrixXd& flex_gradient,
             Eigen::VectorXd* camera_parameters) const {
    constexpr double kTolerance = 1e-2;
    std::vector<ViewJacobian> jacobians = system_.jacobians;
    for (ViewJacobian& jacobian : jacobians)
      for (int i = 0; i < jacobian.count(); ++i)
        jacobian.error.col(i) = make_error();
    PriorEquations prior = system_.prior;
    prior.gradient = gradient;
    prior.flex_gradient = flex_gradient;
    const LargeEquations equations(system_.layout, std::move(jacobians), prior,
                                   system_.state.points, kTolerance,
                                   system_.num_threads, memory_);
    AdjustmentStep step;
    if (!equations.Solve(0, &step)) return false;
    *camera_parameters = step.cameras[system_.camera];
    return true;
  }

  const LinearSystem& system_;
  const PrecisionRoot prior_root_;
  const std::shared_ptr<LargeEquations::Memory> memory_ =
      std::make_shared<LargeEquations::Memory>();
  std::mt19937 random_bits_{1};  // the standard fixes its sequence
};

bool AddSampledCovariances(const LinearSystem& system,
                           const Eigen::MatrixXd& derivatives, int num_samples,
                           std::vector<PixelUncertainty>* pixels,
                           Eigen::MatrixXd* joint_px2) {
  for (PixelUncertainty& pixel : *pixels)
    pixel.noise_px2 = pixel.total_px2 = Eigen::Matrix2d::Zero();
  if (joint_px2) joint_px2->setZero(derivatives.rows(), derivatives.rows());
  OtherRightSides sides(system);
  Eigen::VectorXd parameters;
  for (int k = 0; k < num_samples; ++k) {
    for (const bool is_noise : {true, false}) {
      if (!(is_noise ? sides.SolveNoise(&parameters)
                     : sides.SolvePrior(&parameters)))
        return false;
      const Eigen::VectorXd moved = derivatives * parameters;
      if (joint_px2) *joint_px2 += moved * moved.transpose() / num_samples;
      for (size_t i = 0; i < pixels->size(); ++i) {
        const auto pixel = moved.segment<2>(2 * static_cast<Eigen::Index>(i));
        const Eigen::Matrix2d square = pixel * pixel.transpose() / num_samples;
        (*pixels)[i].total_px2 += square;
        if (is_noise) (*pixels)[i].noise_px2 += square;
      }
    }
  }
  if (!sides.SolveSmoothing(&parameters)) return false;
  const Eigen::VectorXd moved = derivatives * parameters;
  for (size_t i = 0; i < pixels->size(); ++i)
    (*pixels)[i].smoothing_px =
        moved.segment<2>(2 * static_cast<Eigen::Index>(i));
  return true;
}

}  // namespace

double WorseDeviation(const Eigen::Matrix2d& covariance) {
  const double mean = covariance.trace() / 2;
  const double root =
      std::sqrt(std::max(0.0, mean * mean - covariance.determinant()));
  return std::sqrt(mean + root);
}

std::vector<PixelUncertainty> ProjectionUncertainty(
    const std::vector<View>& views, const GaussianPrior& prior,
    const AdjustmentOptions& options, double noise_px,
    const AdjustmentState& state, int camera, const UncertaintyOptions& lattice,
    Eigen::MatrixXd* joint_px2) {
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
      layout,
      PriorEquations(prior, state, layout),
      WeightedJacobians(state, views, options.huber_px, num_threads),
      state,
      camera,
      num_threads};
  const Eigen::MatrixXd without_rotation = WithoutRotation(derivatives, pixels);
  const bool is_regular =
      NumDenseUnknowns(layout) <= lattice.max_exact_unknowns
          ? AddExactCovariances(system, without_rotation, &pixels, joint_px2)
          : AddSampledCovariances(system, without_rotation, lattice.num_samples,
                                  &pixels, joint_px2);
  if (!is_regular) return {};
  if (joint_px2) *joint_px2 *= noise_px * noise_px;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const double scale = is_known[i] ? noise_px * noise_px
                                     : std::numeric_limits<double>::quiet_NaN();
    pixels[i].noise_px2 *= scale;
    if (!is_known[i]) pixels[i].smoothing_px.setConstant(scale);
    pixels[i].total_px2 *= scale;
  }
  return pixels;
}

}  // namespace raygrid
