#include "evaluation/camera_change.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

constexpr double kAlarmSigmas = 3.09;      // false-alarm probability 1/1000
constexpr double kDetectionSigmas = 2.33;  // detection power 99 %
constexpr double kClipSigmas = 5;          // clips residuals of features
constexpr int kScale = 0, kShift = 1, kTilt = 3, kNumSmooth = 5;
constexpr int kLocalColumns = 6, kLocalRows = 4;
constexpr int kNumLocal = 2 * kLocalColumns * kLocalRows;
constexpr int kNumMovements = kNumSmooth + kNumLocal;

// Returns the weight of a local change: bilinear interpolation between the
// nodes of a lattice.
double LocalWeight(const Area& area, const Eigen::Vector2d& pixel, int node) {
  const double x = (pixel.x() - area.x0) / area.width() * (kLocalColumns - 1);
  const double y = (pixel.y() - area.y0) / area.height() * (kLocalRows - 1);
  return std::max(0.0, 1 - std::abs(x - node % kLocalColumns)) *
         std::max(0.0, 1 - std::abs(y - node / kLocalColumns));
}

using Displacements = Eigen::Matrix<double, 2, kNumMovements>;

// Returns the Jacobian of a pixel with respect to a relative scale, a shift in
// pixels, a tilt of the sensor about its vertical and horizontal axes in
// radians, and local changes in pixels.
Displacements ComputeMovementJacobian(const ReferenceCamera& camera,
                                      const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d p(pixel.x() - (camera.size.width - 1) / 2.0,
                          pixel.y() - (camera.size.height - 1) / 2.0);
  Displacements by = Displacements::Zero();
  by.col(kScale) = p;
  by(0, kShift) = by(1, kShift + 1) = 1;
  by.col(kTilt) = p * p.x() / camera.focal_px;
  by.col(kTilt + 1) = p * p.y() / camera.focal_px;
  for (int node = 0; node < kLocalColumns * kLocalRows; ++node) {
    const double weight = LocalWeight(camera.area, pixel, node);
    by(0, kNumSmooth + 2 * node) = weight;
    by(1, kNumSmooth + 2 * node + 1) = weight;
  }
  return by;
}

// ---- Equations -------------------------------------------------------------

// Errors and Jacobians of a view after eliminating its pose.
struct ReducedView {
  Eigen::MatrixXd J_modes, J_movements;
  Eigen::VectorXd error;
};

ReducedView Reduce(const ReferenceCamera& camera, const ProjectedView& view,
                   double clip_px) {
  const Eigen::Index rows = 2 * static_cast<Eigen::Index>(view.size());
  const Eigen::Index num_modes =
      static_cast<Eigen::Index>(camera.modes.displacements_px.size());
  Eigen::MatrixXd J_pose(rows, 6), all(rows, num_modes + kNumMovements + 1);
  for (size_t i = 0; i < view.size(); ++i) {
    const ProjectedFeature& feature = view[i];
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    // Evaluated at the projection instead of the observed pixel: at the latter,
    // the Jacobian would depend on the noise, which would correlate with
    // changes that the pose nearly compensates.
    const Eigen::Vector2d pixel = feature.pixel - feature.error_px;
    J_pose.middleRows<2>(row) = feature.J_pose;
    for (Eigen::Index k = 0; k < num_modes; ++k)
      all.block<2, 1>(row, k) = camera.modes.At(k, camera.area, pixel);
    all.block<2, kNumMovements>(row, num_modes) =
        ComputeMovementJacobian(camera, pixel);
    const double norm = feature.error_px.norm();
    all.block<2, 1>(row, num_modes + kNumMovements) =
        feature.error_px * std::min(1.0, clip_px / std::max(norm, 1e-12));
  }
  const Eigen::MatrixXd reduced =
      all -
      J_pose *
          (J_pose.transpose() * J_pose).ldlt().solve(J_pose.transpose() * all);
  return {reduced.leftCols(num_modes),
          reduced.middleCols<kNumMovements>(num_modes), reduced.rightCols<1>()};
}

// Information matrix of the changes and its right-hand side, in units of the
// noise including the camera's uncertainty, and the sum of squared errors.
struct Information {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double sum_of_squares = 0;
};

Information Gather(const std::vector<ReducedView>& views, double noise_px) {
  const Eigen::Index num_modes = views[0].J_modes.cols();
  Eigen::MatrixXd modes = Eigen::MatrixXd::Identity(num_modes, num_modes);
  Eigen::MatrixXd mixed = Eigen::MatrixXd::Zero(num_modes, kNumMovements);
  Eigen::VectorXd modes_right = Eigen::VectorXd::Zero(num_modes);
  Information information;
  information.matrix.setZero(kNumMovements, kNumMovements);
  information.right.setZero(kNumMovements);
  const double weight = 1 / (noise_px * noise_px);
  for (const ReducedView& view : views) {
    modes += weight * view.J_modes.transpose() * view.J_modes;
    mixed += weight * view.J_modes.transpose() * view.J_movements;
    modes_right += weight * view.J_modes.transpose() * view.error;
    information.matrix +=
        weight * view.J_movements.transpose() * view.J_movements;
    information.right += weight * view.J_movements.transpose() * view.error;
    information.sum_of_squares += weight * view.error.squaredNorm();
  }
  const Eigen::LDLT<Eigen::MatrixXd> factor(modes);
  information.matrix -= mixed.transpose() * factor.solve(mixed);
  information.right -= mixed.transpose() * factor.solve(modes_right);
  return information;
}

// Eigenvectors of a symmetric matrix, scaled to unit diagonal, with eigenvalues
// that differ from zero. For a pinhole, for instance, a planar board cannot
// distinguish a shift of the image from a tilt of the sensor.
struct ObservableDirections {
  Eigen::VectorXd unit;     // scale of each parameter
  Eigen::MatrixXd vectors;  // columns
  Eigen::VectorXd values;   // eigenvalues
};

ObservableDirections ComputeObservableDirections(
    const Eigen::MatrixXd& matrix) {
  constexpr double kMinEigenvalue = 1e-6;
  ObservableDirections observable;
  observable.unit =
      matrix.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      observable.unit.asDiagonal() * matrix * observable.unit.asDiagonal());
  const Eigen::Index size = matrix.rows();
  Eigen::Index first = 0;  // eigenvalues are ascending
  while (first < size && solver.eigenvalues()[first] < kMinEigenvalue) ++first;
  observable.vectors = solver.eigenvectors().rightCols(size - first);
  observable.values = solver.eigenvalues().tail(size - first);
  return observable;
}

// Estimate of a subset of the changes while all others are zero.
struct Estimate {
  Eigen::VectorXd values, deviations;
  double chi_squared = 0;
  int degrees_of_freedom = 0;
};

Eigen::MatrixXd SelectBlock(const Information& information,
                            const std::vector<int>& parameters) {
  const Eigen::Index size = static_cast<Eigen::Index>(parameters.size());
  Eigen::MatrixXd matrix(size, size);
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j < size; ++j)
      matrix(i, j) = information.matrix(parameters[i], parameters[j]);
  return matrix;
}

Estimate EstimateParameters(const Information& information,
                            const std::vector<int>& parameters) {
  const Eigen::Index size = static_cast<Eigen::Index>(parameters.size());
  const Eigen::MatrixXd matrix = SelectBlock(information, parameters);
  Eigen::VectorXd right(size);
  for (Eigen::Index i = 0; i < size; ++i)
    right[i] = information.right[parameters[i]];
  const ObservableDirections observable = ComputeObservableDirections(matrix);
  const Eigen::VectorXd along =
      observable.vectors.transpose() * observable.unit.cwiseProduct(right);
  const Eigen::VectorXd shares = along.cwiseQuotient(observable.values);
  Estimate estimate;
  estimate.values = observable.unit.cwiseProduct(observable.vectors * shares);
  estimate.deviations = observable.unit.cwiseProduct(
      (observable.vectors.cwiseAbs2() * observable.values.cwiseInverse())
          .cwiseSqrt());
  estimate.chi_squared = along.dot(shares);
  estimate.degrees_of_freedom = static_cast<int>(observable.values.size());
  return estimate;
}

// Returns the inverse of ChiSquaredSigmas(); inaccurate below one degree of
// freedom.
double ChiSquaredAt(double sigmas, int degrees_of_freedom) {
  constexpr double kLeast = 0.02;  // times the degrees of freedom
  const double k = degrees_of_freedom;
  const double root = 1 - 2 / (9 * k) + sigmas * std::sqrt(2 / (9 * k));
  return k * std::max(kLeast, std::pow(root, 3));
}

// Returns the displacement in standard deviations that is detected with a power
// of 99 %. The cube root of a noncentral chi-squared variable is nearly normal
// (Abdel-Aty, 1954).
double MovementFound(int degrees_of_freedom) {
  const double k = degrees_of_freedom,
               alarm = ChiSquaredAt(kAlarmSigmas, degrees_of_freedom);
  double low = 0, high = 1e3;
  for (int round = 0; round < 60; ++round) {
    const double squared = (low + high) / 2, mean = k + squared;
    const double variance = 2 * (1 + squared / mean) / (9 * mean);
    const double below =
        (std::cbrt(alarm / mean) - (1 - variance)) / std::sqrt(variance);
    (below > -kDetectionSigmas ? low : high) = squared;
  }
  return std::sqrt(high);
}

// Result of testing a group of changes, with an additional standard deviation
// per direction for the errors of the calibration.
struct GroupTest {
  double chi_squared = 0;
  int degrees_of_freedom = 0;
  double information = 0;  // sum over the directions
  Eigen::VectorXd values, deviations;
  double detection_limit = 0;  // in any direction, with a power of 99 %
};

GroupTest TestGroup(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right,
                    double deviation) {
  constexpr double kMinEigenvalue = 1e-6, kNone = 1e-12;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  const Eigen::Index size = matrix.rows();
  const double own = deviation * deviation;
  GroupTest test;
  test.values.setZero(size);
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(size);
  for (Eigen::Index k = 0; k < size; ++k) {
    const double value = solver.eigenvalues()[k];
    if (value < kMinEigenvalue * solver.eigenvalues()[size - 1]) continue;
    const Eigen::VectorXd vector = solver.eigenvectors().col(k);
    const double moved = vector.dot(right) / value, variance = 1 / value + own;
    test.values += moved * vector;
    variances += variance * vector.cwiseAbs2();
    test.chi_squared += moved * moved / variance;
    test.information += value;
    ++test.degrees_of_freedom;
  }
  test.deviations = variances.cwiseSqrt();
  test.detection_limit =
      MovementFound(static_cast<int>(size)) *
      std::sqrt(1 / std::max(solver.eigenvalues()[0], kNone) + own);
  return test;
}

// Normal equations of local changes after eliminating the smooth ones.
struct LocalEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};

LocalEquations RemoveSmoothComponent(const Information& information) {
  const auto& matrix = information.matrix;
  const ObservableDirections observable = ComputeObservableDirections(
      matrix.topLeftCorner<kNumSmooth, kNumSmooth>());
  // Square root R of the inverse information on smooth changes: R R^T.
  const Eigen::MatrixXd root =
      observable.unit.asDiagonal() * observable.vectors *
      observable.values.cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::MatrixXd mixed =
      root.transpose() * matrix.topRightCorner<kNumSmooth, kNumLocal>();
  return {matrix.bottomRightCorner<kNumLocal, kNumLocal>() -
              mixed.transpose() * mixed,
          information.right.tail<kNumLocal>() -
              mixed.transpose() *
                  (root.transpose() * information.right.head<kNumSmooth>())};
}

constexpr int kNumGroups = 4;
using GroupTests = std::array<GroupTest, kNumGroups>;  // as in MovementErrors

std::array<double, kNumGroups> EstimateStdDevs(const ErrorModes& modes) {
  const MovementErrors& excess_errors = modes.excess_errors;
  return {excess_errors.scale, excess_errors.shift_px, excess_errors.tilt_rad,
          std::hypot(modes.residual_px, excess_errors.local_px)};
}

GroupTests TestGroups(const Information& information, const ErrorModes& modes) {
  const auto deviations = EstimateStdDevs(modes);
  const auto smooth = [&](int first, int count, double deviation) {
    return TestGroup(information.matrix.block(first, first, count, count),
                     information.right.segment(first, count), deviation);
  };
  const LocalEquations local = RemoveSmoothComponent(information);
  return {smooth(kScale, 1, deviations[0]), smooth(kShift, 2, deviations[1]),
          smooth(kTilt, 2, deviations[2]),
          TestGroup(local.matrix, local.right, deviations[3])};
}

// ---- Noise -----------------------------------------------------------------

// Returns the residuals after fitting all changes.
std::vector<Eigen::VectorXd> ComputeRemainingErrors(
    const std::vector<ReducedView>& views, const Eigen::VectorXd& movements) {
  std::vector<Eigen::VectorXd> remainders;
  for (const ReducedView& view : views)
    remainders.push_back(view.error - view.J_movements * movements);
  return remainders;
}

// Returns the variance inflation of smooth sums due to correlated residuals,
// assuming an AR(1) correlation r between neighbouring features in both
// directions.
double ComputeInflation(const std::vector<ProjectedView>& views,
                        const std::vector<Eigen::VectorXd>& remainders) {
  std::vector<FeatureResidual> residuals;
  for (size_t v = 0; v < views.size(); ++v)
    for (size_t i = 0; i < views[v].size(); ++i)
      residuals.push_back(
          {std::to_string(v), 0, views[v][i].column, views[v][i].row,
           views[v][i].pixel,
           remainders[v].segment<2>(2 * static_cast<Eigen::Index>(i))});
  const double standard_error =
      1 / std::sqrt(2.0 * static_cast<double>(residuals.size()));
  const double correlation = std::clamp(
      ComputeNeighborCorrelation(residuals).value_or(0) - 2 * standard_error,
      0.0, 0.8);
  return std::pow((1 + correlation) / (1 - correlation), 2);
}

double ComputeMedianErrorPx(const std::vector<ProjectedView>& views) {
  std::vector<double> norms;
  for (const ProjectedView& view : views)
    for (const ProjectedFeature& feature : view)
      norms.push_back(feature.error_px.norm());
  return Quantile(norms, 0.5);
}

std::vector<int> Range(int first, int count) {
  std::vector<int> range;
  for (int k = first; k < first + count; ++k) range.push_back(k);
  return range;
}

Movement MakeMovement(const std::string& name,
                      const std::vector<std::string>& parameters,
                      const GroupTest& test) {
  Movement movement;
  movement.name = name;
  movement.sigmas = ChiSquaredSigmas(test.chi_squared, test.degrees_of_freedom);
  movement.parameters = parameters;
  if (parameters.empty()) return movement;
  movement.values.assign(test.values.begin(), test.values.end());
  movement.deviations.assign(test.deviations.begin(), test.deviations.end());
  movement.detection_limit = test.detection_limit;
  return movement;
}

// Returns the smallest set of smooth changes whose remainder is insignificant;
// among sets of equal size, the one with the smallest remainder.
std::vector<std::string> Explain(const Information& information,
                                 double smooth_chi_squared) {
  struct Candidate {
    std::vector<std::string> names;
    std::vector<int> parameters;
  };
  const std::vector<Candidate> candidates = {
      {{"scale"}, {kScale}},
      {{"shift"}, {kShift, kShift + 1}},
      {{"tilt"}, {kTilt, kTilt + 1}},
      {{"scale", "shift"}, {kScale, kShift, kShift + 1}},
      {{"scale", "tilt"}, {kScale, kTilt, kTilt + 1}},
      {{"shift", "tilt"}, {kShift, kShift + 1, kTilt, kTilt + 1}}};
  for (const size_t count : {1, 2}) {
    const Candidate* best = nullptr;
    double least = kAlarmSigmas;
    for (const Candidate& candidate : candidates) {
      if (candidate.names.size() != count) continue;
      const Estimate estimate =
          EstimateParameters(information, candidate.parameters);
      const double left =
          ChiSquaredSigmas(smooth_chi_squared - estimate.chi_squared,
                           kNumSmooth - estimate.degrees_of_freedom);
      if (left >= least) continue;
      best = &candidate;
      least = left;
    }
    if (best) return best->names;
  }
  return {"scale", "shift", "tilt"};
}

// Finds the largest local change. Weakly observable directions are shrunk, with
// a prior variance according to the excess of the chi-squared value.
void ComputeMaxLocalChange(const ReferenceCamera& camera,
                           const LocalEquations& local, const GroupTest& test,
                           CameraChange* change) {
  const double local_variance_px2 =
      std::max(0.0, test.chi_squared - test.degrees_of_freedom) /
      test.information;
  const Eigen::VectorXd values =
      (local.matrix * local_variance_px2 +
       Eigen::MatrixXd::Identity(kNumLocal, kNumLocal))
          .ldlt()
          .solve(local_variance_px2 * local.right);
  for (int node = 0; node < kLocalColumns * kLocalRows; ++node) {
    const double norm = values.segment<2>(2 * node).norm();
    if (norm <= change->max_local_px) continue;
    change->max_local_px = norm;
    change->max_local_pixel = {
        camera.area.x0 +
            camera.area.width() * (node % kLocalColumns) / (kLocalColumns - 1),
        camera.area.y0 +
            camera.area.height() * (node / kLocalColumns) / (kLocalRows - 1)};
  }
}

// Errors of the views, and the information on changes, for the noise used by
// the test.
struct AssessedViews {
  std::vector<ReducedView> reduced;
  Information information;
  int num_features = 0;
  double noise_px = 0;
};

AssessedViews Assess(const ReferenceCamera& camera,
                     const std::vector<ProjectedView>& views) {
  // The median norm of 2D normal noise is 1.18 standard deviations.
  const double clip_px =
      kClipSigmas *
      std::max(camera.noise_px, ComputeMedianErrorPx(views) / 1.18);
  AssessedViews assessed;
  for (const ProjectedView& view : views) {
    assessed.reduced.push_back(Reduce(camera, view, clip_px));
    assessed.num_features += static_cast<int>(view.size());
  }
  const Estimate first = EstimateParameters(
      Gather(assessed.reduced, camera.noise_px), Range(0, kNumMovements));
  const std::vector<Eigen::VectorXd> remainders =
      ComputeRemainingErrors(assessed.reduced, first.values);
  double sum = 0;
  for (const Eigen::VectorXd& remainder : remainders)
    sum += remainder.squaredNorm();
  const double degrees_of_freedom =
      std::max(1.0, 2.0 * assessed.num_features -
                        6.0 * static_cast<double>(views.size()) -
                        first.degrees_of_freedom);
  assessed.noise_px =
      std::max(camera.noise_px, std::sqrt(sum / degrees_of_freedom)) *
      std::sqrt(ComputeInflation(views, remainders));
  assessed.information = Gather(assessed.reduced, assessed.noise_px);
  return assessed;
}

std::vector<std::string> SelectSignificant(
    const std::vector<Movement>& movements) {
  std::vector<std::string> names;
  for (const Movement& movement : movements)
    if (movement.sigmas > kAlarmSigmas) names.push_back(movement.name);
  return names;
}

bool CanDetectSmallChange(const ReferenceCamera& camera,
                          const std::vector<Movement>& movements) {
  constexpr double kPart = 0.01;
  for (const Movement& movement : movements) {
    const double unit = movement.name == "scale" ? 1
                        : movement.name == "shift"
                            ? std::max(camera.size.width, camera.size.height)
                            : 0;
    if (unit > 0 && !(movement.detection_limit <= kPart * unit)) return false;
  }
  return true;
}

}  // namespace

double ChiSquaredSigmas(double chi_squared, int degrees_of_freedom) {
  if (degrees_of_freedom <= 0) return 0;
  const double k = degrees_of_freedom;
  return (std::cbrt(std::max(chi_squared, 0.0) / k) - (1 - 2 / (9 * k))) /
         std::sqrt(2 / (9 * k));
}

CameraChange TestCameraChange(const ReferenceCamera& camera,
                              const std::vector<ProjectedView>& views) {
  const AssessedViews assessed = Assess(camera, views);
  const Information& information = assessed.information;
  CameraChange change;
  change.num_features = assessed.num_features;
  change.noise_px = assessed.noise_px;
  const Estimate smooth_estimate =
      EstimateParameters(information, Range(0, kNumSmooth));
  const GroupTests tests = TestGroups(information, camera.modes);
  change.movements = {
      MakeMovement("scale", {"relative_change"}, tests[0]),
      MakeMovement("shift", {"x_px", "y_px"}, tests[1]),
      MakeMovement("tilt", {"about_y_rad", "about_x_rad"}, tests[2])};
  for (const Movement& movement : change.movements)
    change.smooth_sigmas = std::max(change.smooth_sigmas, movement.sigmas);
  const GroupTest& local_test = tests[3];
  const Movement local = MakeMovement("local", {}, local_test);
  change.local_sigmas = local.sigmas;
  // Smooth changes partly explain a local change.
  const bool is_local = change.local_sigmas > kAlarmSigmas;
  const bool is_mostly_smooth =
      smooth_estimate.chi_squared > local_test.chi_squared;
  if (change.smooth_sigmas > kAlarmSigmas && (!is_local || is_mostly_smooth))
    change.moved = camera.modes.excess_errors.HasSmooth()
                       ? SelectSignificant(change.movements)
                       : Explain(information, smooth_estimate.chi_squared);
  if (is_local) {
    change.moved.push_back("local");
    ComputeMaxLocalChange(camera, RemoveSmoothComponent(information),
                          local_test, &change);
  }
  change.movements.push_back(local);
  change.is_degraded = !change.moved.empty();
  change.is_conclusive = CanDetectSmallChange(camera, change.movements);

  const Eigen::VectorXd fitted =
      is_local ? EstimateParameters(information, Range(0, kNumMovements)).values
               : (Eigen::VectorXd(kNumMovements) << smooth_estimate.values,
                  Eigen::VectorXd::Zero(kNumLocal))
                     .finished();
  for (const ReducedView& view : assessed.reduced)
    change.rms_px += (view.J_movements * fitted).squaredNorm();
  change.rms_px = std::sqrt(change.rms_px / std::max(1, change.num_features));
  return change;
}

MovementErrors ComputeExcessErrors(
    const ReferenceCamera& camera,
    const std::vector<std::vector<ProjectedView>>& unchanged) {
  constexpr double kSignificanceSigmas = 1.645;  // p = 1/20
  std::array<double, kNumGroups> chi_squared = {}, information = {};
  std::array<int, kNumGroups> degrees_of_freedom = {};
  for (const std::vector<ProjectedView>& views : unchanged) {
    const GroupTests tests =
        TestGroups(Assess(camera, views).information, camera.modes);
    for (int g = 0; g < kNumGroups; ++g) {
      chi_squared[g] += tests[g].chi_squared;
      information[g] += tests[g].information;
      degrees_of_freedom[g] += tests[g].degrees_of_freedom;
    }
  }
  const auto is_significant = [&](int g) {
    return ChiSquaredSigmas(chi_squared[g], degrees_of_freedom[g]) >
           kSignificanceSigmas;
  };
  // A local change partly resembles the smooth changes, which have few degrees
  // of freedom and must not become significant because of it: their limit is
  // exceeded in one of six cases.
  constexpr int kLocal = 3;
  const bool is_local = is_significant(kLocal);
  std::array<double, kNumGroups> deviations = {};
  for (int g = 0; g < kNumGroups; ++g) {
    if (!is_local && !is_significant(g)) continue;
    // The chi-squared variable is below this limit with equal probability.
    const double below = is_significant(g) ? -kSignificanceSigmas : -1;
    const double largest =
        chi_squared[g] / ChiSquaredAt(below, degrees_of_freedom[g]);
    deviations[g] = std::sqrt(std::max(0.0, largest - 1) *
                              degrees_of_freedom[g] / information[g]);
  }
  return {deviations[0], deviations[1], deviations[2], deviations[3]};
}

}  // namespace raygrid
