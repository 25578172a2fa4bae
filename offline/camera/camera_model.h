#ifndef RAYGRID_CAMERA_CAMERA_MODEL_H
#define RAYGRID_CAMERA_CAMERA_MODEL_H

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/image_circle.h"
#include "camera/model_names.h"
#include "camera/observation_line.h"

namespace raygrid {

class BSplineSurface;
class OperatingPointModel;
class ParametricModel;

/// A projection and its Jacobians. It depends on the nodes (control points) of
/// a spline around it, whose Jacobians differ only by their weights, and on
/// global parameters.
struct LinearizedProjection {
  static constexpr int kMaxNodes = 16, kMaxPerNode = 14, kMaxGlobal = 20;
  static constexpr int kMaxParameters = kMaxNodes * kMaxPerNode + kMaxGlobal;

  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> J_point;  ///< d pixel / d point

  /// Number of nodes and of parameters per node, constant for all projections
  /// of a camera: nodes may have zero weight.
  int num_nodes = 0, num_per_node = 0;
  std::array<int, kMaxNodes> node_parameter;  ///< first parameter of each node
  std::array<double, kMaxNodes> node_weight;
  /// d pixel / d parameters of a node, for a node of weight 1.
  Eigen::Matrix<double, 2, kMaxPerNode> J_node;

  int num_global = 0, first_global = 0;
  Eigen::Matrix<double, 2, kMaxGlobal> J_global;
};

/// A camera model maps each calibrated pixel to an observation line. The lines
/// of a central camera start at the origin. Axes: x right, y down, z forward.
///
/// Results are nullopt outside the calibrated area, never extrapolated.
class CameraModel {
 public:
  virtual ~CameraModel() = default;

  /// Returns the name of the model as in camera.yaml: "central-generic",
  /// "opencv".
  virtual std::string Name() const = 0;
  virtual std::unique_ptr<CameraModel> Clone() const = 0;

  /// Returns the directions of a generic model's control points; null for other
  /// models.
  virtual const BSplineSurface* DirectionGrid() const { return nullptr; }
  /// Returns this model if it is parametric, otherwise null.
  virtual const ParametricModel* Parametric() const { return nullptr; }
  /// Returns the model over focus or temperature that this camera evaluates at
  /// an operating point; null for other cameras.
  virtual const OperatingPointModel* GetOperatingPointModel() const {
    return nullptr;
  }

  /// Returns the generic model with the same area and number of control points
  /// that is closest to `other`; parametric models return a copy of `other`.
  virtual std::unique_ptr<CameraModel> FittedTo(
      const CameraModel& other) const {
    return other.Clone();
  }

  const ImageSize& image_size() const { return image_size_; }
  const Area& area() const { return area_; }

  /// Image circle, if known and smaller than the image. The model is also
  /// defined outside it, but these pixels receive no light.
  const std::optional<ImageCircle>& image_circle() const {
    return image_circle_;
  }
  void SetImageCircle(const std::optional<ImageCircle>& circle) {
    image_circle_ = circle;
  }
  /// Returns false if the pixel is known to be outside the image circle.
  bool IsInImageCircle(const Eigen::Vector2d& pixel) const {
    return !image_circle_ || image_circle_->Contains(pixel);
  }

  /// Returns the unit direction of a pixel in the area.
  virtual std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const = 0;

  virtual bool IsCentral() const { return true; }

  /// Returns the observation line of a pixel in the area.
  virtual std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const {
    const std::optional<Eigen::Vector3d> direction = Unproject(pixel);
    if (!direction) return std::nullopt;
    return ObservationLine{Eigen::Vector3d::Zero(), *direction};
  }

  /// Projects a point, or for a central camera a direction of any length;
  /// nullopt if the pixel is outside the area extended by margin_px. An initial
  /// value `start` near the result saves time. Returns nullopt if the grid is
  /// folded at `start`.
  virtual std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                                 const Eigen::Vector2d* start,
                                                 double margin_px) const = 0;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point) const {
    return Project(point, nullptr, 0);
  }

  /// Project() with Jacobians with respect to the point and the parameters.
  virtual bool Linearize(const Eigen::Vector3d& point,
                         const Eigen::Vector2d* start, double margin_px,
                         LinearizedProjection* projection) const = 0;

  virtual Eigen::VectorXd Parameters() const = 0;
  virtual void SetParameters(const Eigen::VectorXd& parameters) = 0;
  int NumParameters() const { return static_cast<int>(Parameters().size()); }

 protected:
  CameraModel(const ImageSize& image_size, const Area& area)
      : image_size_(image_size), area_(area) {}
  CameraModel(const CameraModel&) = default;
  CameraModel& operator=(const CameraModel&) = default;

 private:
  ImageSize image_size_;
  Area area_;
  std::optional<ImageCircle> image_circle_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CAMERA_MODEL_H
