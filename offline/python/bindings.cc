#include "python/bindings.h"

#include <Eigen/Core>
#include <exception>

#include "dataset/error.h"
#include "dataset/text_encoding.h"

namespace raygrid {

std::string ToString(const PyCamera& camera) {
  const bool is_calibrated =
      camera.file.uncertainty || camera.file.training.has_value();
  return FormatCameraFile(camera.file,
                          is_calibrated ? Digits::kTwelve : Digits::kAll);
}

std::string ToPath(const py::object& path) {
  py::object text = py::reinterpret_steal<py::object>(PyOS_FSPath(path.ptr()));
  if (!text) throw py::error_already_set();
  if (py::isinstance<py::bytes>(text)) return text.cast<std::string>();
  PyObject* encoded = PyUnicode_EncodeFSDefault(text.ptr());
  if (!encoded) throw py::error_already_set();
  return py::reinterpret_steal<py::bytes>(encoded).cast<std::string>();
}

void Warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, Printable(text).c_str(), 1) != 0)
    throw py::error_already_set();
}

Eigen::Matrix4d ToMatrix(const Pose& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = pose.translation;
  return matrix;
}

namespace {

// Never released: lives as long as the interpreter.
PyObject* error_type = nullptr;

// Raises an exception with the message and the exit code of the commands.
void RaiseError(const Error& error) {
  const py::object raised =
      py::reinterpret_borrow<py::object>(error_type)(Printable(error.what()));
  raised.attr("code") = static_cast<int>(error.code());
  PyErr_SetObject(error_type, raised.ptr());
}

void BindErrors(py::module_* module) {
  error_type = PyErr_NewExceptionWithDoc(
      "raygrid.Error",
      "An error of the calibrator, in one line: what failed, where, and the "
      "remedy. The attribute code is the exit code of the commands, 1 to 8 "
      "(raygrid --help).",
      PyExc_RuntimeError, nullptr);
  module->add_object("Error", error_type);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      RaiseError(error);
    }
  });
}

}  // namespace
}  // namespace raygrid

PYBIND11_MODULE(_raygrid, module) {
  namespace py = pybind11;
  // Eigen chooses the order of summation by cache sizes; these sizes make
  // results identical to those of the commands.
  Eigen::setCpuCacheSizes(32 << 10, 512 << 10, 4 << 20);
  py::options options;
  options.disable_function_signatures();
  module.doc() = "The calibrator's extension; use the package raygrid.";
  raygrid::BindErrors(&module);
  raygrid::BindView(&module);
  raygrid::BindCamera(&module);
  raygrid::BindDetection(&module);
  raygrid::BindResult(&module);
  raygrid::BindCalibration(&module);
  raygrid::BindExchange(&module);
}
