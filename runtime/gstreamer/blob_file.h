/// A blob file in memory, and its remap tables.
#ifndef RAYGRID_GSTREAMER_BLOB_FILE_H
#define RAYGRID_GSTREAMER_BLOB_FILE_H

#include <cstdint>
#include <string>
#include <vector>

#include "caps.h"
#include "raygrid.h"

namespace raygrid {

/// An open blob. Not movable, because the camera points into its memory.
class BlobFile {
 public:
  /// Throws CameraError, with the file name.
  explicit BlobFile(const std::string& path);
  BlobFile(const BlobFile&) = delete;
  BlobFile& operator=(const BlobFile&) = delete;

  const rg_camera& camera() const { return camera_; }
  /// Returns the sizes of all tables, or of the one with this index. Throws
  /// CameraError if it does not exist.
  std::vector<TableSizes> Tables(int table) const;
  /// Throws CameraError if no table, or not the one with this index, is for
  /// frames of this size.
  void RequireTableFor(int table, int width, int height) const;
  /// Selects a table of these sizes: the one with this index, or the first if
  /// it is -1. Throws CameraError if it does not exist.
  void SelectTable(int table, const TableSizes& sizes);
  /// Sets the operating point, clamped to its range. Throws CameraError if the
  /// blob has no operating-point model.
  void SetOperatingPoint(double value);

 private:
  std::string path_;
  std::vector<uint32_t> words_;
  rg_camera camera_;
};

}  // namespace raygrid

#endif  // RAYGRID_GSTREAMER_BLOB_FILE_H
