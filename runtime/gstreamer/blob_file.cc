#include "blob_file.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

#include "camera_error.h"
#include "stream_guard.h"

namespace raygrid {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

std::vector<uint32_t> ReadWords(const std::string& path, uint32_t* num_bytes) {
  constexpr size_t kMaxBytes = 1u << 30;
  const auto fail = [&path](const std::string& why) {
    return CameraError(CameraExit::kInput, path + ": " + why);
  };
  const File file(std::fopen(path.c_str(), "rbe"), &std::fclose);
  struct stat status;
  if (!file || fstat(fileno(file.get()), &status) != 0)
    throw fail(std::string("cannot be read (") + std::strerror(errno) + ")");
  if (!S_ISREG(status.st_mode)) throw fail("not a regular file");
  const auto size = static_cast<size_t>(status.st_size);
  if (size > kMaxBytes) throw fail("larger than 1 GiB, not a blob");
  std::vector<uint32_t> words((size + 3) / 4);
  if (std::fread(words.data(), 1, size, file.get()) != size)
    throw fail("cannot be read completely");
  *num_bytes = static_cast<uint32_t>(size);
  return words;
}

TableSizes SizesInUse(const rg_camera& camera) {
  TableSizes sizes = {};
  rg_frame_size(&camera, &sizes.frame_width, &sizes.frame_height);
  rg_remap_size(&camera, &sizes.view_width, &sizes.view_height);
  return sizes;
}

std::string Text(unsigned width, unsigned height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// Returns the sizes of frames and views as text, such as "1280x960 to 640x480,
// 640x480 to 320x240".
std::string Text(const std::vector<TableSizes>& tables) {
  std::string text;
  for (const TableSizes& sizes : tables)
    text += (text.empty() ? "" : ", ") +
            Text(sizes.frame_width, sizes.frame_height) + " to " +
            Text(sizes.view_width, sizes.view_height);
  return text;
}

// Describes the sizes of one table, or of all tables if `table` is negative.
std::string WhatIsMade(int table, const std::vector<TableSizes>& tables) {
  if (table >= 0)
    return "table " + std::to_string(table) + " undistorts " + Text(tables);
  return (tables.size() == 1 ? "its remap table undistorts "
                             : "its remap tables undistort ") +
         Text(tables);
}

// Returns the remedy for frames or views of other sizes.
std::string Remedy(int table) {
  return table >= 0 ? "; omit table to use the first matching one, or add one "
                      "with raygrid pack --remap"
                    : "; add a matching table with raygrid pack --remap (and "
                      "--mode for another frame size)";
}

}  // namespace

BlobFile::BlobFile(const std::string& path) : path_(path) {
  uint32_t num_bytes = 0;
  words_ = ReadWords(path, &num_bytes);
  const rg_status status = rg_camera_open(&camera_, words_.data(), num_bytes);
  if (status != RG_OK)
    throw CameraError(CameraExit::kBlob, path + ": " + rg_status_text(status));
}

std::vector<TableSizes> BlobFile::Tables(int table) const {
  std::vector<TableSizes> tables;
  rg_camera camera = camera_;
  for (uint32_t k = 0; rg_select_remap(&camera, k) == RG_OK; ++k)
    if (table < 0 || k == static_cast<uint32_t>(table))
      tables.push_back(SizesInUse(camera));
  if (tables.empty())
    throw CameraError(CameraExit::kBlob,
                      path_ + ": " +
                          DescribeTableFault(camera_, static_cast<uint32_t>(
                                                          std::max(table, 0))));
  return tables;
}

void BlobFile::RequireTableFor(int table, int width, int height) const {
  const std::vector<TableSizes> tables = Tables(table);
  for (const TableSizes& sizes : tables)
    if (sizes.frame_width == width && sizes.frame_height == height) return;
  throw CameraError(
      CameraExit::kBlob,
      path_ + ": " + WhatIsMade(table, tables) + ", but frames are " +
          Text(static_cast<unsigned>(width), static_cast<unsigned>(height)) +
          Remedy(table));
}

void BlobFile::SelectTable(int table, const TableSizes& sizes) {
  for (uint32_t k = 0; rg_select_remap(&camera_, k) == RG_OK; ++k)
    if ((table < 0 || k == static_cast<uint32_t>(table)) &&
        SizesInUse(camera_) == sizes)
      return;
  throw CameraError(CameraExit::kBlob,
                    path_ + ": " + WhatIsMade(table, Tables(table)) + ", but " +
                        Text({sizes}) + " was requested" + Remedy(table));
}

void BlobFile::SetOperatingPoint(double value) {
  constexpr double kMost = 32767;  // limit of q16 values
  const double q16 = std::clamp(value, -kMost, kMost) * 65536;
  const rg_status status =
      rg_set_operating_point(&camera_, static_cast<int32_t>(std::lround(q16)));
  if (status != RG_OK && status != RG_EXTRAPOLATED)
    throw CameraError(
        CameraExit::kBlob,
        path_ + ": operating point: " + rg_status_text(status) +
            "; calibrate over a range with raygrid calibrate --vary-with");
}

}  // namespace raygrid
