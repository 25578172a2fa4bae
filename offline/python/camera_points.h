#ifndef RAYGRID_PYTHON_CAMERA_POINTS_H
#define RAYGRID_PYTHON_CAMERA_POINTS_H

#include "python/bindings.h"

namespace raygrid {

/// Arrays of points to pixels and back: Camera.project(), unproject() and
/// rays(), whose docstrings in camera_binding.cc say shapes and units. They
/// compute without Python's lock, by so many threads.
py::object Project(const PyCamera& self, const py::object& given,
                   bool with_jacobians, int num_threads);
py::object Unproject(const PyCamera& self, const py::object& given,
                     bool with_jacobians, int num_threads);
py::tuple Rays(const PyCamera& self, const py::object& given, int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_PYTHON_CAMERA_POINTS_H
