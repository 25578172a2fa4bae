#ifndef RAYGRID_SIMULATION_UNEVEN_LENS_H
#define RAYGRID_SIMULATION_UNEVEN_LENS_H

#include <Eigen/Geometry>
#include <memory>

#include "camera/camera_model.h"

namespace raygrid {

/// Ground truth without an axis of symmetry in the image: subclasses say the
/// exact direction of a place in the image and the other way round. Places are
/// offsets from the image's middle in widths of the image. Its parameters
/// cannot be adjusted.
class UnevenLens : public CameraModel {
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
  UnevenLens(const ImageSize& size, const Area& area)
      : CameraModel(size, area) {}

  /// A direction of any length.
  virtual Eigen::Vector3d DirectionOf(const Eigen::Vector2d& place) const = 0;
  virtual std::optional<Eigen::Vector2d> PlaceOf(
      const Eigen::Vector3d& direction) const = 0;

 private:
  Eigen::Vector2d PlaceOfPixel(const Eigen::Vector2d& pixel) const;
};

/// Crossed cylinders: horizontally in proportion to the angle, vertically a
/// perspective of twice the focal length.
///   x = f longitude,  y = 2 f tan(latitude)
class AnamorphicLens : public UnevenLens {
 public:
  AnamorphicLens(const ImageSize& size, const Area& area)
      : UnevenLens(size, area) {}
  std::string Name() const override { return "anamorphic"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<AnamorphicLens>(*this);
  }

 protected:
  Eigen::Vector3d DirectionOf(const Eigen::Vector2d& place) const override;
  std::optional<Eigen::Vector2d> PlaceOf(
      const Eigen::Vector3d& direction) const override;
};

/// An equidistant fisheye whose axis meets the image a third of its width from
/// the middle, before a sensor that is tilted about the axis of columns: with q
/// the fisheye's image on a plane square to its axis,
///   p = q / (1 - t q.x)
/// from where the axis meets the image.
class OffAxisLens : public UnevenLens {
 public:
  OffAxisLens(const ImageSize& size, const Area& area)
      : UnevenLens(size, area) {}
  std::string Name() const override { return "off-axis"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<OffAxisLens>(*this);
  }

 protected:
  Eigen::Vector3d DirectionOf(const Eigen::Vector2d& place) const override;
  std::optional<Eigen::Vector2d> PlaceOf(
      const Eigen::Vector3d& direction) const override;
};

/// Half a lens on the left and half one of twice the focal length on the right,
/// which pass into each other within a fifth of the width: with s(x) = 1 /
/// focal length at a column,
///   X / Z = the integral of s from the middle to x,  Y / Z = y s(x)
class HalvesLens : public UnevenLens {
 public:
  HalvesLens(const ImageSize& size, const Area& area)
      : UnevenLens(size, area) {}
  std::string Name() const override { return "halves"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<HalvesLens>(*this);
  }

 protected:
  Eigen::Vector3d DirectionOf(const Eigen::Vector2d& place) const override;
  std::optional<Eigen::Vector2d> PlaceOf(
      const Eigen::Vector3d& direction) const override;
};

/// Two elements whose axes lie apart: an equidistant fisheye, and one that
/// bends its image q with barrel distortion about another centre c:
///   p = c + (q - c) / (1 + k |q - c|^2)
class DecentredLens : public UnevenLens {
 public:
  DecentredLens(const ImageSize& size, const Area& area)
      : UnevenLens(size, area) {}
  std::string Name() const override { return "decentred"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<DecentredLens>(*this);
  }

 protected:
  Eigen::Vector3d DirectionOf(const Eigen::Vector2d& place) const override;
  std::optional<Eigen::Vector2d> PlaceOf(
      const Eigen::Vector3d& direction) const override;
};

/// A hyperbolic mirror, with a camera in its second focus that looks at its
/// flank. Images are flipped, as such cameras deliver them: nothing is
/// mirrored. A hyperboloid is the unit sphere seen from a point of its axis
/// (Geyer and Daniilidis, 2000): a unit direction d is seen like the point
/// (d.x, d.y, d.z + xi).
class MirrorLens : public UnevenLens {
 public:
  MirrorLens(const ImageSize& size, const Area& area);
  std::string Name() const override { return "mirror"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<MirrorLens>(*this);
  }

 protected:
  Eigen::Vector3d DirectionOf(const Eigen::Vector2d& place) const override;
  std::optional<Eigen::Vector2d> PlaceOf(
      const Eigen::Vector3d& direction) const override;

 private:
  Eigen::Matrix3d mirror_from_camera_;
};

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_UNEVEN_LENS_H
