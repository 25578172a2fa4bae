#ifndef RAYGRID_EXCHANGE_EXTERNAL_MODEL_H
#define RAYGRID_EXCHANGE_EXTERNAL_MODEL_H

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "camera/parametric_model.h"
#include "camera/splined_stereographic.h"
#include "exchange/pixel_origin.h"

namespace raygrid {

/// A grid camera of another program that approximates one of raygrid's, with
/// the rotation between their frames.
struct ExternalGrid {
  std::shared_ptr<const CameraModel> camera;
  Eigen::Quaterniond camera_from_input = Eigen::Quaterniond::Identity();
};

/// A camera model of another program: one of raygrid's models
/// (camera/model_registry.h) with a subset of its parameters, in the program's
/// order. Missing parameters are 0.
struct ExternalModel {
  std::string name;                     ///< the program's own: "plumb_bob"
  std::string model;                    ///< raygrid's: "opencv"
  std::vector<std::string> parameters;  ///< "fx", "cx", "k1"; "f" is fx and fy
  PixelOrigin origin = PixelOrigin::kFirstPixelCenter;
  /// Maximum angle between ray and optical axis that the program supports.
  double max_supported_angle_rad = M_PI;
  /// Export to this model only if the user names it.
  bool export_only_if_named = false;
  /// For grids: fits the program's grid camera to a camera. Null for other
  /// models, and for puzzlepaint's grids.
  ExternalGrid (*fit_grid)(const CameraModel& camera,
                           const ValidityMask* valid_region) = nullptr;

  /// Returns whether the number of parameters is variable (a spline).
  bool IsSpline() const { return model == models::kSplinedStereographic; }
  /// Returns whether it is another program's grid, an approximation.
  bool IsGrid() const { return model == models::kCentralGeneric || HasLines(); }
  bool HasLines() const { return model == models::kNonCentralGeneric; }
  bool Has(const std::string& parameter) const;
  /// Returns the model's parameters that the program does not have.
  std::vector<std::string> Missing() const;
};

/// Makes a model with the parameters fx, fy, cx, cy and coefficients.
ExternalModel MakeExternalModel(const std::string& name,
                                const std::string& model,
                                const std::vector<std::string>& coefficients);

/// A camera in terms of an external model: parameter values in the model's
/// order, in the program's pixel convention.
struct ConvertedCamera {
  const ExternalModel* external_model = nullptr;
  ImageSize size;
  std::vector<double> values;
  /// For splined models: the grid of the spline, without values; otherwise
  /// null.
  std::shared_ptr<const SplinedStereographic> spline = nullptr;
  /// For grid models: the grid camera, raygrid's after import, the program's
  /// before export; otherwise null.
  std::shared_ptr<const CameraModel> grid = nullptr;

  /// Skew of the camera matrix (change of x at y = 1), which no model of
  /// raygrid supports: such a camera is imported as a grid
  /// (exchange/nearest_grid.h).
  double skew_px = 0;

  /// Throws std::out_of_range if the model has no such parameter.
  double Value(const std::string& parameter) const;
  /// Returns the values from index `first`, e.g. the distortion coefficients of
  /// a model made by MakeExternalModel().
  std::vector<double> ValuesFrom(size_t first) const;
};

/// Makes the camera model with the whole image as its area, or returns its
/// grid. Throws InputError for invalid parameters, such as non-finite numbers
/// or zero focal lengths.
std::unique_ptr<CameraModel> MakeCameraModel(const ConvertedCamera& lens);

/// Returns the fraction of 64 x 64 positions in the area that have no ray.
double ComputeUndefinedFraction(const CameraModel& lens);

/// Converts a camera to an external model; nullopt unless the conversion is
/// exact, as for grids.
std::optional<ConvertedCamera> ConvertToExternalModel(
    const ExternalModel& external_model, const CameraModel& lens);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_EXTERNAL_MODEL_H
