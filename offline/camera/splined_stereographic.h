#ifndef RAYGRID_CAMERA_SPLINED_STEREOGRAPHIC_H
#define RAYGRID_CAMERA_SPLINED_STEREOGRAPHIC_H

#include <memory>
#include <optional>

#include "camera/bspline_surface.h"
#include "camera/camera_uncertainty.h"
#include "camera/parametric_model.h"

namespace raygrid {

/// mrcal's LENSMODEL_SPLINED_STEREOGRAPHIC of order 3: a stereographic
/// projection corrected by a spline over directions.
///   u = 2 tan(theta / 2) point.xy / |point.xy|,  theta from the z axis
///   pixel = (fx, fy) * (u + d(u)) + (cx, cy)
/// where d is a uniform cubic B-spline surface of columns x rows control
/// points. Its cells are squares in u, centred on the axis; without those at
/// the border they span fov_x_deg horizontally.
///
/// Valid where d has cells on all sides and u + d(u) does not fold.
class SplinedStereographic : public ParametricModel {
 public:
  /// Number of control points, at least 4, and the horizontal angle spanned by
  /// the cells inside the border, 1 to 359 degrees.
  struct Grid {
    int columns = 4, rows = 4, fov_x_deg = 90;
  };

  /// parameters: d's control points, x and y of each, row by row, from the
  /// smallest u; then fx, fy, cx, cy.
  SplinedStereographic(const ImageSize& image_size, const Area& area,
                       const Grid& grid, const Eigen::VectorXd& parameters);

  std::string Name() const override { return models::kSplinedStereographic; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<SplinedStereographic>(*this);
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

  Eigen::VectorXd Parameters() const override;
  void SetParameters(const Eigen::VectorXd& parameters) override;
  /// Names of the parameters after the control points.
  const std::vector<std::string>& ParameterNames() const override;
  std::unique_ptr<ParametricModel> CloneWithArea(
      const Area& area) const override {
    return std::make_unique<SplinedStereographic>(image_size(), area, grid_,
                                                  Parameters());
  }

  const Grid& grid() const { return grid_; }
  const BSplineSurface& surface() const { return surface_; }

 private:
  Grid grid_;
  BSplineSurface surface_;  ///< d, over u
  Eigen::Array2d focal_px_, center_px_;
};

/// Returns the u at which d has cells on all sides.
Area ComputeDomain(const SplinedStereographic::Grid& grid);

/// Fits the model to a central camera, in its frame: least squares on the
/// pixels of its directions. Of the grids that cover all directions, uses the
/// smallest one with an error of at most 0.005 px, otherwise the one with the
/// least error. Invalid pixels have a weight of 1/1000; without a mask, all
/// pixels are valid. A grid may be prescribed; fov_x_deg = 0: covers all
/// directions. Returns null if the camera has no directions, only one
/// direction, or is mirrored.
std::unique_ptr<SplinedStereographic> FitSplinedStereographic(
    const CameraModel& camera, const ValidityMask* valid_region,
    const std::optional<SplinedStereographic::Grid>& given_grid = std::nullopt);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_SPLINED_STEREOGRAPHIC_H
