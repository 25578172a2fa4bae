#ifndef RAYGRID_PACKING_REGULAR_REGION_H
#define RAYGRID_PACKING_REGULAR_REGION_H

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "camera/camera_wrapper.h"

namespace raygrid {

/// The part of a central camera's area in which its model is regular. A pixel
/// is regular if
///   - it has a ray, whose projection is the pixel again,
///   - the Jacobian of the projection has a positive determinant there, and is
///     not nearly singular: the distortion does not fold,
///   - the ray is within 151 degrees of the z axis, the range of the blob's
///     chart,
///   - it is connected by regular pixels, without a jump of the rays, to the
///     pixel on the z axis, or otherwise to the centre of the area.
/// For grids, only the last two are required: where a grid folds, projection
/// already fails.
/// The region is computed on a lattice of up to 400 pixels per side; in cells
/// with only some regular corners, each pixel is evaluated. Deterministic for
/// any number of threads.
class RegularRegion {
 public:
  /// A regular pixel's ray, and the Jacobian of its projection.
  struct Node {
    Eigen::Vector3d ray = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, 2, 3> J_ray = Eigen::Matrix<double, 2, 3>::Zero();
    bool is_regular = false;
  };

  RegularRegion(const CameraModel& camera, int num_threads);

  /// Nodes of the lattice, row by row, from corner to corner of the area.
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  const std::vector<Node>& nodes() const { return nodes_; }
  Eigen::Vector2d GetPixel(int node) const;

  /// IsWhole() returns whether the entire area is regular, Part() the fraction
  /// that is.
  bool IsWhole() const { return regular_fraction_ == 1; }
  double Part() const { return regular_fraction_; }
  /// Returns the bounding rectangle of the region, at the resolution of the
  /// lattice.
  const Area& area() const { return area_; }
  bool IsEmpty() const { return regular_fraction_ == 0; }
  /// Contains() returns whether all corners of the pixel's cell are regular,
  /// Touches() whether at least one is.
  bool Contains(const Eigen::Vector2d& pixel) const;
  bool Touches(const Eigen::Vector2d& pixel) const;
  /// Whether the ray of a pixel in a touched cell is regular; camera: the
  /// camera of the region.
  bool IsRegularRay(const CameraModel& camera, const Eigen::Vector2d& pixel,
                    const Eigen::Vector3d& ray) const;
  /// Like Contains(), but additionally requires is_good at all corners.
  bool ContainsAmong(const std::vector<bool>& is_good,
                     const Eigen::Vector2d& pixel) const;

  /// Calls visit(area) for each cell of the lattice with a corner that is not
  /// regular or not good.
  template <typename Visit>
  void ForEachIrregularCell(const std::vector<bool>& is_good,
                            const Visit& visit) const {
    for (int j = 0; j + 1 < rows_; ++j)
      for (int i = 0; i + 1 < columns_; ++i)
        if (!IsRegularCell(i, j) || !HoldsAt(is_good, i, j))
          visit(CellArea(i, j));
  }

 private:
  bool HoldsAt(const std::vector<bool>& is_good, int i, int j) const {
    const int k = j * columns_ + i;
    return is_good[k] && is_good[k + 1] && is_good[k + columns_] &&
           is_good[k + columns_ + 1];
  }
  // Returns the index of a pixel's cell, which is the index of its upper left
  // node.
  int CellIndex(const Eigen::Vector2d& pixel) const;
  bool IsRegularCell(int i, int j) const {
    const int k = j * columns_ + i;
    return nodes_[k].is_regular && nodes_[k + 1].is_regular &&
           nodes_[k + columns_].is_regular &&
           nodes_[k + columns_ + 1].is_regular;
  }
  bool IsTouchedCell(int i, int j) const {
    const int k = j * columns_ + i;
    return nodes_[k].is_regular || nodes_[k + 1].is_regular ||
           nodes_[k + columns_].is_regular ||
           nodes_[k + columns_ + 1].is_regular;
  }
  Area CellArea(int i, int j) const;
  void ComputeNodes(const CameraModel& camera, int num_threads);
  void ExcludeSingularNodes();
  int FirstNode(const CameraModel& camera) const;
  bool IsDiscontinuous(int from, int to) const;
  void KeepConnectedNodes(int first);
  void Measure();

  Area camera_area_, area_;
  int columns_ = 0, rows_ = 0;
  double regular_fraction_ = 0;
  double min_scale_ = 0;  // minimum Jacobian scale, pixels per radian
  std::vector<Node> nodes_;
};

/// A camera restricted to its regular region: undefined elsewhere.
class RegularCamera : public CameraWrapper {
 public:
  RegularCamera(const CameraModel& camera,
                std::shared_ptr<const RegularRegion> region)
      : CameraWrapper(camera, camera.image_size(), region->area()),
        region_(std::move(region)) {}

  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<RegularCamera>(camera(), region_);
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override;

 private:
  // Whether a pixel, or the nearest one in the area, is regular and observes
  // the point.
  bool IsVisible(const Eigen::Vector2d& pixel,
                 const Eigen::Vector3d& point) const;

  std::shared_ptr<const RegularRegion> region_;
};

/// Restricts a camera to its regular region; a copy if it is regular
/// everywhere, a grid within the chart's range, or not central.
std::unique_ptr<CameraModel> ExtractRegularRegion(const CameraModel& camera,
                                                  int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PACKING_REGULAR_REGION_H
