#ifndef RAYGRID_DATASET_CAMERA_FILE_H
#define RAYGRID_DATASET_CAMERA_FILE_H

#include <memory>
#include <optional>
#include <string>

#include "camera/camera_model.h"
#include "camera/camera_stack.h"
#include "camera/camera_uncertainty.h"
#include "camera/lens_spread.h"
#include "camera/pose.h"
#include "dataset/capture.h"
#include "dataset/row_time.h"

namespace raygrid {

/// Residual norms over a set of features.
struct ErrorFigures {
  double median_px = 0, rms_px = 0, max_px = 0;
  int count = 0;
};

/// How well a stack is known at a value of each of its conditions.
struct StackDeviation {
  ConditionValues values;
  DeviationLattice lattice;
};

/// A camera over ranges of conditions, and how well it is known there.
struct StackOfCameras {
  CameraStack cameras;
  std::vector<StackDeviation> deviations;  ///< by values, ascending
};

/// camera.yaml: a camera and what is known of it.
struct CameraFile {
  std::shared_ptr<const CameraModel> camera;
  std::string name, serial;
  std::string verdict;  ///< the calibration's: "pass", "warn", "fail"; or ""
  std::optional<ErrorFigures> training, held_out;
  std::optional<CameraUncertainty> uncertainty;
  /// The pose of a view that is turned against the camera it is made from.
  std::optional<Pose> camera_from_view;
  std::optional<Capture> capture;  ///< knows something, if it is there
  /// The cameras that it is one of: the one in the middle.
  std::optional<StackOfCameras> stack;
  std::optional<RowTime> row_time;
  /// A fleet's middle camera: how its units differ from it.
  std::optional<LensSpread> spread;
};

/// Throws InputError.
CameraFile ReadCameraFile(const std::string& path);
/// The camera in a file's text; path is used in errors.
CameraFile ParseCameraFile(const std::string& path, const std::string& text);
/// A lens's parameters have 12 digits, or, for those that must come out of the
/// file as they are, as many as they need.
enum class Digits { kTwelve, kAll };
std::string FormatCameraFile(const CameraFile& file,
                             Digits digits = Digits::kTwelve);

}  // namespace raygrid

#endif  // RAYGRID_DATASET_CAMERA_FILE_H
