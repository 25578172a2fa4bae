#include "calibration/operating_point_initialization.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "adjustment/smoothness_prior.h"
#include "calibration/camera_in_progress.h"
#include "calibration/camera_initialization.h"
#include "calibration/extrapolated_grid.h"
#include "camera/nearest_rotation.h"
#include "camera/operating_point_grid.h"
#include "camera/stereographic.h"

namespace raygrid {
namespace {

// Selects the images with the most similar values of the first parameter,
// enough to initialize a camera, and all others within the same interval; of
// several such groups, the most central one. The second parameter, temperature,
// changes the camera by less than the differences accepted here.
Dataset SelectImagesOfSimilarValue(const Dataset& dataset,
                                   const ImageOperatingPoints& conditions) {
  constexpr size_t kMaxImages = 12;
  std::vector<double> values;
  for (const ImageFeatures& image : dataset.images)
    values.push_back(conditions.values.at(image.image).front());
  std::sort(values.begin(), values.end());
  const size_t count = std::min(kMaxImages, values.size());
  const double center = (values.front() + values.back()) / 2;
  double low = values.front(), high = values[count - 1];
  for (size_t first = 1; first + count <= values.size(); ++first) {
    const double from = values[first], to = values[first + count - 1];
    const double gain = (high - low) - (to - from);
    if (gain > 0 || (gain == 0 && std::abs(from + to - 2 * center) <
                                      std::abs(low + high - 2 * center))) {
      low = from;
      high = to;
    }
  }
  Dataset similar = {dataset.image_size, {}};
  for (const ImageFeatures& image : dataset.images) {
    const double value = conditions.values.at(image.image).front();
    if (value >= low && value <= high) similar.images.push_back(image);
  }
  return similar;
}

// Returns the distinct values of a parameter in ascending order.
std::set<double> ReadParameterValues(const Dataset& dataset,
                                     const ImageOperatingPoints& conditions,
                                     size_t condition) {
  std::set<double> values;
  for (const ImageFeatures& image : dataset.images)
    values.insert(conditions.values.at(image.image)[condition]);
  return values;
}

// Adds polynomial terms of one parameter after another, beginning with linear
// ones, as long as Akaike's information criterion improves. The penalty of a
// term counts the parameters that its prior leaves unpenalized.
class OrderSelection {
 public:
  OrderSelection(const CentralGeneric& base, const CalibrationProblem& problem,
                 const AdjustmentOptions& options, AdjustmentState* state)
      : base_(base), problem_(problem), options_(options), state_(state) {}

  OperatingPointModel SelectOrders(OperatingPointModel best,
                                   const std::vector<int>& max_orders) {
    double needed = 0;
    double best_cost = OptimizeCameras(&best, &needed);
    for (size_t r = 0; r < max_orders.size(); ++r) {
      while (best.orders()[r] < max_orders[r]) {
        OperatingPointModel more = best.AddOrder(r);
        const double cost = OptimizeCameras(&more, &needed);
        if (!(cost < best_cost - needed)) break;
        best = std::move(more);
        best_cost = cost;
      }
    }
    return best;
  }

 private:
  // Returns the cost, and the decrease required to accept another term.
  double OptimizeCameras(OperatingPointModel* stack, double* needed) {
    state_->SetCamera(OperatingPointGrid(*stack, stack->Center()));
    GaussianPrior prior;
    prior.cameras = {MakeOperatingPointPrior(
        base_, static_cast<int>(stack->terms().size()))};
    prior.points_mean = problem_.nominal;
    const AdjustmentSummary summary =
        OptimizeWithLearnedPrior(problem_.views, options_, &prior, state_);
    const auto num_free =
        static_cast<double>(prior.cameras[0].groups[0].free.cols());
    *needed = num_free * summary.noise_px * summary.noise_px;
    *stack = *state_->camera().GetOperatingPointModel();
    return summary.final_cost;
  }

  const CentralGeneric& base_;
  const CalibrationProblem& problem_;
  const AdjustmentOptions& options_;
  AdjustmentState* state_;
};

}  // namespace

OperatingPointModel InitializeOperatingPointModel(
    const Dataset& dataset, const ImageOperatingPoints& conditions,
    const Pattern& pattern, const CalibrationOptions& options) {
  constexpr double kCellsAcross = 8;
  AdjustmentOptions adjustment = MakeAdjustmentOptions(options);
  const AdjustmentResult lens =
      InitializeCamera(SelectImagesOfSimilarValue(dataset, conditions), pattern,
                       adjustment, options.area);
  std::vector<RejectedImage> rejected;
  CalibrationProblem problem = BuildProblem({dataset}, pattern, &rejected);
  problem.area = options.area;
  const auto located =
      LocalizeViews(lens.state.camera(), 0, problem, options.num_threads);
  std::vector<bool> are_lost;
  for (const std::optional<Pose>& pose : located) are_lost.push_back(!pose);
  RemoveViews(are_lost, &problem);

  const Area area = ComputeCalibratedArea(problem, 0);
  const double knot_spacing_px =
      std::max(area.width(), area.height()) / kCellsAcross;
  const CentralGeneric base =
      FitExtrapolatedGrid(lens.state.camera(), area,
                          NumControlPoints(area.width(), knot_spacing_px),
                          NumControlPoints(area.height(), knot_spacing_px));
  std::vector<OperatingRange> ranges;
  std::vector<int> max_orders;
  for (size_t k = 0; k < conditions.conditions.size(); ++k) {
    const std::set<double> values = ReadParameterValues(dataset, conditions, k);
    ranges.push_back(
        {conditions.conditions[k], *values.begin(), *values.rbegin()});
    max_orders.push_back(MaxPolynomialOrder(static_cast<int>(values.size())));
  }

  AdjustmentState state;
  state.points = problem.nominal;
  state.rig_from_pattern.resize(problem.num_poses);
  size_t kept = 0;
  for (const std::optional<Pose>& pose : located) {
    if (!pose) continue;
    View& view = problem.views[kept];
    view.conditions = conditions.values.at(problem.images[kept]);
    state.rig_from_pattern[view.pose] = *pose;
    ++kept;
  }
  adjustment.fix_points = true;
  const OperatingPointModel linear(ranges, std::vector<int>(ranges.size(), 1),
                                   base);
  return OrderSelection(base, problem, adjustment, &state)
      .SelectOrders(linear, max_orders);
}

Dataset MapFeaturesToReference(const Dataset& dataset,
                               const ImageOperatingPoints& conditions,
                               const OperatingPointModel& stack) {
  const CentralGeneric center = stack.At(stack.Center());
  Dataset mapped = {dataset.image_size, {}};
  for (const ImageFeatures& image : dataset.images) {
    const CentralGeneric camera = stack.At(conditions.values.at(image.image));
    mapped.images.push_back({image.image, {}});
    for (Feature feature : image.features) {
      const auto direction = camera.Unproject(feature.pixel);
      if (!direction) continue;
      const auto pixel = center.Project(*direction, &feature.pixel, 0);
      if (!pixel) continue;
      feature.pixel = *pixel;
      mapped.images.back().features.push_back(feature);
    }
  }
  return mapped;
}

namespace {

// Transfers the terms of one range to a grid: polynomials interpolate the
// model's directions at as many values as there are terms, with the other
// parameter at mid-range.
void TransferTermsToGrid(const OperatingPointModel& stack, size_t range,
                         const Eigen::Matrix3d& turn,
                         const std::vector<Eigen::Vector2d>& pixels,
                         OperatingPointModel* moved) {
  const OperatingPointModel along = stack.SliceAlong(range);
  const OperatingRange& over = along.ranges()[0];
  const int count = along.orders()[0] + 1;
  std::vector<CentralGeneric> cameras;
  Eigen::MatrixXd powers(count, count);
  for (int i = 0; i < count; ++i) {
    const double value = over.low + (over.high - over.low) * (i + 0.5) / count;
    cameras.push_back(along.At({value}));
    const std::vector<double> row = along.EvaluateBasis({value});
    powers.row(i) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), count);
  }
  const Eigen::MatrixXd terms_from_powers = powers.inverse();
  std::vector<std::vector<SurfaceSample>> samples(count);
  for (const Eigen::Vector2d& pixel : pixels) {
    Eigen::MatrixXd charts(count, 2);
    for (int i = 0; i < count; ++i)
      charts.row(i) = ToChart(turn * *cameras[i].Unproject(pixel)).transpose();
    const Eigen::MatrixXd terms = terms_from_powers * charts;
    for (int j = 1; j < count; ++j)
      samples[j].push_back({pixel, terms.row(j).transpose()});
  }
  const BSplineSurface& surface = moved->terms().front();
  for (int j = 1; j < count; ++j)
    moved->terms()[moved->FirstTerm(range) + j - 1] = FitSurface(
        surface.area(), surface.columns(), surface.rows(), samples[j]);
}

}  // namespace

OperatingPointModel TransferTermsBetweenGrids(const OperatingPointModel& stack,
                                              const CentralGeneric& camera) {
  constexpr int kPerCell = 3;
  OperatingPointModel moved(stack.ranges(), stack.orders(), camera);
  const std::vector<Eigen::Vector2d> pixels =
      camera.surface().SamplePixels(kPerCell);
  const Eigen::Matrix3d turn =
      ComputeNearestRotation(camera, stack.At(stack.Center()), camera.area())
          .toRotationMatrix();
  for (size_t r = 0; r < stack.ranges().size(); ++r)
    TransferTermsToGrid(stack, r, turn, pixels, &moved);
  return moved;
}

}  // namespace raygrid
