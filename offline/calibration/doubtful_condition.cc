#include "calibration/doubtful_condition.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

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
constexpr int kNumPose = 6;

struct ValueShift {
  double shift = 0, deviation = 0;
};

// The shift of a value with which the features of a view fit best, its pose
// being free: a step of Gauss-Newton. Nothing where they tell none.
std::optional<ValueShift> FindShift(const AdjustmentState& state,
                                    const View& view, size_t range) {
  const CameraStack& stack =
      dynamic_cast<const StackedGrid&>(*state.cameras[view.camera]).stack();
  const ConditionRange& of = stack.ranges()[range];
  const double step = kPartOfRange * (of.high - of.low);
  ConditionValues below = view.conditions, above = view.conditions;
  below[range] -= step;
  above[range] += step;
  const CentralGeneric cameras[] = {stack.At(below), stack.At(above)};
  const Pose camera_from_board = state.CameraFromPattern(view);

  using Normal = Eigen::Matrix<double, kNumPose + 1, kNumPose + 1>;
  using Sum = Eigen::Matrix<double, kNumPose + 1, 1>;
  Normal normal = Normal::Zero();
  Sum sum = Sum::Zero();
  double squares = 0;
  int count = 0;
  const std::vector<LinearizedResidual> residuals = LinearizeView(state, view);
  for (size_t k = 0; k < residuals.size(); ++k) {
    if (!residuals[k].residual.valid) continue;
    const Eigen::Vector3d point =
        camera_from_board *
        state.PointAt(view.pose, view.observations[k].point);
    const auto low = cameras[0].Project(point, &view.observations[k].pixel,
                                        kAdjustmentMarginPx);
    const auto high = cameras[1].Project(point, &view.observations[k].pixel,
                                         kAdjustmentMarginPx);
    if (!low || !high) continue;
    Eigen::Matrix<double, 2, kNumPose + 1> derivatives;
    derivatives.leftCols<kNumPose>() = residuals[k].by_pose;
    derivatives.col(kNumPose) = (*high - *low) / (2 * step);
    const Eigen::Vector2d& error = residuals[k].residual.error_px;
    normal += derivatives.transpose() * derivatives;
    sum += derivatives.transpose() * error;
    squares += error.squaredNorm();
    ++count;
  }
  const int freedom = 2 * count - kNumPose - 1;
  const Eigen::LDLT<Normal> solver(normal);
  if (freedom < 1 || solver.info() != Eigen::Success || !solver.isPositive())
    return std::nullopt;
  const Sum best = -solver.solve(sum);
  const Sum unit = Sum::Unit(kNumPose);
  const double inverse = solver.solve(unit)[kNumPose];
  const double left = std::max(0.0, squares + sum.dot(best));
  ValueShift found = {best[kNumPose], std::sqrt(left / freedom * inverse)};
  if (!std::isfinite(found.shift) || !(found.deviation > 0))
    return std::nullopt;
  return found;
}

// Shifts in their deviations, and how far these scatter: other errors of the
// model shift values as well.
double ScatterOf(const std::vector<std::optional<ValueShift>>& shifts) {
  std::vector<double> sizes;
  for (const auto& found : shifts)
    if (found) sizes.push_back(std::abs(found->shift) / found->deviation);
  if (sizes.empty()) return 1;
  constexpr double kPerMedian = 1.4826;  // of normal errors
  return std::max(1.0, kPerMedian * Quantile(sizes, 0.5));
}

}  // namespace

std::string DoubtfulCondition::Text() const {
  const std::string unit = ConditionUnit(condition);
  return fmt::format("{} was told at {:.4g} {}, and fits better near {:.2g}",
                     image, told, unit, seems);
}

std::vector<DoubtfulCondition> FindDoubtfulConditions(
    const Adjusted& adjusted) {
  const AdjustmentState& state = adjusted.state;
  const std::vector<View>& views = adjusted.problem.views;
  const CameraStack& stack =
      dynamic_cast<const StackedGrid&>(state.camera()).stack();
  std::vector<DoubtfulCondition> doubtful;
  for (size_t range = 0; range < stack.ranges().size(); ++range) {
    const ConditionRange& of = stack.ranges()[range];
    std::vector<std::optional<ValueShift>> shifts;
    for (const View& view : views)
      shifts.push_back(FindShift(state, view, range));
    const double scatter = ScatterOf(shifts);
    for (size_t v = 0; v < views.size(); ++v) {
      if (!shifts[v]) continue;
      const double size = std::abs(shifts[v]->shift);
      const double deviation = scatter * shifts[v]->deviation;
      if (size < kManyDeviations * deviation ||
          size < kLeastPart * (of.high - of.low))
        continue;
      const double told = views[v].conditions[range];
      doubtful.push_back({adjusted.problem.images[v], of.condition, told,
                          told + shifts[v]->shift, deviation});
    }
  }
  const auto doubt = [](const DoubtfulCondition& of) {
    return std::abs(of.seems - of.told) / of.deviation;
  };
  std::stable_sort(doubtful.begin(), doubtful.end(),
                   [&](const DoubtfulCondition& a, const DoubtfulCondition& b) {
                     return doubt(a) > doubt(b);
                   });
  while (!doubtful.empty() &&
         doubt(doubtful.back()) < kPartOfWorst * doubt(doubtful.front()))
    doubtful.pop_back();
  return doubtful;
}

}  // namespace raygrid
