/// The types and helpers that parts of the module share.
#ifndef RAYGRID_PYTHON_BINDINGS_H
#define RAYGRID_PYTHON_BINDINGS_H

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>

#include "dataset/camera_file.h"
#include "python/arrays.h"
#include "python/background.h"

namespace raygrid {

/// The Camera of Python.
struct PyCamera {
  CameraFile file;
};

/// The text of camera.yaml. What was not calibrated keeps all digits, so that a
/// lens comes out of the file as it is.
std::string TextOf(const PyCamera& camera);

/// A path as Python has it: str, bytes or os.PathLike.
std::string PathOf(const py::object& path);

/// A warning of Python (UserWarning).
void Warn(const std::string& text);

/// A matrix (4, 4), from homogeneous points to such.
Eigen::Matrix4d MatrixOfPose(const Pose& pose);

void BindView(py::module_* module);
void BindCamera(py::module_* module);
void BindCalibration(py::module_* module);
void BindExchange(py::module_* module);

}  // namespace raygrid

#endif  // RAYGRID_PYTHON_BINDINGS_H
