#ifndef RAYGRID_EXCHANGE_OCAM_CAMERA_H
#define RAYGRID_EXCHANGE_OCAM_CAMERA_H

#include <vector>

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"
#include "exchange/lens_form.h"

namespace raygrid {

/// The numbers of OCamCalib's model (D. Scaramuzza, A. Martinelli, R. Siegwart,
/// "A Flexible Technique for Accurate Omnidirectional Camera Calibration and
/// Structure from Motion", ICVS 2006). A pixel's row and column, from the
/// centre on, are [c d; e 1] times a point of the undistorted image, and a
/// point at radius r there looks along -f(r) ahead.
struct OcamNumbers {
  std::vector<double> polynomial;  ///< f
  double row = 0, column = 0;      ///< the centre
  double c = 1, d = 0, e = 0;

  /// The direction that a pixel looks along, of any length, in raygrid's axes.
  Eigen::Vector3d Direction(const Eigen::Vector2d& pixel) const;
};

/// A camera of these numbers, over the whole image.
class OcamCamera : public CameraModel {
 public:
  OcamCamera(const ImageSize& size, OcamNumbers numbers);

  std::string Name() const override { return "ocamcalib"; }
  std::unique_ptr<CameraModel> Clone() const override {
    return std::make_unique<OcamCamera>(*this);
  }
  std::optional<Eigen::Vector3d> Unproject(
      const Eigen::Vector2d& pixel) const override;
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point,
                                         const Eigen::Vector2d* start,
                                         double margin_px) const override;
  using CameraModel::Project;
  /// False: nothing adjusts this model.
  bool Linearize(const Eigen::Vector3d&, const Eigen::Vector2d*, double,
                 LinearizedProjection*) const override {
    return false;
  }
  Eigen::VectorXd Parameters() const override;
  void SetParameters(const Eigen::VectorXd& parameters) override;

  const OcamNumbers& numbers() const { return numbers_; }
  /// The radius at which a ray is seen, by its angle from the axis; nothing
  /// beyond the image.
  std::optional<double> Radius(double angle_rad) const;
  /// The largest radius in the image.
  double max_radius() const { return max_radius_; }

 private:
  OcamNumbers numbers_;
  double max_radius_ = 0;
};

/// OCamCalib's inverse polynomial, the radius over the angle from the image
/// plane, of the least degree that keeps 0.01 px, or of the largest one.
std::vector<double> InverseOcamPolynomial(const OcamCamera& camera);

/// The nearest camera of this model, by least squares of how far it projects
/// the directions of trusted pixels from them: of the degree of 4 that
/// OCamCalib begins with, up to 8 while that leaves 2 % less.
FormGrid FitOcamCamera(const CameraModel& camera, const ValidityMask* trusted);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OCAM_CAMERA_H
