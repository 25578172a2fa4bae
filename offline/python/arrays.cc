#include "python/arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

std::string FormatShape(const py::array& array) {
  std::string text;
  for (py::ssize_t k = 0; k < array.ndim(); ++k)
    text += fmt::format("{}{}", k == 0 ? "" : ", ", array.shape(k));
  return fmt::format("({}{})", text, array.ndim() == 1 ? "," : "");
}

// Whether all values are finite: the difference of a value from itself is then
// 0. Four independent sums allow parallel execution.
bool AreFinite(const double* begin, const double* end) {
  double sums[4] = {};
  for (; end - begin >= 4; begin += 4)
    for (int k = 0; k < 4; ++k) sums[k] += begin[k] - begin[k];
  for (; begin < end; ++begin) sums[0] += *begin - *begin;
  return sums[0] + sums[1] + sums[2] + sums[3] == 0;
}

void RequireFinite(const InputVectors& vectors, const std::string& name) {
  const double* const begin = vectors.array.data();
  const double* const end = begin + vectors.count * vectors.length;
  if (AreFinite(begin, end)) return;
  const double* const odd =
      std::find_if_not(begin, end, [](double x) { return std::isfinite(x); });
  throw py::value_error(
      fmt::format("{}: entry {} is {}; remove non-finite entries, for example "
                  "with numpy.isfinite()",
                  name, (odd - begin) / vectors.length, *odd));
}

}  // namespace

DoubleArray InputVectors::Like(const std::vector<py::ssize_t>& behind) const {
  std::vector<py::ssize_t> shape = axes;
  shape.insert(shape.end(), behind.begin(), behind.end());
  return DoubleArray(shape);
}

InputVectors ReadVectors(const py::object& given, int length,
                         const std::string& name) {
  py::array array = py::array::ensure(given);
  if (!array) {
    PyErr_Clear();
    throw py::type_error(name + ": expected an array of numbers");
  }
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    throw py::type_error(
        fmt::format("{}: expected an array of real numbers, not of dtype {}",
                    name, std::string(py::str(array.dtype()))));
  if (array.ndim() < 1 || array.shape(array.ndim() - 1) != length)
    throw py::value_error(fmt::format(
        "{}: expected an array of the shape (N, {}) or ({},), not {}", name,
        length, length, FormatShape(array)));
  InputVectors vectors;
  vectors.length = length;
  vectors.array =
      py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(
          array);
  vectors.axes.assign(array.shape(), array.shape() + array.ndim() - 1);
  vectors.count = static_cast<size_t>(array.size()) / length;
  RequireFinite(vectors, name);
  return vectors;
}

DoubleArray ReadOnlyVector(const double* values, size_t count) {
  DoubleArray array(static_cast<py::ssize_t>(count));
  std::copy(values, values + count, array.mutable_data());
  array.attr("setflags")(false);
  return array;
}

}  // namespace raygrid
