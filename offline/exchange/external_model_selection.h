#ifndef RAYGRID_EXCHANGE_EXTERNAL_MODEL_SELECTION_H
#define RAYGRID_EXCHANGE_EXTERNAL_MODEL_SELECTION_H

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "exchange/external_model.h"

namespace raygrid {

/// Accuracy of a converted camera: projection errors of the rays of pixels in
/// the valid region, after a rotation.
struct ModelFit {
  double rms_px = 0, p99_px = 0, max_px = 0;
  size_t num_pixels = 0;  ///< compared pixels
  size_t num_unrepresentable =
      0;  ///< valid pixels that the model cannot represent
  double max_valid_angle_rad =
      0;  ///< maximum angle of valid pixels from the axis
  bool has_valid_region = false;  ///< false: the camera has no valid region
  Eigen::Quaterniond fitted_from_camera = Eigen::Quaterniond::Identity();

  bool IsTurned() const {
    return fitted_from_camera.angularDistance(Eigen::Quaterniond::Identity()) >
           0;
  }
};

/// A camera converted to one of a program's models.
struct SelectedModel {
  ConvertedCamera lens;
  std::unique_ptr<CameraModel> model;  ///< raygrid's model of the conversion
  std::optional<ModelFit> fit;         ///< nullopt if the conversion is exact
};

/// Selects the external model with the fewest parameters that represents the
/// camera exactly. If there is none, fits all models and selects the one with
/// the fewest parameters, unless a model with more parameters reduces the error
/// by at least 2 % and by a relevant amount. Of models with equal errors, the
/// first one is selected. Pixels outside the valid region have a negligible
/// weight; without a mask, all pixels are valid. Non-central cameras require
/// non-central models and vice versa: otherwise throws Error(kUsage). Throws
/// Error(kQualityTooLow) if no model can represent any valid pixel.
SelectedModel SelectExternalModel(
    const std::vector<const ExternalModel*>& external_models,
    const CameraModel& camera, const ValidityMask* valid_region,
    int num_threads = 1);

/// Measures the accuracy of a converted camera; for non-central cameras, with
/// points at a distance of 1 m.
ModelFit ComputeModelFit(const CameraModel& camera,
                         const ValidityMask* valid_region,
                         const CameraModel& lens,
                         const ExternalModel& external_model,
                         const Eigen::Quaterniond& fitted_from_camera);

/// Formats "RMS 0.0123 px, 99th percentile 0.0456 px, max 0.0789 px at 19200
/// valid pixels; rotated by 0.0012 rad, ...".
std::string FormatModelFit(const ModelFit& fit);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_EXTERNAL_MODEL_SELECTION_H
