/// Types and helpers shared by the source files of the module.
#ifndef RAYGRID_PYTHON_BINDINGS_H
#define RAYGRID_PYTHON_BINDINGS_H

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <vector>

#include "calibration/calibration.h"
#include "dataset/camera_file.h"
#include "dataset/dataset.h"
#include "python/arrays.h"
#include "python/background.h"

namespace raygrid {

/// Python's Camera.
struct PyCamera {
  CameraFile file;
};

/// Python's Detection: the features of an image.
struct PyDetection {
  ImageSize size;
  ImageFeatures features;
  std::vector<std::string> warnings;
};

/// Python's Calibration.
struct PyCalibration {
  RigResult result;
  int num_threads = 0;

  /// Returns the index of a camera by name; "" without a rig. Throws Python's
  /// KeyError.
  size_t IndexOf(const std::string& name) const;
};

/// Images or features of a camera, as passed from Python.
struct InputCameraData {
  std::string name;
  std::vector<std::string> images;
  std::vector<PyDetection> detections;
};

/// Converts images or detections, or a dictionary of them by camera name.
/// Throws Python's TypeError and ValueError.
std::vector<InputCameraData> ReadCameras(const py::object& given);

/// Returns the features of a camera given as detections. Throws InputError if
/// sizes differ or names are not unique.
Dataset MakeDataset(const InputCameraData& given);

/// Formats camera.yaml. Values that were not calibrated keep all digits, so
/// that parsing restores them exactly.
std::string ToString(const PyCamera& camera);

/// Converts a Python path: str, bytes or os.PathLike.
std::string ToPath(const py::object& path);

/// Issues a Python UserWarning.
void Warn(const std::string& text);

/// Returns the 4 x 4 matrix of a pose, for homogeneous points.
Eigen::Matrix4d ToMatrix(const Pose& pose);

void BindView(py::module_* module);
void BindCamera(py::module_* module);
void BindDetection(py::module_* module);
void BindResult(py::module_* module);
void BindCalibration(py::module_* module);
void BindExchange(py::module_* module);

}  // namespace raygrid

#endif  // RAYGRID_PYTHON_BINDINGS_H
