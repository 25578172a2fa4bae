#include "initialization/generic_start.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "camera/stereographic.h"
#include "initialization/dense_matches.h"
#include "initialization/pixelwise_model.h"
#include "initialization/triplet_selection.h"

namespace raygrid {
namespace {

// Triplets that a model is grown from; the best model is taken.
constexpr int kNumGrown = 3;

Area AreaOfFeatures(const Dataset& dataset) {
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

// The model that explains most pixels of most views.
std::optional<PixelwiseModel> GrowBestModel(
    const std::vector<DenseView>& views, const PixelLattice& lattice,
    const GenericStartOptions& options) {
  const TripletOptions triplet_options = {options.max_triplets, options.seed,
                                          options.num_threads};
  std::optional<PixelwiseModel> best;
  for (const SolvedTriplet& triplet :
       SelectTriplets(views, lattice, kNumGrown, triplet_options)) {
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

std::vector<SurfaceSample> ChartSamples(const PixelwiseModel& model,
                                        const PixelLattice& lattice) {
  std::vector<SurfaceSample> samples;
  for (int i = 0; i < lattice.size(); ++i)
    if (model.directions[i])
      samples.push_back({lattice.Pixel(i), ToChart(*model.directions[i])});
  return samples;
}

// Turns camera axes.
void Turn(const Eigen::Quaterniond& rotation, PixelwiseModel* model) {
  for (auto& direction : model->directions)
    if (direction) direction = rotation * *direction;
  for (auto& pose : model->camera_from_board)
    if (pose) pose = Pose{rotation, Eigen::Vector3d::Zero()} * *pose;
}

void TurnMeanForward(PixelwiseModel* model) {
  Eigen::Vector3d mean(0, 0, 0);
  for (const auto& direction : model->directions)
    if (direction) mean += *direction;
  Turn(Eigen::Quaterniond::FromTwoVectors(mean, Eigen::Vector3d::UnitZ()),
       model);
}

// x right and y down: about z, until the chart's linear part by the pixel has
// no rotation. False if the image is mirrored.
bool TurnUpright(const PixelLattice& lattice, PixelwiseModel* model) {
  const auto samples = ChartSamples(*model, lattice);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (const SurfaceSample& sample : samples) {
    const Eigen::Vector3d pixel = sample.pixel.homogeneous();
    normal += pixel * pixel.transpose();
    right += pixel * sample.value.transpose();
  }
  const Eigen::Matrix2d linear =
      normal.ldlt().solve(right).topRows<2>().transpose();
  if (!(linear.determinant() > 0)) return false;
  const double angle =
      std::atan2(linear(1, 0) - linear(0, 1), linear(0, 0) + linear(1, 1));
  Turn(RotationFromVector({0, 0, -angle}), model);
  return true;
}

// Monomials up to the third degree, of a pixel within [-1, 1]^2.
using Cubic = Eigen::Matrix<double, 10, 1>;
Cubic CubicMonomials(const Eigen::Vector2d& pixel, const Area& area) {
  const double x = (pixel.x() - area.center().x()) / (area.width() / 2);
  const double y = (pixel.y() - area.center().y()) / (area.height() / 2);
  Cubic monomials;
  monomials << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y,
      y * y * y;
  return monomials;
}

// Values where there are none: of the cubic polynomial through all others.
void AddUnseen(const PixelwiseModel& model, const PixelLattice& lattice,
               const Area& area, std::vector<SurfaceSample>* samples) {
  Eigen::Matrix<double, 10, 10> normal = Eigen::Matrix<double, 10, 10>::Zero();
  Eigen::Matrix<double, 10, 2> right = Eigen::Matrix<double, 10, 2>::Zero();
  for (const SurfaceSample& sample : *samples) {
    const Cubic monomials = CubicMonomials(sample.pixel, area);
    normal += monomials * monomials.transpose();
    right += monomials * sample.value.transpose();
  }
  const Eigen::Matrix<double, 10, 2> coefficients = normal.ldlt().solve(right);
  for (int i = 0; i < lattice.size(); ++i) {
    const Eigen::Vector2d pixel = lattice.Pixel(i);
    if (!model.directions[i] && area.Contains(pixel))
      samples->push_back(
          {pixel, coefficients.transpose() * CubicMonomials(pixel, area)});
  }
}

double MedianReprojectionError(const CentralGeneric& camera,
                               const std::vector<StartingView>& views,
                               const Dataset& dataset, const Pattern& pattern) {
  std::vector<double> errors;
  for (const StartingView& view : views) {
    const Board& board = pattern.boards[view.board];
    const std::vector<Eigen::Vector3d> nominal = board.NominalPoints();
    for (const Feature& feature : dataset.images[view.image].features) {
      if (feature.board != board.id) continue;
      const Eigen::Vector3d& point =
          nominal[board.PointIndex(feature.column, feature.row)];
      const auto pixel =
          camera.Project(view.camera_from_board * point, &feature.pixel, 10);
      errors.push_back(pixel ? (*pixel - feature.pixel).norm() : INFINITY);
    }
  }
  if (errors.empty()) return INFINITY;
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2,
                   errors.end());
  return errors[errors.size() / 2];
}

}  // namespace

std::optional<GenericStart> StartFromThreeViews(
    const Dataset& dataset, const Pattern& pattern,
    const GenericStartOptions& options) {
  const PixelLattice lattice = LatticeOf(dataset.image_size);
  const std::vector<DenseView> dense =
      FormDenseViews(dataset, pattern, lattice);
  std::optional<PixelwiseModel> model = GrowBestModel(dense, lattice, options);
  if (!model) return std::nullopt;
  TurnMeanForward(&*model);
  if (!TurnUpright(lattice, &*model)) return std::nullopt;

  const Area area = AreaOfFeatures(dataset);
  const double cell_px =
      std::max(area.width(), area.height()) / options.cells_along;
  std::vector<SurfaceSample> samples = ChartSamples(*model, lattice);
  AddUnseen(*model, lattice, area, &samples);
  GenericStart start = {
      CentralGeneric(
          dataset.image_size,
          FitSurface(area, NumControlPoints(area.width(), cell_px),
                     NumControlPoints(area.height(), cell_px), samples)),
      {},
      0};
  for (size_t v = 0; v < dense.size(); ++v)
    if (model->camera_from_board[v])
      start.views.push_back(
          {dense[v].image, dense[v].board, *model->camera_from_board[v]});
  start.median_error_px =
      MedianReprojectionError(start.camera, start.views, dataset, pattern);
  return start;
}

}  // namespace raygrid
