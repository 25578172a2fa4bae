#include "calibration/value_equations.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "adjustment/linear_response.h"
#include "camera/operating_point_model.h"

namespace raygrid {
namespace {

constexpr double kRelativeStep = 1e-3;  // step of numeric differentiation
constexpr int kNumPose = 6;

// Numeric derivatives of projections with respect to the operating point of a
// view.
class ValueDerivatives {
 public:
  ValueDerivatives(const OperatingPointModel& stack, const View& view) {
    for (size_t r = 0; r < stack.ranges().size(); ++r) {
      const OperatingRange& range = stack.ranges()[r];
      const double step = kRelativeStep * (range.high - range.low);
      OperatingPoint below = view.conditions, above = view.conditions;
      below[r] -= step;
      above[r] += step;
      differences_.push_back({stack.At(below), stack.At(above), 2 * step});
    }
  }

  // Returns one column (2 rows) per parameter; zero where a camera cannot
  // project the point.
  Eigen::Matrix2Xd At(const Eigen::Vector3d& point,
                      const Eigen::Vector2d& pixel) const {
    Eigen::Matrix2Xd derivatives(
        2, static_cast<Eigen::Index>(differences_.size()));
    for (size_t r = 0; r < differences_.size(); ++r) {
      const auto low =
          differences_[r].below.Project(point, &pixel, kAdjustmentMarginPx);
      const auto high =
          differences_[r].above.Project(point, &pixel, kAdjustmentMarginPx);
      if (!low || !high) return Eigen::Matrix2Xd::Zero(2, derivatives.cols());
      derivatives.col(static_cast<Eigen::Index>(r)) =
          (*high - *low) / differences_[r].apart;
    }
    return derivatives;
  }

 private:
  struct OneSidedDifferences {
    CentralGeneric below, above;
    double apart;
  };
  std::vector<OneSidedDifferences> differences_;
};

// The valid residuals of a view, two rows each, scaled by the square root of
// the loss weight, and their Jacobians with respect to the view's pose and its
// operating point.
struct ViewEquations {
  Eigen::VectorXd error;
  Eigen::MatrixXd J_pose, J_values;

  // Returns the least-squares pose step for the given errors. EliminatePose()
  // returns the errors that remain after this step.
  Eigen::MatrixXd PoseStep(const Eigen::MatrixXd& errors) const {
    const Eigen::MatrixXd normal = J_pose.transpose() * J_pose;
    return normal.ldlt().solve(J_pose.transpose() * errors);
  }
  Eigen::MatrixXd EliminatePose(const Eigen::MatrixXd& errors) const {
    return errors - J_pose * PoseStep(errors);
  }
};

ViewEquations MakeViewEquations(const AdjustmentState& state,
                                const View& view) {
  const ValueDerivatives J_values(*state.camera().GetOperatingPointModel(),
                                  view);
  const Pose camera_from_board = state.ComputeCameraFromPattern(view);
  const std::vector<LinearizedResidual> residuals = LinearizeView(state, view);
  const double huber_px = AdjustmentOptions().huber_px;
  const Eigen::Index num_rows =
      2 * std::count_if(residuals.begin(), residuals.end(),
                        [](const auto& r) { return r.residual.valid; });
  ViewEquations equations = {
      Eigen::VectorXd(num_rows), Eigen::MatrixXd(num_rows, kNumPose),
      Eigen::MatrixXd(num_rows,
                      static_cast<Eigen::Index>(view.conditions.size()))};
  Eigen::Index row = 0;
  for (size_t k = 0; k < residuals.size(); ++k) {
    const LinearizedResidual& r = residuals[k];
    if (!r.residual.valid) continue;
    const double root =
        std::sqrt(HuberWeight(r.residual.error_px.norm(), huber_px));
    const Eigen::Vector3d point =
        camera_from_board *
        state.PointAt(view.pose, view.observations[k].point);
    equations.error.segment<2>(row) = root * r.residual.error_px;
    equations.J_pose.middleRows<2>(row) = root * r.J_pose;
    equations.J_values.middleRows<2>(row) =
        root * J_values.At(point, view.observations[k].pixel);
    row += 2;
  }
  return equations;
}

// Returns the standard deviation of the residuals, corrected for the degrees of
// freedom of poses and values.
double EstimateNoisePx(const std::vector<ViewEquations>& views) {
  double squares = 0;
  Eigen::Index degrees_of_freedom = 0;
  const Eigen::Index num_values = views.front().J_values.cols();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(num_values, num_values);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(num_values);
  for (const ViewEquations& view : views) {
    const Eigen::MatrixXd J_values_without_pose =
        view.EliminatePose(view.J_values);
    const Eigen::VectorXd error = view.EliminatePose(view.error);
    normal += J_values_without_pose.transpose() * J_values_without_pose;
    gradient += J_values_without_pose.transpose() * error;
    squares += error.squaredNorm();
    degrees_of_freedom += error.size() - kNumPose;
  }
  squares -= gradient.dot(normal.ldlt().solve(gradient));
  degrees_of_freedom -= num_values;
  return degrees_of_freedom > 0 && squares > 0
             ? std::sqrt(squares / static_cast<double>(degrees_of_freedom))
             : 0;
}

// Returns the image index of each view, and lists the images in order of
// appearance.
std::vector<int> NumberImages(const CalibrationProblem& problem,
                              std::vector<std::string>* images) {
  std::vector<int> numbers;
  for (const std::string& image : problem.images) {
    const auto found = std::find(images->begin(), images->end(), image);
    numbers.push_back(static_cast<int>(found - images->begin()));
    if (found == images->end()) images->push_back(image);
  }
  return numbers;
}

}  // namespace

ValueStep ValueEquations::ComputeStep(Eigen::Index unknown) const {
  // Minimum ratio of the information to that with a fixed camera; less is not
  // observable.
  constexpr double kMinInformationRatio = 1e-6;
  const double found = information[unknown];
  if (!(found > kMinInformationRatio * fixed_camera_information[unknown]))
    return {0, INFINITY};
  return {-gradient[unknown] / found,
          noise_px[GetImageIndex(unknown)] / std::sqrt(found)};
}

ValueEquations MakeValueEquations(const AdjustmentResult& adjusted,
                                  int num_threads) {
  const std::vector<View>& views = adjusted.problem.views;
  ValueEquations result;
  result.num_ranges = static_cast<int>(
      adjusted.state.camera().GetOperatingPointModel()->ranges().size());
  const std::vector<int> image_index_by_unknown =
      NumberImages(adjusted.problem, &result.images);
  const int num_images = static_cast<int>(result.images.size());

  AdjustmentOptions options;
  options.num_threads = num_threads;
  options.fix_points = !HavePointsMoved(adjusted);
  const LinearResponse response(views, adjusted.prior, options, adjusted.state);
  ViewErrors none;
  for (const ViewJacobian& jacobian : response.jacobians())
    none.push_back(Eigen::Matrix2Xd::Zero(2, jacobian.count()));

  std::vector<std::vector<ViewEquations>> by_image(num_images);
  const Eigen::Index num_values =
      static_cast<Eigen::Index>(num_images) * result.num_ranges;
  result.gradient = Eigen::VectorXd::Zero(num_values);
  result.fixed_camera_information = Eigen::VectorXd::Zero(num_values);
  Eigen::MatrixXd right =
      Eigen::MatrixXd::Zero(response.layout().num_all(), num_values);
  for (size_t v = 0; v < views.size(); ++v) {
    const ViewEquations equations = MakeViewEquations(adjusted.state, views[v]);
    const Eigen::Index first =
        static_cast<Eigen::Index>(image_index_by_unknown[v]) *
        result.num_ranges;
    // The pose is eliminated per view, since it absorbs most of the change.
    const Eigen::MatrixXd J_values_without_pose =
        equations.EliminatePose(equations.J_values);
    result.gradient.segment(first, result.num_ranges) +=
        J_values_without_pose.transpose() * equations.error;
    result.fixed_camera_information.segment(first, result.num_ranges) +=
        J_values_without_pose.colwise().squaredNorm().transpose();
    for (int r = 0; r < result.num_ranges; ++r) {
      const Eigen::VectorXd column = J_values_without_pose.col(r);
      none[v] = Eigen::Map<const Eigen::Matrix2Xd>(column.data(), 2,
                                                   column.size() / 2);
      right.col(first + r) += response.Gradient(none);
      none[v].setZero();
    }
    by_image[image_index_by_unknown[v]].push_back(equations);
  }
  Eigen::MatrixXd moves;
  if (!response.Solve(right, &moves)) return {};
  result.information = result.fixed_camera_information -
                       right.cwiseProduct(moves).colwise().sum().transpose();
  for (const auto& of_image : by_image)
    result.noise_px.push_back(
        std::max(EstimateNoisePx(of_image), adjusted.summary.noise_px));
  return result;
}

ValueStep FitValue(AdjustmentState state, const std::vector<View>& views,
                   size_t range, const OperatingRange& limits) {
  constexpr int kMaxSteps = 12;
  constexpr double kRelativeTolerance = 0.05;
  const auto column = static_cast<Eigen::Index>(range);
  const double stated = views.front().conditions[range];
  double value = stated;
  ValueStep found = {0, INFINITY};
  for (int step = 0; step < kMaxSteps; ++step) {
    std::vector<ViewEquations> equations;
    double information = 0, gradient = 0;
    for (View view : views) {
      view.conditions[range] = value;
      equations.push_back(MakeViewEquations(state, view));
      const ViewEquations& own = equations.back();
      const Eigen::VectorXd J_values_without_pose =
          own.EliminatePose(own.J_values.col(column));
      information += J_values_without_pose.squaredNorm();
      gradient += J_values_without_pose.dot(own.error);
    }
    if (!(information > 0)) return {0, INFINITY};
    const double before = value;
    value =
        std::clamp(before - gradient / information, limits.low, limits.high);
    found = {value - stated,
             EstimateNoisePx(equations) / std::sqrt(information)};
    for (size_t k = 0; k < views.size(); ++k) {
      Pose& pose = state.rig_from_pattern[views[k].pose];
      pose = UpdatedPose(
          pose, -equations[k].PoseStep(equations[k].error +
                                       (value - before) *
                                           equations[k].J_values.col(column)));
    }
    if (std::abs(value - before) < kRelativeTolerance * found.deviation) break;
  }
  return found;
}

}  // namespace raygrid
