#ifndef RAYGRID_EXCHANGE_NPZ_H
#define RAYGRID_EXCHANGE_NPZ_H

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace raygrid {

/// An array of numpy.
struct NpyArray {
  std::string name;
  std::string type;  ///< "<f4": the order of bytes, the kind, the size
  std::vector<size_t> shape;
  std::string bytes;  ///< the last index runs first
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

/// An array of the numbers at values, as many as the shape has.
template <typename Number>
NpyArray MakeNpyArray(const std::string& name, std::vector<size_t> shape,
                      const Number* values) {
  size_t count = 1;
  for (const size_t length : shape) count *= length;
  return {name, npz_internal::TypeName(Number()), std::move(shape),
          std::string(reinterpret_cast<const char*>(values),
                      count * sizeof(Number))};
}

/// A file of numpy.savez() with these arrays, the same bytes at any time.
std::string WriteNpz(const std::vector<NpyArray>& arrays);

/// Whether bytes begin as an archive.
bool IsNpz(const std::string& bytes);

/// The arrays of a file of numpy.savez() or numpy.savez_compressed(), in the
/// order of C. Throws InputError without the file's name; also for arrays of
/// other types than TypeName() has, such as texts, or if they may be in it,
/// returns these without their shape and bytes.
std::vector<NpyArray> ReadNpz(const std::string& bytes,
                              bool may_have_others = false);

/// The numbers of an array of any type that TypeName() has. Throws InputError
/// for other types.
std::vector<double> NpyNumbers(const NpyArray& array);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_NPZ_H
