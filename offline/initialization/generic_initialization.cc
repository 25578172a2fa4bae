#include "initialization/generic_initialization.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "camera/stereographic.h"
#include "initialization/chart_adjustment.h"
#include "initialization/dense_matches.h"
#include "initialization/pixelwise_model.h"
#include "initialization/triplet_selection.h"

namespace raygrid {
namespace {

// Number of triplets from which models are extended; the best model is used.
constexpr int kNumRefinedTriplets = 3;
constexpr size_t kMaxAdjustedFeatures = 60;  // per view

Area GetFeatureArea(const Dataset& dataset) {
  Area area = {INFINITY, INFINITY, -INFINITY, -INFINITY};
  for (const ImageFeatures& image : dataset.images) {
    for (const Feature& feature : image.features) {
      area.x0 = std::min(area.x0, feature.pixel.x());
      area.y0 = std::min(area.y0, feature.pixel.y());
      area.x1 = std::max(area.x1, feature.pixel.x());
      area.y1 = std::max(area.y1, feature.pixel.y());
    }
  }
  return area;
}

// Extends models from the best triplets, and returns the one that covers most
// pixels in most views.
std::optional<PixelwiseModel> GrowBestModel(
    const std::vector<DenseView>& views, const PixelLattice& lattice,
    const GenericInitializationOptions& options) {
  const TripletOptions triplet_options = {options.max_triplets, options.seed,
                                          options.num_threads};
  std::optional<PixelwiseModel> best;
  for (const SolvedTriplet& triplet :
       SelectTriplets(views, lattice, kNumRefinedTriplets, triplet_options)) {
    PixelwiseModel model =
        GrowPixelwiseModel(views, lattice, triplet, options.num_threads);
    if (model.num_localized() < 3) continue;
    if (!best || model.num_localized() > best->num_localized() ||
        (model.num_localized() == best->num_localized() &&
         model.median_error_px < best->median_error_px))
      best = std::move(model);
  }
  return best;
}

// Chart coordinates at the pixels of a lattice; nullopt if unobserved.
using ChartValues = std::vector<std::optional<Eigen::Vector2d>>;

ChartValues ComputeChart(const PixelwiseModel& model) {
  ChartValues chart;
  for (const auto& direction : model.directions) {
    chart.emplace_back();
    if (direction) chart.back() = ToChart(*direction);
  }
  return chart;
}

// Fits a linear combination of functions of the pixel.
template <int N, typename Functions>
Eigen::Matrix<double, N, 2> FitFunctions(const PixelLattice& lattice,
                                         const ChartValues& chart,
                                         const Functions& functions) {
  Eigen::Matrix<double, N, N> normal = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 2> right = Eigen::Matrix<double, N, 2>::Zero();
  for (int i = 0; i < lattice.size(); ++i) {
    if (!chart[i]) continue;
    const Eigen::Matrix<double, N, 1> values = functions(lattice.Pixel(i));
    normal += values * values.transpose();
    right += values * chart[i]->transpose();
  }
  return normal.ldlt().solve(right);
}

// Rotates the axes of the camera frame.
void RotateModel(const Eigen::Quaterniond& rotation, PixelwiseModel* model) {
  for (auto& direction : model->directions)
    if (direction) direction = rotation * *direction;
  for (auto& pose : model->camera_from_board)
    if (pose) pose = Pose{rotation, Eigen::Vector3d::Zero()} * *pose;
}

void RotateMeanToZ(PixelwiseModel* model) {
  Eigen::Vector3d mean(0, 0, 0);
  for (const auto& direction : model->directions)
    if (direction) mean += *direction;
  RotateModel(
      Eigen::Quaterniond::FromTwoVectors(mean, Eigen::Vector3d::UnitZ()),
      model);
}

// Rotates about z until the linear part of the chart's Jacobian contains no
// rotation, so that x points right and y down. Returns false if the image is
// mirrored.
bool AlignAxesWithImage(const PixelLattice& lattice, PixelwiseModel* model) {
  const Eigen::Matrix2d linear =
      FitFunctions<3>(lattice, ComputeChart(*model),
                      [](const Eigen::Vector2d& pixel) -> Eigen::Vector3d {
                        return pixel.homogeneous();
                      })
          .topRows<2>()
          .transpose();
  if (!(linear.determinant() > 0)) return false;
  const double angle =
      std::atan2(linear(1, 0) - linear(0, 1), linear(0, 0) + linear(1, 1));
  RotateModel(RotationFromVector({0, 0, -angle}), model);
  return true;
}

// Monomials up to third degree in pixel coordinates that are normalized to [-1,
// 1]^2.
using Cubic = Eigen::Matrix<double, 10, 1>;
Cubic CubicMonomials(const Eigen::Vector2d& pixel, const Area& area) {
  const double x = (pixel.x() - area.center().x()) / (area.width() / 2);
  const double y = (pixel.y() - area.center().y()) / (area.height() / 2);
  Cubic monomials;
  monomials << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y,
      y * y * y;
  return monomials;
}

// Returns the mean of the neighbouring values; nullopt if there are none.
std::optional<Eigen::Vector2d> ComputeNeighborMean(const ChartValues& values,
                                                   const PixelLattice& lattice,
                                                   int index) {
  const int x = index % lattice.columns, y = index / lattice.columns;
  Eigen::Vector2d sum(0, 0);
  int count = 0;
  for (int j = std::max(0, y - 1); j <= std::min(lattice.rows - 1, y + 1);
       ++j) {
    for (int i = std::max(0, x - 1); i <= std::min(lattice.columns - 1, x + 1);
         ++i) {
      const auto& value = values[j * lattice.columns + i];
      if (!value) continue;
      sum += *value;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

// Extrapolates values ring by ring; requires at least one value.
void FillFromNeighbours(const PixelLattice& lattice, ChartValues* values) {
  for (bool complete = false; !complete;) {
    complete = true;
    const ChartValues before = *values;
    for (int i = 0; i < lattice.size(); ++i) {
      if (before[i]) continue;
      (*values)[i] = ComputeNeighborMean(before, lattice, i);
      complete = false;
    }
  }
}

// Returns the chart values at all pixels of an area. Unobserved pixels are
// extrapolated by a cubic polynomial that is fitted to the observed pixels,
// plus the deviations of neighbours from it.
std::vector<SurfaceSample> CompleteSamples(const ChartValues& seen,
                                           const PixelLattice& lattice,
                                           const Area& area) {
  const auto monomials = [&area](const Eigen::Vector2d& pixel) {
    return CubicMonomials(pixel, area);
  };
  const Eigen::Matrix<double, 10, 2> coefficients =
      FitFunctions<10>(lattice, seen, monomials);
  ChartValues difference = seen;
  for (int i = 0; i < lattice.size(); ++i)
    if (difference[i])
      *difference[i] -= coefficients.transpose() * monomials(lattice.Pixel(i));
  FillFromNeighbours(lattice, &difference);
  std::vector<SurfaceSample> samples;
  for (int i = 0; i < lattice.size(); ++i) {
    const Eigen::Vector2d pixel = lattice.Pixel(i);
    if (area.Contains(pixel, lattice.step_px))
      samples.push_back({pixel, coefficients.transpose() * monomials(pixel) +
                                    *difference[i]});
  }
  return samples;
}

// Returns the features of the views with poses, at most max_count per view; one
// pose per view.
std::vector<ChartObservation> MakeObservations(
    const std::vector<InitialView>& views, const Dataset& dataset,
    const Pattern& pattern, size_t max_count) {
  std::vector<ChartObservation> observations;
  for (size_t v = 0; v < views.size(); ++v) {
    const Board& board = pattern.boards[views[v].board];
    const std::vector<Eigen::Vector3d> nominal = board.NominalPoints();
    std::vector<ChartObservation> all;
    for (const Feature& feature : dataset.images[views[v].image].features)
      if (feature.board == board.id)
        all.push_back({static_cast<int>(v),
                       nominal[board.PointIndex(feature.column, feature.row)],
                       feature.pixel});
    const size_t count = std::min(max_count, all.size());
    for (size_t i = 0; i < count; ++i)
      observations.push_back(all[i * all.size() / count]);
  }
  return observations;
}

BSplineSurface FitGrid(const PixelwiseModel& model, const PixelLattice& lattice,
                       const Area& area, int cells_along) {
  const double knot_spacing_px =
      std::max(area.width(), area.height()) / cells_along;
  return FitSurface(area, NumControlPoints(area.width(), knot_spacing_px),
                    NumControlPoints(area.height(), knot_spacing_px),
                    CompleteSamples(ComputeChart(model), lattice, area));
}

// Fits a grid to a pixelwise model, and optimizes the grid and the poses.
GenericInitialization OptimizeFromPixelwiseModel(
    const PixelwiseModel& model, const std::vector<DenseView>& dense,
    const PixelLattice& lattice, const Dataset& dataset, const Pattern& pattern,
    const GenericInitializationOptions& options) {
  std::vector<InitialView> views;
  std::vector<Pose> poses;
  for (size_t v = 0; v < dense.size(); ++v) {
    if (!model.camera_from_board[v]) continue;
    poses.push_back(*model.camera_from_board[v]);
    views.push_back({dense[v].image, dense[v].board, poses.back()});
  }
  const Area area = options.area ? *options.area : GetFeatureArea(dataset);
  BSplineSurface surface = FitGrid(model, lattice, area, options.cells_along);
  OptimizeInChart(
      MakeObservations(views, dataset, pattern, kMaxAdjustedFeatures), &surface,
      &poses);
  for (size_t v = 0; v < views.size(); ++v)
    views[v].camera_from_board = poses[v];
  return {CentralGeneric(dataset.image_size, surface), views, 0};
}

double MedianReprojectionError(const GenericInitialization& start,
                               const std::vector<ChartObservation>& features) {
  std::vector<double> errors;
  for (const ChartObservation& feature : features) {
    const Pose& pose = start.views[feature.pose].camera_from_board;
    const auto pixel =
        start.camera.Project(pose * feature.point, &feature.pixel, 10);
    errors.push_back(pixel ? (*pixel - feature.pixel).norm() : INFINITY);
  }
  if (errors.empty()) return INFINITY;
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2,
                   errors.end());
  return errors[errors.size() / 2];
}

}  // namespace

std::optional<GenericInitialization> InitializeFromThreeViews(
    const Dataset& dataset, const Pattern& pattern,
    const GenericInitializationOptions& options) {
  const PixelLattice lattice = MakePixelLattice(dataset.image_size);
  const std::vector<DenseView> dense =
      MakeDenseViews(dataset, pattern, lattice);
  std::optional<PixelwiseModel> model = GrowBestModel(dense, lattice, options);
  if (!model) return std::nullopt;
  RotateMeanToZ(&*model);
  if (!AlignAxesWithImage(lattice, &*model)) return std::nullopt;
  GenericInitialization start = OptimizeFromPixelwiseModel(
      *model, dense, lattice, dataset, pattern, options);
  start.median_error_px = MedianReprojectionError(
      start, MakeObservations(start.views, dataset, pattern, SIZE_MAX));
  return start;
}

}  // namespace raygrid
