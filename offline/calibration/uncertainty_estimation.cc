#include "calibration/uncertainty_estimation.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "adjustment/covariance.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// The observations determine the camera where its standard deviation is at most
// this multiple of the noise, or below this value; the influence of the prior
// is negligible there.
constexpr double kRelativeDeterminedStdDev = 0.5;
constexpr double kMinDeterminedStdDevPx = 0.025;
// Default uncertainty limits of the valid region.
constexpr double kValidPx = 0.25, kValidPerNoise = 3;
// Beyond the features, lenses are less smooth than the prior assumes. In twelve
// calibrations of four simulated lenses, observed in the central 60 % of the
// image width, the standard deviation had to be scaled by 1.0 to 1.9, depending
// on the calibration, to contain the errors of 90 % of the extrapolated pixels
// within 2 sigma (benchmarks/README.md).
constexpr double kExtrapolationFactor = 2;
// A cell is extrapolated unless at least this many features lie within this
// many cells on all sides.
constexpr int kMinFeatures = 3, kNeighborhoodCells = 2;

// Returns a lattice with approximately square cells, within the size limits of
// a blob.
UncertaintyOptions MakeLattice(const Area& area) {
  constexpr int kIntervals = 16;
  const double longer = std::max(area.width(), area.height());
  const auto count = [longer](double extent) {
    return 1 + std::max(1, static_cast<int>(
                               std::lround(kIntervals * extent / longer)));
  };
  UncertaintyOptions options;
  options.columns = count(area.width());
  options.rows = count(area.height());
  return options;
}

// Counts the features in each cell.
std::vector<int> CountFeatures(const AdjustmentResult& adjusted, int camera,
                               const ValidityMask& mask) {
  std::vector<int> counts(mask.is_valid.size(), 0);
  for (const View& view : adjusted.problem.views) {
    if (view.camera != camera) continue;
    for (const Observation& observation : view.observations)
      ++counts[mask.CellIndex(observation.pixel)];
  }
  return counts;
}

int CountFeaturesNear(const std::vector<int>& counts, const ValidityMask& mask,
                      int cell) {
  const int column = cell % mask.columns, row = cell / mask.columns;
  int sum = 0;
  for (int j = std::max(row - kNeighborhoodCells, 0);
       j <= std::min(row + kNeighborhoodCells, mask.rows - 1); ++j)
    for (int i = std::max(column - kNeighborhoodCells, 0);
         i <= std::min(column + kNeighborhoodCells, mask.columns - 1); ++i)
      sum += counts[j * mask.columns + i];
  return sum;
}

// Marks the cells with nearby features.
ValidityMask CellsNearFeatures(const AdjustmentResult& adjusted, int camera) {
  ValidityMask near =
      ValidityMask::Over(adjusted.state.cameras[camera]->image_size());
  const std::vector<int> counts = CountFeatures(adjusted, camera, near);
  for (int cell = 0; cell < near.columns * near.rows; ++cell)
    near.is_valid[cell] = CountFeaturesNear(counts, near, cell) >= kMinFeatures;
  return near;
}

// Returns the principal modes of the joint covariance of the lattice's pixels,
// on a coarser lattice. Pixels at which the camera is undefined have no
// displacement.
ErrorModes GetDeformationModes(const Eigen::MatrixXd& joint_px2,
                               const UncertaintyOptions& size) {
  constexpr int kMaxModes = 12;
  ErrorModes fine;
  fine.columns = size.columns;
  fine.rows = size.rows;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      (joint_px2 + joint_px2.transpose()) / 2);
  const Eigen::Index last = joint_px2.rows() - 1;
  double residual_px2 = solver.eigenvalues().cwiseMax(0.0).sum();
  for (int k = 0; k < std::min<Eigen::Index>(kMaxModes, last); ++k) {
    const double variance = solver.eigenvalues()[last - k];
    if (!(variance > 0)) break;
    residual_px2 -= variance;
    Eigen::VectorXd mode =
        std::sqrt(variance) * solver.eigenvectors().col(last - k);
    // Fixes the arbitrary sign of a mode.
    Eigen::Index largest;
    mode.cwiseAbs().maxCoeff(&largest);
    if (mode[largest] < 0) mode = -mode;
    fine.displacements_px.emplace_back();
    for (Eigen::Index i = 0; i < mode.size(); i += 2)
      fine.displacements_px.back().push_back(mode.segment<2>(i));
  }
  ErrorModes coarse;
  coarse.residual_px = std::sqrt(std::max(0.0, residual_px2) /
                                 static_cast<double>(joint_px2.rows()));
  coarse.columns = std::max(2, (size.columns + 1) / 2);
  coarse.rows = std::max(2, (size.rows + 1) / 2);
  const Area unit = {0, 0, 1, 1};
  for (size_t k = 0; k < fine.displacements_px.size(); ++k) {
    coarse.displacements_px.emplace_back();
    for (int i = 0; i < coarse.columns * coarse.rows; ++i)
      coarse.displacements_px.back().push_back(
          fine.At(k, unit,
                  {double(i % coarse.columns) / (coarse.columns - 1),
                   double(i / coarse.columns) / (coarse.rows - 1)}));
  }
  return coarse;
}

AdjustmentOptions MakeResponseOptions(const AdjustmentResult& adjusted,
                                      int num_threads) {
  AdjustmentOptions options;
  options.num_threads = num_threads;
  options.fix_points = !HavePointsMoved(adjusted);
  return options;
}

LinearResponse ComputeResponse(const AdjustmentResult& adjusted,
                               int num_threads) {
  return LinearResponse(adjusted.problem.views, adjusted.prior,
                        MakeResponseOptions(adjusted, num_threads),
                        adjusted.state);
}

GroupJackknife ComputeJackknife(const LinearResponse& response,
                                const AdjustmentResult& adjusted,
                                int num_threads) {
  return GroupJackknife(response, adjusted.problem.views, adjusted.prior,
                        MakeResponseOptions(adjusted, num_threads),
                        adjusted.state, adjusted.summary.noise_px);
}

double GetObservedStdDev(const PixelUncertainty& pixel) {
  return ComputeAxisStdDev(pixel.noise_px2 +
                           pixel.smoothing_px * pixel.smoothing_px.transpose());
}

}  // namespace

std::vector<UncertaintyLattice> EstimateStdDevs(
    const AdjustmentResult& adjusted, int camera,
    const std::vector<const CameraModel*>& as, int num_threads) {
  if (!(adjusted.summary.noise_px > 0)) return {};
  const UncertaintyOptions size =
      MakeLattice(adjusted.state.cameras[camera]->area());
  const LinearResponse response = ComputeResponse(adjusted, num_threads);
  const GroupJackknife jackknife =
      ComputeJackknife(response, adjusted, num_threads);
  AdjustmentState state = adjusted.state;
  std::vector<UncertaintyLattice> lattices;
  for (const CameraModel* model : as) {
    state.cameras[camera] = model->Clone();
    UncertaintyLattice& lattice = lattices.emplace_back();
    lattice.columns = size.columns;
    lattice.rows = size.rows;
    for (const PixelUncertainty& pixel : EstimateProjectionUncertainty(
             response, adjusted.summary.noise_px, &jackknife,
             adjusted.problem.views, state, camera, size))
      lattice.stddev_px.push_back(GetObservedStdDev(pixel));
    if (lattice.stddev_px.empty()) return {};
  }
  return lattices;
}

double DefaultValidLimitPx(double noise_px) {
  return std::max(kValidPx, kValidPerNoise * noise_px);
}

std::optional<EstimatedUncertainty> EstimateUncertainty(
    const AdjustmentResult& adjusted, int camera,
    const std::optional<ImageCircle>& image_circle,
    const std::optional<double>& valid_limit_px, int num_threads) {
  const double noise_px = adjusted.summary.noise_px;
  if (!(noise_px > 0)) return std::nullopt;
  const Area& area = adjusted.state.cameras[camera]->area();
  const UncertaintyOptions size = MakeLattice(area);
  const ValidityMask near = CellsNearFeatures(adjusted, camera);
  Eigen::MatrixXd joint_px2;
  const LinearResponse response = ComputeResponse(adjusted, num_threads);
  const GroupJackknife jackknife =
      ComputeJackknife(response, adjusted, num_threads);
  const std::vector<PixelUncertainty> pixels = EstimateProjectionUncertainty(
      response, noise_px, &jackknife, adjusted.problem.views, adjusted.state,
      camera, size, &joint_px2);
  if (pixels.empty()) return std::nullopt;
  UncertaintyLattice seen = {size.columns, size.rows, {}}, total = seen,
                     scatter = seen;
  std::vector<double> scales;
  for (const PixelUncertainty& pixel : pixels) {
    scatter.stddev_px.push_back(std::sqrt(pixel.noise_px2.trace() / 2));
    const double observed_stddev_px = GetObservedStdDev(pixel);
    seen.stddev_px.push_back(observed_stddev_px);
    const bool is_near = near.IsValidAt(pixel.pixel);
    if (is_near) scales.push_back(pixel.jackknife_scale);
    const double factor = is_near ? 1 : kExtrapolationFactor;
    total.stddev_px.push_back(
        factor *
        std::max(ComputeAxisStdDev(pixel.total_px2), observed_stddev_px));
  }
  if (!std::isfinite(total.MedianPx())) return std::nullopt;
  EstimatedUncertainty estimate;
  CameraUncertainty& uncertainty = estimate.uncertainty;
  ValidityMask effective_parameters = near;
  effective_parameters.InvalidateAbove(
      std::max(kRelativeDeterminedStdDev * noise_px, kMinDeterminedStdDevPx),
      total, area);
  uncertainty.max_stddev_px =
      valid_limit_px.value_or(DefaultValidLimitPx(noise_px));
  uncertainty.mask = near;
  uncertainty.mask.InvalidateAbove(uncertainty.max_stddev_px, total, area);
  if (image_circle) InvalidateOutside(*image_circle, &uncertainty.mask);
  uncertainty.modes = GetDeformationModes(joint_px2, size);
  uncertainty.scatter = scatter;
  if (!scales.empty()) uncertainty.jackknife_scale = Quantile(scales, 0.5);
  // Where observations are sparse, the bias due to smoothing cannot be
  // estimated.
  uncertainty.lattice = seen;
  for (size_t i = 0; i < pixels.size(); ++i)
    if (!effective_parameters.IsValidAt(pixels[i].pixel))
      uncertainty.lattice.stddev_px[i] = total.stddev_px[i];
  estimate.extrapolated = SummarizeExtrapolatedRegion(
      *adjusted.state.cameras[camera], image_circle, near, uncertainty.lattice);
  return estimate;
}

std::map<std::string, double> PredictHeldOutStdDevs(
    const AdjustmentResult& adjusted, int camera,
    const std::set<std::string>& images, int num_threads) {
  constexpr Eigen::Index kMaxRows = 2000;
  // Minimum eigenvalue of I - A for the residuals to be determined by the
  // remaining images.
  constexpr double kUndetermined = 1e-8;
  const CalibrationProblem& problem = adjusted.problem;
  const LinearResponse response = ComputeResponse(adjusted, num_threads);
  std::vector<size_t> left_out;  // views
  Eigen::Index num_rows = 0;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.views[v].camera != camera ||
        images.count(problem.images[v]) == 0)
      continue;
    left_out.push_back(v);
    num_rows += 2 * response.jacobians()[v].count();
  }
  if (num_rows == 0 || num_rows > kMaxRows || !response.IsExact()) return {};
  // Response of the residuals to errors of the same observations: A = J H^-1
  // J^T. Without these observations, the residuals have the covariance s^2 (I -
  // A)^-1, apart from the part that the free poses absorb.
  ViewErrors none;
  for (const ViewJacobian& jacobian : response.jacobians())
    none.push_back(Eigen::Matrix2Xd::Zero(2, jacobian.count()));
  Eigen::MatrixXd right(response.layout().num_all(), num_rows);
  Eigen::Index row = 0;
  for (const size_t v : left_out)
    for (Eigen::Index i = 0; i < none[v].size(); ++i, ++row) {
      none[v](i) = 1;
      right.col(row) = response.Gradient(none);
      none[v](i) = 0;
    }
  Eigen::MatrixXd moves;
  if (!response.Solve(right, &moves)) return {};
  const Eigen::MatrixXd left =
      Eigen::MatrixXd::Identity(num_rows, num_rows) - right.transpose() * moves;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      (left + left.transpose()) / 2);
  const Eigen::ArrayXd values = solver.eigenvalues().array();
  const Eigen::VectorXd inverse = (values > kUndetermined)
                                      .select(1 / values.max(kUndetermined), 0)
                                      .matrix();
  const Eigen::VectorXd variances = solver.eigenvectors().cwiseAbs2() * inverse;
  std::map<std::string, std::vector<double>> deviations;
  row = 0;
  for (const size_t v : left_out)
    for (int i = 0; i < response.jacobians()[v].count(); ++i, row += 2)
      deviations[problem.images[v]].push_back(
          adjusted.summary.noise_px *
          std::sqrt(variances.segment<2>(row).sum()));
  std::map<std::string, double> medians;
  for (const auto& [image, values_px] : deviations)
    medians[image] = Quantile(values_px, 0.5);
  return medians;
}

}  // namespace raygrid
