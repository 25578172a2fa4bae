#ifndef RAYGRID_CAMERA_CENTRAL_GENERIC_H
#define RAYGRID_CAMERA_CENTRAL_GENERIC_H

#include "camera/bspline_surface.h"
#include "camera/camera_model.h"

namespace raygrid {

/// The paper's central generic model: a grid of control points over the
/// calibrated area, interpolated by a cubic B-spline surface (section "Camera
/// Model"). The control points are stereographic coordinates of directions
/// instead of unit vectors (reasons: offline/camera/DESIGN.md).
class CentralGeneric : public CameraModel {
 public:
  /// The surface's area is the calibrated area.
  CentralGeneric(const ImageSize& image_size, BSplineSurface surface);

  std::string Name() const override { return models::kCentralGeneric; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<CentralGeneric>(*this);
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  /// Never returns a pixel in a fold, where a grid has directions of other
  /// pixels again.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;

  /// Linearizes by implicit differentiation: the projection x of a point p
  /// solves s(x) = chart(p), with s = sum_k w_k(x) c_k the spline surface, so
  ///   dx/dp = (ds/dx)^-1 dchart/dp  and  dx/dc_k = -(ds/dx)^-1 w_k.
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override;

  /// Returns the coordinates (a, b) of each control point, row by row.
  Eigen::VectorXd Parameters() const override;
  void SetParameters(const Eigen::VectorXd& parameters) override;

  const BSplineSurface& surface() const { return surface_; }
  const BSplineSurface* DirectionGrid() const override { return &surface_; }
  std::unique_ptr<CameraModel> FittedTo(
      const CameraModel& other) const override;

 private:
  BSplineSurface surface_;
  UnfoldedSide side_;
};

/// Returns the central camera with a model's directions, valid for far scenes.
CentralGeneric MakeCentral(const CameraModel& generic);

/// Fits a grid to another model: least squares in the chart on the directions
/// of samples_per_cell^2 pixels per cell.
CentralGeneric FitCentralGeneric(const CameraModel& model, const Area& area,
                                 int columns, int rows,
                                 int samples_per_cell = 4);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CENTRAL_GENERIC_H
