/// A blob in memory, and its tables.
#ifndef RAYGRID_GSTREAMER_BLOB_FILE_H
#define RAYGRID_GSTREAMER_BLOB_FILE_H

#include <cstdint>
#include <string>
#include <vector>

#include "caps.h"
#include "raygrid.h"

namespace raygrid {

/// An open blob. It stays where it is, since the camera reads it in place.
class BlobFile {
 public:
  /// Throws CameraError, which names the file.
  explicit BlobFile(const std::string& path);
  BlobFile(const BlobFile&) = delete;
  BlobFile& operator=(const BlobFile&) = delete;

  const rg_camera& camera() const { return camera_; }
  /// The sizes of all tables, or of the one of this index. Throws CameraError
  /// if there is none.
  std::vector<TableSizes> Tables(int table) const;
  /// Throws CameraError if no table takes frames of that size, or not the one
  /// of this index.
  void RequireTableFor(int table, int width, int height) const;
  /// Makes a table of these sizes the one in use: the one of this index, or the
  /// first one if it is -1. Throws CameraError if there is none.
  void SelectTable(int table, const TableSizes& sizes);
  /// Goes to a value of the stack's condition, or to the end of its range next
  /// to it. Throws CameraError if there is no stack.
  void SetCondition(double value);

 private:
  std::string path_;
  std::vector<uint32_t> words_;
  rg_camera camera_;
};

}  // namespace raygrid

#endif  // RAYGRID_GSTREAMER_BLOB_FILE_H
