#include "calibration/stack_start.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "calibration/camera_in_progress.h"
#include "calibration/continued_lens.h"
#include "calibration/starting_lens.h"
#include "camera/stacked_grid.h"
#include "camera/stereographic.h"

namespace raygrid {
namespace {

// Images whose values are nearest to each other, enough for a lens; and all
// others with the same values. Of several such, those in the middle.
Dataset ImagesOfLikeValue(const Dataset& dataset,
                          const ImageConditions& conditions) {
  constexpr size_t kEnough = 12;
  std::vector<double> values;
  for (const ImageFeatures& image : dataset.images)
    values.push_back(conditions.values.at(image.image));
  std::sort(values.begin(), values.end());
  const size_t count = std::min(kEnough, values.size());
  const double middle = (values.front() + values.back()) / 2;
  double low = values.front(), high = values[count - 1];
  for (size_t first = 1; first + count <= values.size(); ++first) {
    const double from = values[first], to = values[first + count - 1];
    const double gain = (high - low) - (to - from);
    if (gain > 0 || (gain == 0 && std::abs(from + to - 2 * middle) <
                                      std::abs(low + high - 2 * middle))) {
      low = from;
      high = to;
    }
  }
  Dataset like = {dataset.image_size, {}};
  for (const ImageFeatures& image : dataset.images) {
    const double value = conditions.values.at(image.image);
    if (value >= low && value <= high) like.images.push_back(image);
  }
  return like;
}

// The rotation between the frames of two cameras of one image.
Eigen::Matrix3d FindTurn(const CameraModel& from, const CameraModel& to,
                         const std::vector<Eigen::Vector2d>& pixels) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector2d& pixel : pixels) {
    const auto a = from.Unproject(pixel), b = to.Unproject(pixel);
    if (a && b) sum += *b * a->transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, 1);
  signs[2] = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

std::pair<double, double> RangeOf(const Dataset& dataset,
                                  const ImageConditions& conditions) {
  double low = INFINITY, high = -INFINITY;
  for (const ImageFeatures& image : dataset.images) {
    const double value = conditions.values.at(image.image);
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return {low, high};
}

int NumValues(const Dataset& dataset, const ImageConditions& conditions) {
  std::set<double> values;
  for (const ImageFeatures& image : dataset.images)
    values.insert(conditions.values.at(image.image));
  return static_cast<int>(values.size());
}

// A stack of one term more, which does not change it.
CameraStack WithOneMore(const CameraStack& stack) {
  CameraStack more = stack;
  const BSplineSurface& surface = stack.terms().front();
  more.terms().emplace_back(surface.area(), surface.columns(), surface.rows());
  return more;
}

// Adjusts stacks of one term more each time, from a linear one on, as long as
// that predicts better: Akaike's criterion. A term has at least as many
// parameters as its prior leaves free.
CameraStack ChooseOrder(CameraStack stack, int max_order,
                        const CalibrationProblem& problem,
                        const AdjustmentOptions& options,
                        AdjustmentState* state) {
  std::optional<CameraStack> best;
  double best_cost = 0;
  const CentralGeneric base = stack.At(stack.middle());
  for (;; stack = WithOneMore(*best)) {
    state->SetCamera(StackedGrid(stack, stack.middle()));
    GaussianPrior prior;
    prior.cameras = {StackPrior(base, stack.order())};
    prior.points_mean = problem.nominal;
    const AdjustmentSummary summary =
        AdjustWithLearnedPrior(problem.views, options, &prior, state);
    const auto num_free =
        static_cast<double>(prior.cameras[0].groups[0].free.cols());
    const double needed = num_free * summary.noise_px * summary.noise_px;
    if (best && !(summary.final_cost < best_cost - needed)) return *best;
    best = dynamic_cast<const StackedGrid&>(state->camera()).stack();
    best_cost = summary.final_cost;
    if (best->order() >= max_order) return *best;
  }
}

}  // namespace

CameraStack StartStack(const Dataset& dataset,
                       const ImageConditions& conditions,
                       const Pattern& pattern,
                       const CalibrationOptions& options) {
  constexpr double kCellsAcross = 8;
  AdjustmentOptions adjustment = AdjustmentOptionsOf(options);
  const Adjusted lens =
      AdjustStartingLens(ImagesOfLikeValue(dataset, conditions), pattern,
                         adjustment, options.area);
  std::vector<RejectedImage> rejected;
  CalibrationProblem problem = BuildProblem({dataset}, pattern, &rejected);
  problem.area = options.area;
  const auto located =
      LocalizeViews(lens.state.camera(), 0, problem, options.num_threads);
  std::vector<bool> are_lost;
  for (const std::optional<Pose>& pose : located) are_lost.push_back(!pose);
  RemoveViews(are_lost, &problem);

  const Area area = CalibratedArea(problem, 0);
  const double cell_px = std::max(area.width(), area.height()) / kCellsAcross;
  const CentralGeneric base = FitContinuedLens(
      lens.state.camera(), area, NumControlPoints(area.width(), cell_px),
      NumControlPoints(area.height(), cell_px));
  const auto [low, high] = RangeOf(dataset, conditions);

  AdjustmentState state;
  state.points = problem.nominal;
  state.rig_from_pattern.resize(problem.num_poses);
  size_t kept = 0;
  for (const std::optional<Pose>& pose : located) {
    if (!pose) continue;
    View& view = problem.views[kept];
    view.condition = conditions.values.at(problem.images[kept]);
    state.rig_from_pattern[view.pose] = *pose;
    ++kept;
  }
  adjustment.fix_points = true;
  return ChooseOrder(CameraStack(conditions.condition, low, high, base, 1),
                     MaxStackOrder(NumValues(dataset, conditions)), problem,
                     adjustment, &state);
}

Dataset BringToMiddle(const Dataset& dataset, const ImageConditions& conditions,
                      const CameraStack& stack) {
  const CentralGeneric middle = stack.At(stack.middle());
  Dataset brought = {dataset.image_size, {}};
  for (const ImageFeatures& image : dataset.images) {
    const CentralGeneric camera = stack.At(conditions.values.at(image.image));
    brought.images.push_back({image.image, {}});
    for (Feature feature : image.features) {
      const auto direction = camera.Unproject(feature.pixel);
      if (!direction) continue;
      const auto pixel = middle.Project(*direction, &feature.pixel, 0);
      if (!pixel) continue;
      feature.pixel = *pixel;
      brought.images.back().features.push_back(feature);
    }
  }
  return brought;
}

CameraStack ChangesOnGrid(const CameraStack& stack,
                          const CentralGeneric& camera) {
  constexpr int kPerCell = 3;
  CameraStack moved(stack.condition(), stack.low(), stack.high(), camera,
                    stack.order());
  const int count = stack.order() + 1;
  const std::vector<Eigen::Vector2d> pixels =
      camera.surface().SamplePixels(kPerCell);
  const Eigen::Matrix3d turn =
      FindTurn(stack.At(stack.middle()), camera, pixels);
  // The polynomials through the stack's directions at as many values as they
  // have terms.
  std::vector<CentralGeneric> cameras;
  Eigen::MatrixXd powers(count, count);
  for (int i = 0; i < count; ++i) {
    const double value =
        stack.low() + (stack.high() - stack.low()) * (i + 0.5) / count;
    cameras.push_back(stack.At(value));
    const std::vector<double> row = stack.Powers(value);
    powers.row(i) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), count);
  }
  const Eigen::MatrixXd to_terms = powers.inverse();
  std::vector<std::vector<SurfaceSample>> samples(count);
  for (const Eigen::Vector2d& pixel : pixels) {
    Eigen::MatrixXd charts(count, 2);
    for (int i = 0; i < count; ++i)
      charts.row(i) = ToChart(turn * *cameras[i].Unproject(pixel)).transpose();
    const Eigen::MatrixXd terms = to_terms * charts;
    for (int j = 1; j < count; ++j)
      samples[j].push_back({pixel, terms.row(j).transpose()});
  }
  const BSplineSurface& surface = camera.surface();
  for (int j = 1; j < count; ++j)
    moved.terms()[j] = FitSurface(surface.area(), surface.columns(),
                                  surface.rows(), samples[j]);
  return moved;
}

}  // namespace raygrid
