#include "calibration/doubtful_condition.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "adjustment/reprojection_error.h"
#include "camera/stacked_grid.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// Nothing is said of less than this part of the range, nor of fewer deviations,
// be they the view's own or of all views' differences.
constexpr double kLeastPart = 0.05, kManyDeviations = 6;
// A wrong value bends the stack, so that others seem wrong besides: those less
// doubtful than this part of the worst are not told.
constexpr double kPartOfWorst = 0.5;
constexpr double kPartOfRange = 1e-3;  // the step of differences
constexpr double kToldPart = 0.02;     // of the range, that decimals tell
constexpr int kNumPose = 6;

struct ValueShift {
  double shift = 0, deviation = 0;
};

// The derivatives of projections by a stack's values at those of a view, by
// differences.
class ValueDerivatives {
 public:
  ValueDerivatives(const CameraStack& stack, const View& view) {
    for (size_t r = 0; r < stack.ranges().size(); ++r) {
      const ConditionRange& range = stack.ranges()[r];
      const double step = kPartOfRange * (range.high - range.low);
      ConditionValues below = view.conditions, above = view.conditions;
      below[r] -= step;
      above[r] += step;
      sides_.push_back({stack.At(below), stack.At(above), 2 * step});
    }
  }

  // Columns of 2; false where a camera does not see the point.
  bool At(const Eigen::Vector3d& point, const Eigen::Vector2d& pixel,
          Eigen::Matrix2Xd* derivatives) const {
    derivatives->resize(2, static_cast<Eigen::Index>(sides_.size()));
    for (size_t r = 0; r < sides_.size(); ++r) {
      const auto low =
          sides_[r].below.Project(point, &pixel, kAdjustmentMarginPx);
      const auto high =
          sides_[r].above.Project(point, &pixel, kAdjustmentMarginPx);
      if (!low || !high) return false;
      derivatives->col(static_cast<Eigen::Index>(r)) =
          (*high - *low) / sides_[r].apart;
    }
    return true;
  }

 private:
  struct Sides {
    CentralGeneric below, above;
    double apart;
  };
  std::vector<Sides> sides_;
};

// The shifts of all values with which the features of a view fit best, its pose
// being free: a step of Gauss-Newton. None where features tell none.
std::vector<ValueShift> FindShifts(const AdjustmentState& state,
                                   const View& view) {
  const CameraStack& stack =
      dynamic_cast<const StackedGrid&>(*state.cameras[view.camera]).stack();
  const ValueDerivatives by_values(stack, view);
  const Pose camera_from_board = state.CameraFromPattern(view);
  const auto num_values = static_cast<Eigen::Index>(stack.ranges().size());
  const Eigen::Index num = kNumPose + num_values;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(num, num);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(num);
  double squares = 0;
  int count = 0;
  Eigen::Matrix2Xd of_values, derivatives(2, num);
  const std::vector<LinearizedResidual> residuals = LinearizeView(state, view);
  for (size_t k = 0; k < residuals.size(); ++k) {
    if (!residuals[k].residual.valid) continue;
    const Eigen::Vector3d point =
        camera_from_board *
        state.PointAt(view.pose, view.observations[k].point);
    if (!by_values.At(point, view.observations[k].pixel, &of_values)) continue;
    derivatives.leftCols<kNumPose>() = residuals[k].by_pose;
    derivatives.rightCols(num_values) = of_values;
    const Eigen::Vector2d& error = residuals[k].residual.error_px;
    normal += derivatives.transpose() * derivatives;
    sum += derivatives.transpose() * error;
    squares += error.squaredNorm();
    ++count;
  }
  const int freedom = 2 * count - static_cast<int>(num);
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
  if (freedom < 1 || solver.info() != Eigen::Success || !solver.isPositive())
    return {};
  const Eigen::VectorXd best = -solver.solve(sum);
  const Eigen::MatrixXd inverse =
      solver.solve(Eigen::MatrixXd::Identity(num, num));
  const double variance = std::max(0.0, squares + sum.dot(best)) / freedom;
  std::vector<ValueShift> shifts;
  for (Eigen::Index r = kNumPose; r < num; ++r) {
    shifts.push_back({best[r], std::sqrt(variance * inverse(r, r))});
    if (!std::isfinite(best[r]) || !(shifts.back().deviation > 0)) return {};
  }
  return shifts;
}

// How far shifts of a condition scatter, in their deviations: other errors of
// the model shift values as well.
double ScatterOf(const std::vector<std::vector<ValueShift>>& shifts,
                 size_t range) {
  std::vector<double> sizes;
  for (const auto& of_view : shifts)
    if (!of_view.empty())
      sizes.push_back(std::abs(of_view[range].shift) /
                      of_view[range].deviation);
  if (sizes.empty()) return 1;
  constexpr double kPerMedian = 1.4826;  // of normal errors
  return std::max(1.0, kPerMedian * Quantile(sizes, 0.5));
}

// One in each image: boards that it shows tell the same value.
void KeepWorstOfImages(std::vector<DoubtfulCondition>* doubtful) {
  std::set<std::pair<std::string, CameraCondition>> named;
  const auto end = std::remove_if(
      doubtful->begin(), doubtful->end(), [&](const DoubtfulCondition& of) {
        return !named.insert({of.image, of.condition}).second;
      });
  doubtful->erase(end, doubtful->end());
}

}  // namespace

std::string DoubtfulCondition::Text() const {
  return fmt::format("{} was told at {:g} {}, and fits better near {:.{}f}",
                     image, told, ConditionUnit(condition), seems,
                     num_decimals);
}

std::vector<DoubtfulCondition> FindDoubtfulConditions(
    const Adjusted& adjusted) {
  const AdjustmentState& state = adjusted.state;
  const std::vector<View>& views = adjusted.problem.views;
  const std::vector<ConditionRange> ranges =
      dynamic_cast<const StackedGrid&>(state.camera()).stack().ranges();
  std::vector<std::vector<ValueShift>> shifts;
  for (const View& view : views) shifts.push_back(FindShifts(state, view));
  std::vector<DoubtfulCondition> doubtful;
  for (size_t r = 0; r < ranges.size(); ++r) {
    const double width = ranges[r].high - ranges[r].low;
    const double scatter = ScatterOf(shifts, r);
    const int num_decimals = std::clamp(
        static_cast<int>(std::ceil(-std::log10(kToldPart * width))), 0, 9);
    for (size_t v = 0; v < views.size(); ++v) {
      if (shifts[v].empty()) continue;
      const ValueShift& found = shifts[v][r];
      const double doubt = std::abs(found.shift) / (scatter * found.deviation);
      if (doubt < kManyDeviations || std::abs(found.shift) < kLeastPart * width)
        continue;
      const double told = views[v].conditions[r];
      doubtful.push_back(
          {adjusted.problem.images[v], ranges[r].condition, told,
           std::clamp(told + found.shift, ranges[r].low, ranges[r].high), doubt,
           num_decimals});
    }
  }
  std::stable_sort(doubtful.begin(), doubtful.end(),
                   [](const DoubtfulCondition& a, const DoubtfulCondition& b) {
                     return a.doubt > b.doubt;
                   });
  while (!doubtful.empty() &&
         doubtful.back().doubt < kPartOfWorst * doubtful.front().doubt)
    doubtful.pop_back();
  KeepWorstOfImages(&doubtful);
  return doubtful;
}

}  // namespace raygrid
