#ifndef RAYGRID_PYTHON_CAMERA_POINTS_H
#define RAYGRID_PYTHON_CAMERA_POINTS_H

#include "python/bindings.h"

namespace raygrid {

/// Projection and unprojection of arrays: Camera.project(), unproject() and
/// rays(); shapes and units are in their docstrings in camera_binding.cc. They
/// run without the GIL, in num_threads threads.
py::object Project(const PyCamera& self, const py::object& given,
                   bool with_jacobians, int num_threads);
py::object Unproject(const PyCamera& self, const py::object& given,
                     bool with_jacobians, int num_threads);
py::tuple Rays(const PyCamera& self, const py::object& given, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PYTHON_CAMERA_POINTS_H
