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

/// A projection and its derivatives. It depends on the nodes (control points)
/// of a spline around it, all of which act alike but for their weights, and on
/// parameters that act everywhere.
struct LinearizedProjection {
  static constexpr int kMaxNodes = 16, kMaxPerNode = 14, kMaxGlobal = 20;
  static constexpr int kMaxParameters = kMaxNodes * kMaxPerNode + kMaxGlobal;

  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> J_point;  ///< d pixel / d point

  /// The numbers of nodes and of their parameters, the same for all projections
  /// of a camera: nodes may have no weight.
  int num_nodes = 0, num_per_node = 0;
  std::array<int, kMaxNodes> node_parameter;  ///< the first one of each node
  std::array<double, kMaxNodes> node_weight;
  /// d pixel / d a node's parameters, for a node of weight 1.
  Eigen::Matrix<double, 2, kMaxPerNode> J_node;

  int num_global = 0, first_global = 0;
  Eigen::Matrix<double, 2, kMaxGlobal> J_global;
};

/// Every calibrated pixel looks along one line. In a central camera all lines
/// start at the origin. Camera axes are x right, y down, z forward.
///
/// Outside its calibrated area a camera answers "nothing", never a guess.
class CameraModel {
 public:
  virtual ~CameraModel() = default;

  /// The model's name as in camera.yaml: "central-generic", "opencv".
  virtual std::string Name() const = 0;
  virtual std::unique_ptr<CameraModel> Clone() const = 0;

  /// The directions of a generic model's control points; null for others.
  virtual const BSplineSurface* DirectionGrid() const { return nullptr; }
  /// This model, if it is parametric; else null.
  virtual const ParametricModel* Parametric() const { return nullptr; }
  /// What a camera over a range of conditions is part of; null for others.
  virtual const OperatingPointModel* Stack() const { return nullptr; }

  /// The generic model with as many control points, over the same area, that
  /// is closest to another camera; for others, that camera itself.
  virtual std::unique_ptr<CameraModel> FittedTo(
      const CameraModel& other) const {
    return other.Clone();
  }

  const ImageSize& image_size() const { return image_size_; }
  const Area& area() const { return area_; }

  /// The part of the image that the lens lights, if it is known not to be all.
  /// The model goes on beyond, but there is nothing to be seen.
  const std::optional<ImageCircle>& image_circle() const {
    return image_circle_;
  }
  void SetImageCircle(const std::optional<ImageCircle>& circle) {
    image_circle_ = circle;
  }
  /// Whether the lens throws light on a pixel, as far as is known.
  bool IsInImageCircle(const Eigen::Vector2d& pixel) const {
    return !image_circle_ || image_circle_->Contains(pixel);
  }

  /// Unit direction that a pixel of the area looks along.
  virtual std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const = 0;

  virtual bool IsCentral() const { return true; }

  /// The line along which a pixel of the area looks.
  virtual std::optional<ObservationLine> Line(
      const Eigen::Vector2d& pixel) const {
    const std::optional<Eigen::Vector3d> direction = Unproject(pixel);
    if (!direction) return std::nullopt;
    return ObservationLine{Eigen::Vector3d::Zero(), *direction};
  }

  /// The pixel at which a point, or a central camera's direction of any length,
  /// is seen; nothing if it is not within the area widened by margin_px. A
  /// start, near the result, saves time. Nothing is found from a start where a
  /// grid folds over.
  virtual std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                                 const Eigen::Vector2d* start,
                                                 double margin_px) const = 0;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point) const {
    return Project(point, nullptr, 0);
  }

  /// Project() with derivatives by the point and by the parameters.
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
