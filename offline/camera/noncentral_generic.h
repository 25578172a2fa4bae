#ifndef RAYGRID_CAMERA_NONCENTRAL_GENERIC_H
#define RAYGRID_CAMERA_NONCENTRAL_GENERIC_H

#include <vector>

#include "camera/central_generic.h"
#include "camera/pixel_search.h"

namespace raygrid {

/// The paper's non-central generic model: each control point has a direction,
/// in stereographic coordinates, and a point of the line; both are interpolated
/// by the same cubic B-spline (section "Camera Model").
class NonCentralGeneric : public CameraModel {
 public:
  static constexpr int kPerNode = 5;
  static constexpr int kFirstOfPoint = 2;  ///< index of the point's x

  /// points: one per control point of the directions, in metres.
  NonCentralGeneric(const ImageSize& image_size, BSplineSurface directions,
                    std::vector<Eigen::Vector3d> points);
  /// Creates a camera with all lines through the origin.
  explicit NonCentralGeneric(const CentralGeneric& central);

  std::string Name() const override { return models::kNonCentralGeneric; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<NonCentralGeneric>(*this);
  }
  bool IsCentral() const override { return false; }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const override;
  /// Never returns a pixel in a fold (see CentralGeneric).
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;

  /// Linearizes by implicit differentiation: the projection x of a point p
  /// solves chart(p - o(x)) = s(x). With C the chart's derivative at p - o and
  /// D = ds/dx + C do/dx,
  ///   dx/dp = D^-1 C,  dx/do_k = -w_k D^-1 C,  dx/ds_k = -w_k D^-1.
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override;

  /// Returns the parameters of each control point, row by row: a, b, and the
  /// point.
  Eigen::VectorXd Parameters() const override;
  void SetParameters(const Eigen::VectorXd& parameters) override;

  const BSplineSurface& directions() const { return directions_; }
  const BSplineSurface* DirectionGrid() const override { return &directions_; }
  std::unique_ptr<CameraModel> FittedTo(
      const CameraModel& other) const override;
  const std::vector<Eigen::Vector3d>& points() const { return points_; }

  /// Returns the camera in a frame with its origin at a point of this one's.
  NonCentralGeneric WithOrigin(const Eigen::Vector3d& origin) const;

 private:
  struct LineDerivatives;
  LineDerivatives Evaluate(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d NearestControlPoint(const Eigen::Vector3d& point) const;
  std::optional<PixelSolution> Solve(const Eigen::Vector3d& point,
                                     const Eigen::Vector2d* start,
                                     double margin_px) const;

  BSplineSurface directions_;
  std::vector<Eigen::Vector3d> points_;
  UnfoldedSide side_;
};

/// Fits a grid to another model's lines at samples_per_cell^2 pixels per cell
/// by least squares (see FitCentralGeneric()).
NonCentralGeneric FitNonCentralGeneric(const CameraModel& model,
                                       const Area& area, int columns, int rows,
                                       int samples_per_cell = 4);

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_NONCENTRAL_GENERIC_H
