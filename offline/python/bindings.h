/// The types and helpers that parts of the module share.
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

/// The Camera of Python.
struct PyCamera {
  CameraFile file;
};

/// The Detection of Python: the features of an image.
struct PyDetection {
  ImageSize size;
  ImageFeatures features;
  std::vector<std::string> warnings;
};

/// The Calibration of Python.
struct PyCalibration {
  RigResult result;
  int num_threads = 0;

  /// The camera of a name, "" of one without a rig. Throws KeyError of Python.
  size_t IndexOf(const std::string& name) const;
};

/// A camera as Python gave it: images, or features.
struct GivenCamera {
  std::string name;
  std::vector<std::string> images;
  std::vector<PyDetection> detections;
};

/// Images or detections, or by the names of a rig's cameras theirs. Throws
/// TypeError and ValueError of Python.
std::vector<GivenCamera> TakeCameras(const py::object& given);

/// The features of a camera that was given as detections. Throws InputError if
/// they are not of one size, or share names.
Dataset DatasetOf(const GivenCamera& given);

/// The text of camera.yaml. What was not calibrated keeps all digits, so that a
/// lens comes out of the file as it is.
std::string ToText(const PyCamera& camera);

/// A path as Python has it: str, bytes or os.PathLike.
std::string PathOf(const py::object& path);

/// A warning of Python (UserWarning).
void Warn(const std::string& text);

/// A matrix (4, 4), from homogeneous points to such.
Eigen::Matrix4d MatrixOfPose(const Pose& pose);

void BindView(py::module_* module);
void BindCamera(py::module_* module);
void BindDetection(py::module_* module);
void BindResult(py::module_* module);
void BindCalibration(py::module_* module);
void BindExchange(py::module_* module);

}  // namespace raygrid

#endif  // RAYGRID_PYTHON_BINDINGS_H
