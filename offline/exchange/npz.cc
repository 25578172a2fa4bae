#include "exchange/npz.h"

#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <regex>

#include "dataset/error.h"

namespace raygrid {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "numbers are written as they lie in memory");

// Returns the header of a .npy file: magic string, version 1.0, header length,
// and a Python dictionary padded to a multiple of 64 bytes.
std::string NpyHeader(const NpyArray& array) {
  constexpr size_t kMagicSize = 10, kAlignment = 64;
  std::string shape;
  for (const size_t length : array.shape) shape += fmt::format("{}, ", length);
  if (array.shape.size() > 1) shape.resize(shape.size() - 2);
  std::string text =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}",
                  array.type, shape);
  while ((kMagicSize + text.size() + 1) % kAlignment != 0) text += ' ';
  text += '\n';
  std::string magic("\x93NUMPY\x01\x00", kMagicSize - 2);
  magic += static_cast<char>(text.size() & 255);
  magic += static_cast<char>(text.size() >> 8);
  return magic + text;
}

[[noreturn]] void FailToZip(const char* why) {
  throw Error(ExitCode::kOutputFailed,
              fmt::format("cannot create the archive: {}", why));
}

struct DiscardZip {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
struct FreeSource {
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};
using Source = std::unique_ptr<zip_source_t, FreeSource>;

// Stores a file uncompressed like numpy.savez(), with the earliest timestamp
// of ZIP so that the result is reproducible.
void AddToZip(zip_t* archive, const std::string& name,
              const std::string& contents) {
  constexpr uint16_t kFirstDay = 1 << 5 | 1;  // 1 January 1980
  zip_source_t* source =
      zip_source_buffer(archive, contents.data(), contents.size(), 0);
  if (!source) FailToZip(zip_strerror(archive));
  const zip_int64_t index =
      zip_file_add(archive, name.c_str(), source, ZIP_FL_ENC_UTF_8);
  if (index < 0) {
    zip_source_free(source);
    FailToZip(zip_strerror(archive));
  }
  if (zip_set_file_compression(archive, index, ZIP_CM_STORE, 0) < 0 ||
      zip_file_set_dostime(archive, index, 0, kFirstDay, 0) < 0)
    FailToZip(zip_strerror(archive));
}

std::string ReadEntry(zip_source_t* source) {
  zip_stat_t entry_info;
  if (zip_source_stat(source, &entry_info) < 0 || zip_source_open(source) < 0)
    FailToZip(zip_error_strerror(zip_source_error(source)));
  std::string bytes(entry_info.size, '\0');
  const zip_int64_t count = zip_source_read(source, bytes.data(), bytes.size());
  zip_source_close(source);
  if (count != static_cast<zip_int64_t>(bytes.size()))
    FailToZip("incomplete write");
  return bytes;
}

// ---- Reading ---------------------------------------------------------------

[[noreturn]] void FailToUnzip(const std::string& name, const std::string& why) {
  throw InputError(
      fmt::format("{}: cannot be read from the archive: {}", name, why));
}

// Decompresses a file in chunks, because its declared size may be wrong.
std::string UnzipEntry(zip_t* archive, zip_int64_t index,
                       const std::string& name) {
  constexpr size_t kChunk = 1 << 20;
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(
      zip_fopen_index(archive, index, 0), zip_fclose);
  if (!file) FailToUnzip(name, zip_strerror(archive));
  std::string bytes;
  while (true) {
    const size_t size = bytes.size();
    bytes.resize(size + kChunk);
    const zip_int64_t count =
        zip_fread(file.get(), bytes.data() + size, kChunk);
    if (count < 0) FailToUnzip(name, zip_file_strerror(file.get()));
    bytes.resize(size + count);
    if (count == 0) return bytes;
  }
}

// Parses the text of a Python tuple: "480, 640, 3" or "7,".
std::vector<size_t> ParseShape(const std::string& name,
                               const std::string& text) {
  std::vector<size_t> shape;
  static const std::regex number("\\d+");
  for (std::sregex_iterator at(text.begin(), text.end(), number), end;
       at != end; ++at) {
    const std::string digits = at->str();
    size_t length = 0;
    const auto result =
        std::from_chars(digits.data(), digits.data() + digits.size(), length);
    if (result.ec != std::errc())
      throw InputError(name + ": invalid array shape");
    shape.push_back(length);
  }
  return shape;
}

// Returns the element size of a type in bytes; 0 for unsupported types.
size_t GetTypeSize(const std::string& type) {
  for (const char* known : {"<f4", "<f8", "<i2", "<u2", "<i4", "<u4", "<i8"})
    if (type == known) return static_cast<size_t>(type[2] - '0');
  return 0;
}

void RequireComplete(const NpyArray& array) {
  size_t left = array.bytes.size();
  const size_t size = GetTypeSize(array.type);
  if (size == 0)
    throw InputError(
        fmt::format("{}: unsupported dtype '{}'; save it as float64",
                    array.name, array.type));
  bool is_complete = left % size == 0;
  left /= size;
  for (const size_t length : array.shape) {
    is_complete = is_complete && length > 0 && left % length == 0;
    if (is_complete) left /= length;
  }
  if (!is_complete || left != 1)
    throw InputError(array.name +
                     ": the amount of data does not match its shape");
}

NpyArray ParseNpy(const std::string& name, const std::string& file,
                  bool may_be_other) {
  // Magic string, version, and header length: two bytes in version 1, otherwise
  // four.
  const size_t num_length_bytes = file.size() > 6 && file[6] == 1 ? 2 : 4;
  const size_t begin = 8 + num_length_bytes;
  if (file.rfind("\x93NUMPY", 0) != 0 || file.size() < begin)
    throw InputError(name + ": not a numpy array");
  size_t length = 0;
  for (size_t k = 0; k < num_length_bytes; ++k)
    length |= static_cast<size_t>(static_cast<uint8_t>(file[8 + k])) << 8 * k;
  constexpr size_t kLongest = 4096;
  if (length > kLongest || length > file.size() - begin)
    throw InputError(name + ": the header is truncated or too long");
  const std::string header = file.substr(begin, length);
  static const std::regex type("'descr': *'([^']*)'"),
      order("'fortran_order': *(True|False)"), shape("'shape': *\\(([^)]*)\\)");
  std::smatch found_type, found_order, found_shape;
  if (may_be_other && (!std::regex_search(header, found_type, type) ||
                       GetTypeSize(found_type[1]) == 0))
    return {name, found_type.empty() ? "" : found_type[1].str(), {}, ""};
  if (!std::regex_search(header, found_type, type) ||
      !std::regex_search(header, found_order, order) ||
      !std::regex_search(header, found_shape, shape))
    throw InputError(name + ": the header has no numeric dtype and shape");
  NpyArray array = {name, found_type[1], ParseShape(name, found_shape[1]),
                    file.substr(begin + length)};
  if (found_order[1] == "True" && array.shape.size() > 1)
    throw InputError(name +
                     ": Fortran order is not supported; save "
                     "numpy.ascontiguousarray() of it");
  RequireComplete(array);
  return array;
}

template <typename Number>
std::vector<double> ConvertToDouble(const NpyArray& array) {
  std::vector<double> numbers(array.bytes.size() / sizeof(Number));
  for (size_t k = 0; k < numbers.size(); ++k) {
    Number number;
    std::memcpy(&number, &array.bytes[k * sizeof(Number)], sizeof(Number));
    numbers[k] = static_cast<double>(number);
  }
  return numbers;
}

}  // namespace

std::string WriteNpz(const std::vector<NpyArray>& arrays) {
  std::vector<std::string> contents;
  for (const NpyArray& array : arrays)
    contents.push_back(NpyHeader(array) + array.bytes);
  zip_error_t error;
  zip_error_init(&error);
  const Source source(zip_source_buffer_create(nullptr, 0, 0, &error));
  if (!source) FailToZip(zip_error_strerror(&error));
  std::unique_ptr<zip_t, DiscardZip> archive(
      zip_open_from_source(source.get(), ZIP_TRUNCATE, &error));
  if (!archive) FailToZip(zip_error_strerror(&error));
  zip_source_keep(source.get());  // closing the archive releases its reference
  for (size_t k = 0; k < arrays.size(); ++k)
    AddToZip(archive.get(), arrays[k].name + ".npy", contents[k]);
  if (zip_close(archive.get()) < 0) FailToZip(zip_strerror(archive.get()));
  archive.release();
  return ReadEntry(source.get());
}

bool IsNpz(const std::string& bytes) {
  return bytes.rfind("PK\x03\x04", 0) == 0;
}

std::vector<NpyArray> ReadNpz(const std::string& bytes, bool may_have_others) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source =
      zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  if (!source) FailToUnzip("it", zip_error_strerror(&error));
  const std::unique_ptr<zip_t, DiscardZip> archive(
      zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, &error));
  if (!archive) {
    zip_source_free(source);
    throw InputError(fmt::format("not a complete archive of numpy.savez(): {}",
                                 zip_error_strerror(&error)));
  }
  const std::string ending = ".npy";
  std::vector<NpyArray> arrays;
  for (zip_int64_t k = 0; k < zip_get_num_entries(archive.get(), 0); ++k) {
    const char* file = zip_get_name(archive.get(), k, 0);
    std::string name = file ? file : "";
    if (name.size() <= ending.size() ||
        name.compare(name.size() - ending.size(), ending.size(), ending) != 0)
      continue;
    name.resize(name.size() - ending.size());
    arrays.push_back(
        ParseNpy(name, UnzipEntry(archive.get(), k, name), may_have_others));
  }
  return arrays;
}

std::vector<double> NpyNumbers(const NpyArray& array) {
  using Convert = std::vector<double> (*)(const NpyArray&);
  static const std::pair<const char*, Convert> kinds[] = {
      {"<f4", ConvertToDouble<float>},   {"<f8", ConvertToDouble<double>},
      {"<i2", ConvertToDouble<int16_t>}, {"<u2", ConvertToDouble<uint16_t>},
      {"<i4", ConvertToDouble<int32_t>}, {"<u4", ConvertToDouble<uint32_t>},
      {"<i8", ConvertToDouble<int64_t>}};
  for (const auto& [type, convert] : kinds)
    if (array.type == type) return convert(array);
  throw InputError(array.name + ": unsupported dtype");
}

}  // namespace raygrid
