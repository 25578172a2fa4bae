#include "packing/regular_region.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "camera/central_generic.h"
#include "camera/pixel_search.h"
#include "camera/stereographic.h"
#include "dataset/parallel_for.h"
#include "packing/blob_limits.h"
#include "packing/projection_error.h"

namespace raygrid {
namespace {

// The maximum number of cells along the longer side; cells have at least one
// pixel.
constexpr int kMaxCells = 400;
// The tolerance for the projection of a pixel's ray.
constexpr double kReprojectionTolerancePx = 1e-5;
// The minimum singular value of a Jacobian relative to a typical one; below it,
// the distortion is about to fold.
constexpr double kMinScaleRatio = 0.02;
// The tolerance between a pixel's rays to count as the same ray.
constexpr double kSameRayRad = 1e-6;

using RayJacobian = Eigen::Matrix<double, 2, 3>;

// Returns the determinant of a projection's Jacobian in the plane orthogonal to
// the ray: positive if the image is not mirrored.
double Determinant(const RayJacobian& J_ray, const Eigen::Vector3d& ray) {
  return J_ray.row(0).cross(J_ray.row(1)).dot(ray);
}

// Returns the smaller singular value of the Jacobian.
double ComputeMinScale(const RayJacobian& J_ray) {
  const Eigen::Matrix2d product = J_ray * J_ray.transpose();
  const double half = product.trace() / 2;
  const double root =
      std::sqrt(std::max(0.0, half * half - product.determinant()));
  return std::sqrt(std::max(0.0, half - root));
}

RegularRegion::Node MakeNode(const CameraModel& camera, bool is_grid,
                             const Eigen::Vector2d& pixel) {
  RegularRegion::Node node;
  const auto ray = camera.Unproject(pixel);
  if (!ray || !ray->allFinite()) return node;
  const Eigen::Vector2d chart = ToChart(*ray);
  LinearizedProjection projection;
  if (!(chart.norm() <= kMaxChartRadius) ||
      !camera.Linearize(*ray, &pixel, 1, &projection) ||
      !projection.J_point.allFinite()) {
    // At a grid's fold, rays exist, but cannot be projected.
    node.is_regular = is_grid && chart.norm() <= kMaxChartRadius;
    node.ray = *ray;
    return node;
  }
  node.ray = *ray;
  node.J_ray = projection.J_point;
  node.is_regular = is_grid || ((projection.pixel - pixel).norm() <=
                                    kReprojectionTolerancePx &&
                                Determinant(node.J_ray, *ray) > 0);
  return node;
}

}  // namespace

RegularRegion::RegularRegion(const CameraModel& camera, int num_threads)
    : camera_area_(camera.area()), area_(camera.area()) {
  const double step_px = std::max(
      1.0, std::max(camera_area_.width(), camera_area_.height()) / kMaxCells);
  columns_ =
      1 +
      std::max(1, static_cast<int>(std::ceil(camera_area_.width() / step_px)));
  rows_ =
      1 +
      std::max(1, static_cast<int>(std::ceil(camera_area_.height() / step_px)));
  ComputeNodes(camera, num_threads);
  if (!camera.DirectionGrid()) ExcludeSingularNodes();
  KeepConnectedNodes(FirstNode(camera));
  Measure();
}

Eigen::Vector2d RegularRegion::GetPixel(int node) const {
  const int i = node % columns_, j = node / columns_;
  return {i + 1 == columns_
              ? camera_area_.x1
              : camera_area_.x0 + camera_area_.width() * i / (columns_ - 1),
          j + 1 == rows_
              ? camera_area_.y1
              : camera_area_.y0 + camera_area_.height() * j / (rows_ - 1)};
}

Area RegularRegion::CellArea(int i, int j) const {
  const Eigen::Vector2d a = GetPixel(j * columns_ + i),
                        b = GetPixel((j + 1) * columns_ + i + 1);
  return {a.x(), a.y(), b.x(), b.y()};
}

void RegularRegion::ComputeNodes(const CameraModel& camera, int num_threads) {
  nodes_.resize(static_cast<size_t>(columns_) * rows_);
  const bool is_grid = camera.DirectionGrid();
  ParallelFor(rows_, NumThreads(num_threads), [&](int j) {
    for (int k = j * columns_; k < (j + 1) * columns_; ++k)
      nodes_[k] = MakeNode(camera, is_grid, GetPixel(k));
  });
}

void RegularRegion::ExcludeSingularNodes() {
  std::vector<double> scales;
  for (const Node& node : nodes_)
    if (node.is_regular)
      scales.push_back(std::sqrt(Determinant(node.J_ray, node.ray)));
  if (scales.empty()) return;
  const auto median =
      scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2);
  std::nth_element(scales.begin(), median, scales.end());
  min_scale_ = kMinScaleRatio * *median;
  for (Node& node : nodes_)
    if (!(ComputeMinScale(node.J_ray) >= min_scale_)) node.is_regular = false;
}

// Returns the regular node nearest to the pixel on the optical axis, otherwise
// to the centre.
int RegularRegion::FirstNode(const CameraModel& camera) const {
  const Eigen::Vector2d place =
      camera.Project(Eigen::Vector3d(0, 0, 1)).value_or(camera_area_.center());
  int nearest = -1;
  for (int k = 0; k < static_cast<int>(nodes_.size()); ++k)
    if (nodes_[k].is_regular &&
        (nearest < 0 || (GetPixel(k) - place).squaredNorm() <
                            (GetPixel(nearest) - place).squaredNorm()))
      nearest = k;
  return nearest;
}

// Whether the rays of two nodes differ by far more than the Jacobians predict.
bool RegularRegion::IsDiscontinuous(int from, int to) const {
  constexpr double kFar = 4;
  const double least = std::min(ComputeMinScale(nodes_[from].J_ray),
                                ComputeMinScale(nodes_[to].J_ray));
  const double angle_between_rad =
      std::atan2(nodes_[from].ray.cross(nodes_[to].ray).norm(),
                 nodes_[from].ray.dot(nodes_[to].ray));
  return angle_between_rad * least >
         kFar * (GetPixel(from) - GetPixel(to)).norm();
}

void RegularRegion::KeepConnectedNodes(int first) {
  std::vector<bool> is_connected(nodes_.size(), false);
  std::vector<int> next;
  const auto add = [&](int node) {
    if (is_connected[node] || !nodes_[node].is_regular) return;
    is_connected[node] = true;
    next.push_back(node);
  };
  if (first >= 0) add(first);
  while (!next.empty()) {
    const int node = next.back();
    next.pop_back();
    const int i = node % columns_, j = node / columns_;
    const auto step = [&](bool is_inside, int beside) {
      if (is_inside && !IsDiscontinuous(node, beside)) add(beside);
    };
    step(i > 0, node - 1);
    step(i + 1 < columns_, node + 1);
    step(j > 0, node - columns_);
    step(j + 1 < rows_, node + columns_);
  }
  for (size_t k = 0; k < nodes_.size(); ++k)
    nodes_[k].is_regular = is_connected[k];
}

void RegularRegion::Measure() {
  int first_i = columns_, last_i = 0, first_j = rows_, last_j = 0;
  int64_t num_regular = 0;
  for (int j = 0; j + 1 < rows_; ++j)
    for (int i = 0; i + 1 < columns_; ++i) {
      num_regular += IsRegularCell(i, j);
      if (!IsTouchedCell(i, j)) continue;
      first_i = std::min(first_i, i);
      last_i = std::max(last_i, i + 1);
      first_j = std::min(first_j, j);
      last_j = std::max(last_j, j + 1);
    }
  const int64_t num_cells = static_cast<int64_t>(columns_ - 1) * (rows_ - 1);
  regular_fraction_ =
      num_regular == num_cells
          ? 1
          : static_cast<double>(num_regular) / static_cast<double>(num_cells);
  if (num_regular == 0) return;
  const Eigen::Vector2d a = GetPixel(first_j * columns_ + first_i),
                        b = GetPixel(last_j * columns_ + last_i);
  area_ = {a.x(), a.y(), b.x(), b.y()};
}

int RegularRegion::CellIndex(const Eigen::Vector2d& pixel) const {
  const auto cell = [](double part, int num_nodes) {
    return std::clamp(static_cast<int>(part * (num_nodes - 1)), 0,
                      num_nodes - 2);
  };
  return cell((pixel.y() - camera_area_.y0) / camera_area_.height(), rows_) *
             columns_ +
         cell((pixel.x() - camera_area_.x0) / camera_area_.width(), columns_);
}

bool RegularRegion::Contains(const Eigen::Vector2d& pixel) const {
  if (!camera_area_.Contains(pixel)) return false;
  const int cell = CellIndex(pixel);
  return IsRegularCell(cell % columns_, cell / columns_);
}

bool RegularRegion::Touches(const Eigen::Vector2d& pixel) const {
  if (!camera_area_.Contains(pixel)) return false;
  const int cell = CellIndex(pixel);
  return IsTouchedCell(cell % columns_, cell / columns_);
}

bool RegularRegion::IsRegularRay(const CameraModel& camera,
                                 const Eigen::Vector2d& pixel,
                                 const Eigen::Vector3d& ray) const {
  if (Contains(pixel)) return true;
  const Node node = MakeNode(camera, camera.DirectionGrid(), pixel);
  return node.is_regular && (node.ray - ray).norm() <= kSameRayRad &&
         (min_scale_ == 0 || ComputeMinScale(node.J_ray) >= min_scale_);
}

bool RegularRegion::ContainsAmong(const std::vector<bool>& is_good,
                                  const Eigen::Vector2d& pixel) const {
  if (!Contains(pixel)) return false;
  const int cell = CellIndex(pixel);
  return HoldsAt(is_good, cell % columns_, cell / columns_);
}

std::optional<Eigen::Vector3d> RegularCamera::Unproject(
    const Eigen::Vector2d& pixel) const {
  if (!area().Contains(pixel) || !region_->Touches(pixel)) return std::nullopt;
  const auto ray = camera().Unproject(pixel);
  return ray && region_->IsRegularRay(camera(), pixel, *ray) ? ray
                                                             : std::nullopt;
}

bool RegularCamera::IsVisible(const Eigen::Vector2d& pixel,
                              const Eigen::Vector3d& point) const {
  if (!region_->Touches(ClampToArea(pixel, area(), 0))) return false;
  if (const auto ray = camera().Unproject(pixel))
    return (*ray - point.normalized()).norm() <= kSameRayRad &&
           region_->IsRegularRay(camera(), pixel, *ray);
  // Positions in the margin around the camera's area are accepted.
  LinearizedProjection projection;
  constexpr double kUnlimitedMarginPx = 1e9;
  return !camera().area().Contains(pixel) &&
         camera().Linearize(point, &pixel, kUnlimitedMarginPx, &projection) &&
         Determinant(projection.J_point, point) > 0;
}

std::optional<Eigen::Vector2d> RegularCamera::Project(
    const Eigen::Vector3d& point, const Eigen::Vector2d* start,
    double margin_px) const {
  const auto pixel = camera().Project(point, start, margin_px);
  if (!pixel || !area().Contains(*pixel, margin_px) ||
      !IsVisible(*pixel, point))
    return std::nullopt;
  return pixel;
}

bool RegularCamera::Linearize(const Eigen::Vector3d& point,
                              const Eigen::Vector2d* start, double margin_px,
                              LinearizedProjection* projection) const {
  if (!Project(point, start, margin_px) ||
      !camera().Linearize(point, start, margin_px, projection))
    return false;
  ForgetParameters(projection);
  return true;
}

std::unique_ptr<CameraModel> ExtractRegularRegion(const CameraModel& camera,
                                                  int num_threads) {
  if (!camera.IsCentral() || camera.DirectionGrid()) return camera.Clone();
  const auto region = std::make_shared<RegularRegion>(camera, num_threads);
  if (region->IsWhole() || region->IsEmpty()) return camera.Clone();
  return std::make_unique<RegularCamera>(camera, region);
}

}  // namespace raygrid
