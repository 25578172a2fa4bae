#ifndef RAYGRID_SIMULATION_ASYMMETRIC_CAMERA_H
#define RAYGRID_SIMULATION_ASYMMETRIC_CAMERA_H

#include <Eigen/Geometry>
#include <memory>

#include "camera/camera_model.h"

namespace raygrid {

/// Ground truth without rotational symmetry: subclasses define the exact
/// direction of an image position and its inverse. Positions are relative to
/// the image centre, in image widths. The parameters cannot be optimized.
class AsymmetricCamera : public CameraModel {
 public:
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;
  bool Linearize(const Eigen::Vector3d& point, const Eigen::Vector2d* start,
                 double margin_px,
                 LinearizedProjection* projection) const override;
  Eigen::VectorXd Parameters() const override { return {}; }
  void SetParameters(const Eigen::VectorXd&) override {}

 protected:
  AsymmetricCamera(const ImageSize& size, const Area& area)
      : CameraModel(size, area) {}

  /// Returns a direction of any length.
  virtual Eigen::Vector3d DirectionFromPosition(
      const Eigen::Vector2d& position) const = 0;
  virtual std::optional<Eigen::Vector2d> PositionFromDirection(
      const Eigen::Vector3d& direction) const = 0;

 private:
  Eigen::Vector2d PositionFromPixel(const Eigen::Vector2d& pixel) const;
};

/// Crossed cylinders: horizontally equidistant, vertically a perspective with
/// twice the focal length.
///   x = f longitude,  y = 2 f tan(latitude)
class AnamorphicCamera : public AsymmetricCamera {
 public:
  AnamorphicCamera(const ImageSize& size, const Area& area)
      : AsymmetricCamera(size, area) {}
  std::string Name() const override { return "anamorphic"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<AnamorphicCamera>(*this);
  }

 protected:
  Eigen::Vector3d DirectionFromPosition(
      const Eigen::Vector2d& position) const override;
  std::optional<Eigen::Vector2d> PositionFromDirection(
      const Eigen::Vector3d& direction) const override;
};

/// An equidistant fisheye whose axis intersects the image a third of its width
/// from the centre, with a sensor tilted about the column axis: with q the
/// fisheye's image in a plane perpendicular to its axis, p = q / (1 - t q.x)
/// relative to the intersection.
class OffAxisCamera : public AsymmetricCamera {
 public:
  OffAxisCamera(const ImageSize& size, const Area& area)
      : AsymmetricCamera(size, area) {}
  std::string Name() const override { return "off-axis"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<OffAxisCamera>(*this);
  }

 protected:
  Eigen::Vector3d DirectionFromPosition(
      const Eigen::Vector2d& position) const override;
  std::optional<Eigen::Vector2d> PositionFromDirection(
      const Eigen::Vector3d& direction) const override;
};

/// A focal length on the left and twice that on the right, with a smooth
/// transition within a fifth of the width: with s(x) = 1 / focal length at a
/// column,
///   X / Z = the integral of s from the centre to x,  Y / Z = y s(x)
class TwoFocalLengthsCamera : public AsymmetricCamera {
 public:
  TwoFocalLengthsCamera(const ImageSize& size, const Area& area)
      : AsymmetricCamera(size, area) {}
  std::string Name() const override { return "halves"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<TwoFocalLengthsCamera>(*this);
  }

 protected:
  Eigen::Vector3d DirectionFromPosition(
      const Eigen::Vector2d& position) const override;
  std::optional<Eigen::Vector2d> PositionFromDirection(
      const Eigen::Vector3d& direction) const override;
};

/// Two elements with different axes: an equidistant fisheye, and one that adds
/// barrel distortion to its image q about another centre c:
///   p = c + (q - c) / (1 + k |q - c|^2)
class DecentredCamera : public AsymmetricCamera {
 public:
  DecentredCamera(const ImageSize& size, const Area& area)
      : AsymmetricCamera(size, area) {}
  std::string Name() const override { return "decentred"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<DecentredCamera>(*this);
  }

 protected:
  Eigen::Vector3d DirectionFromPosition(
      const Eigen::Vector2d& position) const override;
  std::optional<Eigen::Vector2d> PositionFromDirection(
      const Eigen::Vector3d& direction) const override;
};

/// A hyperbolic mirror, with a camera in its second focus, looking at its side.
/// Images are flipped, as such cameras deliver them, so they are not mirrored.
/// A hyperboloid is equivalent to the unit sphere seen from a point on its axis
/// (Geyer and Daniilidis, 2000): a unit direction d is projected like the point
/// (d.x, d.y, d.z + xi).
class MirrorCamera : public AsymmetricCamera {
 public:
  MirrorCamera(const ImageSize& size, const Area& area);
  std::string Name() const override { return "mirror"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<MirrorCamera>(*this);
  }

 protected:
  Eigen::Vector3d DirectionFromPosition(
      const Eigen::Vector2d& position) const override;
  std::optional<Eigen::Vector2d> PositionFromDirection(
      const Eigen::Vector3d& direction) const override;

 private:
  Eigen::Matrix3d mirror_from_camera_;
};

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_ASYMMETRIC_CAMERA_H
