/// numpy's arrays in and out.
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

/// Vectors of some length, with any number of axes before: those of an array
/// that Python gave, which is not copied if it has doubles without gaps.
struct GivenVectors {
  DoubleArray array;
  size_t count = 0;
  int length = 0;
  std::vector<py::ssize_t> axes;  ///< before the vectors' own

  const double* operator[](size_t k) const { return array.data() + k * length; }
  /// An array with the same axes before, and others behind.
  DoubleArray Like(const std::vector<py::ssize_t>& behind) const;
};

/// Throws TypeError and ValueError of Python, naming the argument: for what has
/// no numbers, another length, or numbers that are not finite.
GivenVectors TakeVectors(const py::object& given, int length,
                         const std::string& name);

/// A copy that cannot be written to.
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
