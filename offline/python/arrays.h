/// Conversion of numpy arrays.
#ifndef RAYGRID_PYTHON_ARRAYS_H
#define RAYGRID_PYTHON_ARRAYS_H

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace raygrid {

namespace py = pybind11;
using DoubleArray = py::array_t<double, py::array::c_style>;

/// Vectors of a fixed length from a Python array with any number of leading
/// axes; a contiguous array of doubles is not copied.
struct InputVectors {
  DoubleArray array;
  size_t count = 0;
  int length = 0;
  std::vector<py::ssize_t> axes;  ///< leading axes

  const double* operator[](size_t k) const { return array.data() + k * length; }
  /// Returns a new array with the same leading axes, and others appended.
  DoubleArray Like(const std::vector<py::ssize_t>& behind) const;
};

/// Throws Python's TypeError or ValueError, with the argument's name, if the
/// array is not numeric, has another length, or is not finite.
InputVectors ReadVectors(const py::object& given, int length,
                         const std::string& name);

/// Returns a read-only copy.
template <typename Matrix>
DoubleArray ReadOnly(const Matrix& matrix) {
  DoubleArray array({matrix.rows(), matrix.cols()});
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < matrix.cols(); ++j)
      array.mutable_at(i, j) = matrix(i, j);
  array.attr("setflags")(false);
  return array;
}

DoubleArray ReadOnlyVector(const double* values, size_t count);

}  // namespace raygrid

#endif  // RAYGRID_PYTHON_ARRAYS_H
