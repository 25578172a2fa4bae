#ifndef RAYGRID_EXCHANGE_OCAM_CAMERA_H
#define RAYGRID_EXCHANGE_OCAM_CAMERA_H

#include <vector>

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"
#include "exchange/external_model.h"

namespace raygrid {

/// The numbers of OCamCalib's model (D. Scaramuzza, A. Martinelli, R. Siegwart,
/// "A Flexible Technique for Accurate Omnidirectional Camera Calibration and
/// Structure from Motion", ICVS 2006). A pixel's row and column, from the
/// centre, are [c d; e 1] times a point of the undistorted image; the ray of a
/// point at radius r has the z coordinate -f(r).
struct OcamNumbers {
  std::vector<double> polynomial;  ///< f
  double row = 0, column = 0;      ///< the centre
  double c = 1, d = 0, e = 0;

  /// Returns the direction of a pixel, of any length, in raygrid's axes.
  Eigen::Vector3d Direction(const Eigen::Vector2d& pixel) const;
};

/// A camera with these parameters, over the whole image.
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
  /// Returns false: the model is not optimized.
  bool Linearize(const Eigen::Vector3d&, const Eigen::Vector2d*, double,
                 LinearizedProjection*) const override {
    return false;
  }
  Eigen::VectorXd Parameters() const override;
  void SetParameters(const Eigen::VectorXd& parameters) override;

  const OcamNumbers& numbers() const { return numbers_; }
  /// Returns the radius at an angle from the axis; nullopt outside the image.
  std::optional<double> Radius(double angle_rad) const;
  /// Returns the largest radius in the image.
  double max_radius() const { return max_radius_; }

 private:
  OcamNumbers numbers_;
  double max_radius_ = 0;
};

/// Fits OCamCalib's inverse polynomial, the radius over the angle from the
/// image plane, with the lowest degree accurate to 0.01 px, or the maximum.
std::vector<double> InverseOcamPolynomial(const OcamCamera& camera);

/// Fits this model to a camera by least squares of projection errors in the
/// valid region: degree 4, OCamCalib's default, up to 8 while another degree
/// reduces the error by at least 2 %.
ExternalGrid FitOcamCamera(const CameraModel& camera,
                           const ValidityMask* valid_region);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OCAM_CAMERA_H
