#ifndef RAYGRID_DATASET_CAMERA_FILE_H
#define RAYGRID_DATASET_CAMERA_FILE_H

#include <memory>
#include <optional>
#include <string>

#include "camera/camera_model.h"
#include "camera/camera_uncertainty.h"
#include "camera/operating_point_model.h"
#include "camera/population_covariance.h"
#include "camera/pose.h"
#include "dataset/capture.h"
#include "dataset/line_delay.h"

namespace raygrid {

/// Error metrics: residual norms over a set of features.
struct ErrorMetrics {
  double median_px = 0, rms_px = 0, max_px = 0;
  int count = 0;
};

/// Predicted uncertainty of an operating-point model at one operating point.
struct OperatingPointUncertainty {
  OperatingPoint values;
  UncertaintyLattice lattice;
};

/// An operating-point model over its ranges, with its uncertainty.
struct OperatingPointCalibration {
  OperatingPointModel cameras;
  std::vector<OperatingPointUncertainty> deviations;  ///< ascending by values
};

/// The contents of camera.yaml.
struct CameraFile {
  std::shared_ptr<const CameraModel> camera;
  std::string name, serial;
  std::string assessment;  ///< "pass", "warn" or "fail"; "" if absent
  std::optional<ErrorMetrics> training, held_out;
  std::optional<CameraUncertainty> uncertainty;
  /// The pose of a rotated view relative to its camera.
  std::optional<Pose> camera_from_view;
  std::optional<Capture> capture;  ///< not empty if present
  /// The operating-point model; `camera` is its camera in the middle of each
  /// range.
  std::optional<OperatingPointCalibration> stack;
  std::optional<LineDelay> line_delay;
  /// Variation over the fleet, if the camera is a population mean.
  std::optional<PopulationCovariance> spread;
};

/// Throws InputError.
CameraFile ReadCameraFile(const std::string& path);
/// Parses a camera file; path is used in errors.
CameraFile ParseCameraFile(const std::string& path, const std::string& text);
/// Number of digits of a camera's parameters: 12, or the number needed for an
/// exact round trip.
enum class Digits { kTwelve, kAll };
std::string FormatCameraFile(const CameraFile& file,
                             Digits digits = Digits::kTwelve);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_CAMERA_FILE_H
