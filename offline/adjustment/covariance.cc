#include "adjustment/covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

namespace raygrid {
namespace {

constexpr int kMinObservations = 3;  // minimum for a pixel to count as observed

// Jacobians of the projections of the lattice's rays, two rows per pixel, with
// respect to the camera parameters and to a rotation of the camera.
struct LatticeDerivatives {
  Eigen::MatrixXd J_parameters;
  Eigen::MatrixX3d J_rotation;
};

// Adds the Jacobians of a pixel; returns false if the camera is undefined
// there.
bool AddPixel(const CameraModel& camera, const Eigen::Vector2d& pixel,
              Eigen::Index row, LatticeDerivatives* derivatives) {
  constexpr double kDistanceM = 1e4;
  const auto line = camera.Line(pixel);
  LinearizedProjection linear;
  if (!line) return false;
  const Eigen::Vector3d point = line->origin + kDistanceM * line->direction;
  if (!camera.Linearize(point, &pixel, 1, &linear)) return false;
  auto rows = derivatives->J_parameters.middleRows<2>(row);
  for (int k = 0; k < linear.num_nodes; ++k)
    rows.middleCols(linear.node_parameter[k], linear.num_per_node) +=
        linear.node_weight[k] * linear.J_node.leftCols(linear.num_per_node);
  if (linear.num_global > 0)
    rows.middleCols(linear.first_global, linear.num_global) +=
        linear.J_global.leftCols(linear.num_global);
  Eigen::Matrix3d minus_cross;              // omega x point = -[point]x omega
  minus_cross << 0, point.z(), -point.y(),  //
      -point.z(), 0, point.x(),             //
      point.y(), -point.x(), 0;
  derivatives->J_rotation.middleRows<2>(row) = linear.J_point * minus_cross;
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

// Returns the Jacobian D after removing the rotation, which is fitted by least
// squares with weights by the number of observations. With equal weights, the
// most uncertain pixels, at the edge, would rotate all others.
Eigen::MatrixXd RemoveRotation(const LatticeDerivatives& derivatives,
                               const std::vector<PixelUncertainty>& pixels) {
  const Eigen::MatrixX3d& rotation = derivatives.J_rotation;
  Eigen::MatrixX3d weighted_rotation = rotation;
  for (size_t i = 0; i < pixels.size(); ++i)
    weighted_rotation.middleRows<2>(2 * static_cast<Eigen::Index>(i)) *=
        pixels[i].num_observations;
  const Eigen::Matrix3d square = weighted_rotation.transpose() * rotation;
  return derivatives.J_parameters -
         rotation * square.ldlt().solve(weighted_rotation.transpose() *
                                        derivatives.J_parameters);
}

// Joint covariances of the x and y coordinates of all lattice pixels.
struct JointCovariances {
  Eigen::MatrixXd by_noise, by_prior;
  Eigen::VectorXd smoothing_px;
};

// Returns the 2 x 2 covariance block of one pixel.
Eigen::Matrix2d GetPixelBlock(const Eigen::MatrixXd& joint, size_t pixel) {
  return joint.block<2, 2>(2 * static_cast<Eigen::Index>(pixel),
                           2 * static_cast<Eigen::Index>(pixel));
}

// Jacobian D of the lattice pixels with respect to the parameters of one
// camera.
class Lattice {
 public:
  Lattice(const LinearResponse& response, int camera,
          const Eigen::MatrixXd& derivatives)
      : derivatives_(derivatives),
        first_(response.layout().first_camera[camera]) {}

  const Eigen::MatrixXd& derivatives() const { return derivatives_; }
  int first() const { return first_; }

  // Returns the pixel displacements for the parameter changes in each column.
  Eigen::MatrixXd ComputeDisplacements(
      const Eigen::MatrixXd& parameters) const {
    return derivatives_ * parameters.middleRows(first_, derivatives_.cols());
  }
  // D^T as right-hand sides, over all parameters that precede the poses.
  Eigen::MatrixXd Right(const ParameterLayout& layout) const {
    Eigen::MatrixXd right =
        Eigen::MatrixXd::Zero(layout.size, derivatives_.rows());
    right.middleRows(first_, derivatives_.cols()) = derivatives_.transpose();
    return right;
  }

 private:
  const Eigen::MatrixXd& derivatives_;
  int first_;
};

// With X = H^-1 D^T: the total covariance is D X, of which D H^-1 J^T J H^-1
// D^T = D X - X^T P X is due to noise. The smoothing bias is D H^-1 g = X^T g
// for the gradient g = P (c - c0) of the prior.
bool AddExactCovariances(const LinearResponse& response, const Lattice& lattice,
                         double noise_px, JointCovariances* covariances) {
  const PriorEquations& prior = response.prior();
  Eigen::MatrixXd x;
  if (!response.Solve(lattice.Right(response.layout()), &x)) return false;
  const Eigen::MatrixXd by_prior = x.transpose() * prior.Times(x);
  covariances->by_prior = std::pow(noise_px, 2) * by_prior;
  covariances->by_noise =
      std::pow(noise_px, 2) * (lattice.ComputeDisplacements(x) - by_prior);
  covariances->smoothing_px = x.transpose() * prior.gradient;
  return true;
}

// Estimates the covariances by Monte Carlo sampling: H^-1 J^T e for noise e,
// including per-view deformation, and H^-1 g for gradients g with covariance P.
bool AddSampledCovariances(const LinearResponse& response,
                           const Lattice& lattice, int num_samples,
                           double noise_px, JointCovariances* covariances) {
  constexpr int kSamplesPerSolve = 4;  // samples per solution
  std::mt19937 random_bits(1);         // sequence is standardized
  const Eigen::Index size = response.layout().num_all();
  const double scale_px2 = noise_px * noise_px / num_samples;
  for (int first = 0; first < num_samples; first += kSamplesPerSolve) {
    const int count = std::min(kSamplesPerSolve, num_samples - first);
    Eigen::MatrixXd right(size, 2 * count), x;
    for (int k = 0; k < count; ++k) {
      right.col(k) = response.Gradient(response.SampleNoise(&random_bits)) +
                     response.SampleDeformationPrior(&random_bits);
      right.col(count + k) = response.SamplePrior(&random_bits);
    }
    if (!response.Solve(right, &x)) return false;
    const Eigen::MatrixXd lattice_displacements =
        lattice.ComputeDisplacements(x);
    const auto by_noise = lattice_displacements.leftCols(count);
    const auto by_prior = lattice_displacements.rightCols(count);
    covariances->by_noise += scale_px2 * by_noise * by_noise.transpose();
    covariances->by_prior += scale_px2 * by_prior * by_prior.transpose();
  }
  Eigen::MatrixXd x;
  if (!response.Solve(response.PriorGradient(), &x)) return false;
  covariances->smoothing_px = lattice.ComputeDisplacements(x);
  return true;
}

// Returns the standard deviations per pixel: the RMS over both axes.
Eigen::VectorXd ComputeRowStdDevs(const Eigen::MatrixXd& joint_px2) {
  Eigen::VectorXd row_stddevs(joint_px2.rows());
  for (Eigen::Index i = 0; i < joint_px2.rows(); i += 2)
    row_stddevs.segment<2>(i).setConstant(
        std::sqrt((joint_px2(i, i) + joint_px2(i + 1, i + 1)) / 2));
  return row_stddevs;
}

// Scales the eigenmodes of the correlation of observed pixels to agree with the
// jackknife, and all other pixels by the mean factor.
void ScaleByJackknife(const GroupJackknife& jackknife, const Lattice& lattice,
                      const std::vector<PixelUncertainty>& pixels,
                      JointCovariances* covariances) {
  const Eigen::MatrixXd total = covariances->by_noise + covariances->by_prior;
  const Eigen::VectorXd row_stddevs = ComputeRowStdDevs(total);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(row_stddevs.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    const auto row = 2 * static_cast<Eigen::Index>(i);
    if (pixels[i].num_observations > 0 && row_stddevs[row] > 0)
      weights.segment<2>(row).setConstant(1 / row_stddevs[row]);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      weights.asDiagonal() * ((total + total.transpose()) / 2) *
      weights.asDiagonal());
  // In descending order of variance; unobserved pixels only have modes with
  // zero variance.
  const Eigen::Index num_observed = (weights.array() > 0).count();
  const Eigen::MatrixXd modes =
      solver.eigenvectors().rowwise().reverse().leftCols(num_observed);
  const VarianceFactors factors(jackknife.Of(
      lattice.first(),
      modes.transpose() * weights.asDiagonal() * lattice.derivatives()));
  const double overall_factor = std::sqrt(factors.overall_factor);
  Eigen::MatrixXd scaling =
      row_stddevs.asDiagonal() * modes *
      (factors.group_factors.cwiseSqrt().array() - overall_factor)
          .matrix()
          .asDiagonal() *
      modes.transpose() * weights.asDiagonal();
  scaling.diagonal().array() += overall_factor;
  for (Eigen::MatrixXd* part : {&covariances->by_noise, &covariances->by_prior})
    *part = scaling * *part * scaling.transpose();
}

}  // namespace

Eigen::MatrixXd ComputeLatticeJacobian(const std::vector<View>& views,
                                       const AdjustmentState& state, int camera,
                                       const UncertaintyOptions& lattice,
                                       std::vector<PixelUncertainty>* pixels,
                                       std::vector<bool>* is_known) {
  const CameraModel& model = *state.cameras[camera];
  *pixels = LatticePixels(model.area(), lattice);
  CountObservations(views, camera, model.area(), lattice, pixels);
  LatticeDerivatives derivatives;
  const Eigen::Index num_rows = 2 * static_cast<Eigen::Index>(pixels->size());
  derivatives.J_parameters.setZero(num_rows, model.NumParameters());
  derivatives.J_rotation.setZero(num_rows, 3);
  is_known->clear();
  for (size_t i = 0; i < pixels->size(); ++i)
    is_known->push_back(AddPixel(model, (*pixels)[i].pixel,
                                 2 * static_cast<Eigen::Index>(i),
                                 &derivatives));
  return RemoveRotation(derivatives, *pixels);
}

double ComputeAxisStdDev(const Eigen::Matrix2d& covariance) {
  return std::sqrt(covariance.trace() / 2);
}

std::vector<PixelUncertainty> EstimateProjectionUncertainty(
    const LinearResponse& response, double noise_px,
    const GroupJackknife* jackknife, const std::vector<View>& views,
    const AdjustmentState& state, int camera, const UncertaintyOptions& lattice,
    Eigen::MatrixXd* joint_px2) {
  std::vector<bool> is_known;
  std::vector<PixelUncertainty> pixels;
  const Eigen::MatrixXd J_lattice =
      ComputeLatticeJacobian(views, state, camera, lattice, &pixels, &is_known);
  const Eigen::Index num_rows = J_lattice.rows();
  const Lattice lattice_response(response, camera, J_lattice);
  JointCovariances joint = {Eigen::MatrixXd::Zero(num_rows, num_rows),
                            Eigen::MatrixXd::Zero(num_rows, num_rows),
                            Eigen::VectorXd::Zero(num_rows)};
  if (!(response.IsExact()
            ? AddExactCovariances(response, lattice_response, noise_px, &joint)
            : AddSampledCovariances(response, lattice_response,
                                    lattice.num_samples, noise_px, &joint)))
    return {};
  const Eigen::VectorXd unscaled =
      ComputeRowStdDevs(joint.by_noise + joint.by_prior);
  if (jackknife && jackknife->IsValid())
    ScaleByJackknife(*jackknife, lattice_response, pixels, &joint);
  const Eigen::VectorXd scaled =
      ComputeRowStdDevs(joint.by_noise + joint.by_prior);
  if (joint_px2) *joint_px2 = joint.by_noise + joint.by_prior;
  for (size_t i = 0; i < pixels.size(); ++i) {
    PixelUncertainty& pixel = pixels[i];
    pixel.noise_px2 = GetPixelBlock(joint.by_noise, i);
    pixel.total_px2 = pixel.noise_px2 + GetPixelBlock(joint.by_prior, i);
    pixel.smoothing_px =
        joint.smoothing_px.segment<2>(2 * static_cast<Eigen::Index>(i));
    const auto row = 2 * static_cast<Eigen::Index>(i);
    if (unscaled[row] > 0) pixel.jackknife_scale = scaled[row] / unscaled[row];
    if (is_known[i]) continue;
    pixel.noise_px2.setConstant(NAN);
    pixel.total_px2.setConstant(NAN);
    pixel.smoothing_px.setConstant(NAN);
  }
  return pixels;
}

}  // namespace raygrid
