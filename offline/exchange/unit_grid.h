#ifndef RAYGRID_EXCHANGE_UNIT_GRID_H
#define RAYGRID_EXCHANGE_UNIT_GRID_H

#include <vector>

#include "camera/bspline_surface.h"
#include "camera/camera_model.h"

namespace raygrid {

/// The generic models as implemented by the paper's authors: control points are
/// unit vectors, and interpolated vectors are normalized. Points of observation
/// lines, if any, are interpolated by the same spline.
class UnitGrid : public CameraModel {
 public:
  /// First and last calibrated pixel in x and y.
  struct Bounds {
    int min_x = 0, min_y = 0, max_x = 0, max_y = 0;
  };

  /// Row-major; without points, the camera is central.
  UnitGrid(const ImageSize& image_size, const Bounds& bounds, int columns,
           int rows, std::vector<Eigen::Vector3d> directions,
           std::vector<Eigen::Vector3d> points);

  std::string Name() const override { return "unit-grid"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<UnitGrid>(*this);
  }
  bool IsCentral() const override { return points_.empty(); }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const override;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;
  /// Returns false: the model is not optimized.
  bool Linearize(const Eigen::Vector3d&, const Eigen::Vector2d*, double,
                 LinearizedProjection*) const override {
    return false;
  }
  /// Returns the directions, followed by points; three numbers each.
  Eigen::VectorXd Parameters() const override;
  void SetParameters(const Eigen::VectorXd& parameters) override;

  const Bounds& bounds() const { return bounds_; }
  int columns() const { return lattice_.columns(); }
  int rows() const { return lattice_.rows(); }
  const std::vector<Eigen::Vector3d>& directions() const { return directions_; }
  const std::vector<Eigen::Vector3d>& points() const { return points_; }

 private:
  Bounds bounds_;
  BSplineSurface lattice_;  // positions of control points
  std::vector<Eigen::Vector3d> directions_, points_;
};

/// Fits the grid to a camera, with the same number of control points if it is a
/// grid.
UnitGrid FitUnitGrid(const CameraModel& camera, bool has_points);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_UNIT_GRID_H
