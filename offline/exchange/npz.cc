#include "exchange/npz.h"

#include <fmt/format.h>
#include <zip.h>

#include <memory>

#include "dataset/error.h"

namespace raygrid {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "numbers are written as they lie in memory");

// Numpy's header before the numbers: a magic word, version 1.0, its length, and
// a dictionary of Python that ends at a multiple of 64.
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
  throw Error(ExitCode::kOutput,
              fmt::format("the archive cannot be made in memory: {}", why));
}

struct DiscardZip {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
struct FreeSource {
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};
using Source = std::unique_ptr<zip_source_t, FreeSource>;

// Stored as numpy.savez() does, at the first time that an archive knows.
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

std::string ReadWhole(zip_source_t* source) {
  zip_stat_t facts;
  if (zip_source_stat(source, &facts) < 0 || zip_source_open(source) < 0)
    FailToZip(zip_error_strerror(zip_source_error(source)));
  std::string bytes(facts.size, '\0');
  const zip_int64_t count = zip_source_read(source, bytes.data(), bytes.size());
  zip_source_close(source);
  if (count != static_cast<zip_int64_t>(bytes.size())) FailToZip("it was cut");
  return bytes;
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
  zip_source_keep(source.get());  // the archive's end frees it once
  for (size_t k = 0; k < arrays.size(); ++k)
    AddToZip(archive.get(), arrays[k].name + ".npy", contents[k]);
  if (zip_close(archive.get()) < 0) FailToZip(zip_strerror(archive.get()));
  archive.release();
  return ReadWhole(source.get());
}

}  // namespace raygrid
