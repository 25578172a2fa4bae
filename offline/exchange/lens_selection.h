#ifndef RAYGRID_EXCHANGE_LENS_SELECTION_H
#define RAYGRID_EXCHANGE_LENS_SELECTION_H

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "exchange/lens_form.h"

namespace raygrid {

/// How well a lens stands for a camera: how far it projects directions of
/// trusted pixels from them, after the rotation.
struct LensFit {
  double rms_px = 0, p99_px = 0, max_px = 0;
  size_t num_pixels = 0;       ///< that were compared
  size_t num_beyond = 0;       ///< trusted ones that the form has no place for
  double widest_rad = 0;       ///< off the lens's axis, of trusted pixels
  bool is_of_trusted = false;  ///< else the camera does not tell which are
  Eigen::Quaterniond lens_from_camera = Eigen::Quaterniond::Identity();

  bool IsTurned() const {
    return lens_from_camera.angularDistance(Eigen::Quaterniond::Identity()) > 0;
  }
};

/// A camera in one of the forms of a program.
struct SelectedLens {
  ConvertedLens lens;
  std::unique_ptr<CameraModel> model;  ///< what the lens is to raygrid
  std::optional<LensFit> fit;          ///< none if it is the camera itself
};

/// The camera itself in the form of the fewest parameters that holds it. Else
/// the nearest lens of the form of the fewest parameters, unless others leave
/// at least 2 % less, and more than a little. Among equals the first form
/// counts. Pixels that are not trusted have next to no say; without a mask all
/// are. Forms of lines are for cameras of lines, and no others for these: else
/// throws Error(kUsage), as it throws Error(kQuality) if no
/// form has a place for any trusted pixel.
SelectedLens SelectLens(const std::vector<const LensForm*>& forms,
                        const CameraModel& camera, const ValidityMask* trusted,
                        int num_threads = 1);

/// How well a lens of a form stands for a camera; at points 1 m away, if it is
/// a camera of lines.
LensFit MeasureLensFit(const CameraModel& camera, const ValidityMask* trusted,
                       const CameraModel& lens, const LensForm& form,
                       const Eigen::Quaterniond& lens_from_camera);

/// "RMS 0.0123 px, 99 % below 0.0456 px, largest 0.0789 px at 19200 trusted
/// pixels; turned by 0.00123 rad, quaternion (w, x, y, z) ...".
std::string FormatLensFit(const LensFit& fit);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_LENS_SELECTION_H
