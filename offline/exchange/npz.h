#ifndef RAYGRID_EXCHANGE_NPZ_H
#define RAYGRID_EXCHANGE_NPZ_H

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace raygrid {

/// A numpy array.
struct NpyArray {
  std::string name;
  std::string type;  ///< "<f4": byte order, kind, size
  std::vector<size_t> shape;
  std::string bytes;  ///< row-major (C order)
};

namespace npz_internal {
inline const char* TypeName(float) { return "<f4"; }
inline const char* TypeName(double) { return "<f8"; }
inline const char* TypeName(int16_t) { return "<i2"; }
inline const char* TypeName(uint16_t) { return "<u2"; }
inline const char* TypeName(int32_t) { return "<i4"; }
inline const char* TypeName(uint32_t) { return "<u4"; }
inline const char* TypeName(int64_t) { return "<i8"; }
}  // namespace npz_internal

/// Makes an array of a shape from the numbers at `values`.
template <typename Number>
NpyArray MakeNpyArray(const std::string& name, std::vector<size_t> shape,
                      const Number* values) {
  size_t count = 1;
  for (const size_t length : shape) count *= length;
  return {name, npz_internal::TypeName(Number()), std::move(shape),
          std::string(reinterpret_cast<const char*>(values),
                      count * sizeof(Number))};
}

/// Formats an archive as numpy.savez() does, but reproducibly.
std::string WriteNpz(const std::vector<NpyArray>& arrays);

/// Returns whether bytes begin as a ZIP archive.
bool IsNpz(const std::string& bytes);

/// Reads the arrays of an archive of numpy.savez() or savez_compressed(), in C
/// order. Throws InputError without the file's name if the archive is
/// malformed. Arrays of types without a TypeName(), such as strings, are also
/// errors, or, with may_have_others, returned without shape and bytes.
std::vector<NpyArray> ReadNpz(const std::string& bytes,
                              bool may_have_others = false);

/// Returns the numbers of an array of a type with a TypeName(). Throws
/// InputError for other types.
std::vector<double> NpyNumbers(const NpyArray& array);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_NPZ_H
