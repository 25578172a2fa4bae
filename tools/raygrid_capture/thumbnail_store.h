#ifndef RAYGRID_CAPTURE_THUMBNAIL_STORE_H
#define RAYGRID_CAPTURE_THUMBNAIL_STORE_H

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "stream_format.h"

namespace raygrid {

/// Thumbnails of kept frames: JPEGs of at most 320 pixels per side and 24 kB.
class ThumbnailStore {
 public:
  void Add(const std::string& name, const StreamFormat& format,
           const rg_image& image);
  /// Discards thumbnails of all other names.
  void KeepOnly(const std::vector<std::string>& names);
  /// Returns a thumbnail; empty if it does not exist.
  std::vector<uint8_t> Find(const std::string& name) const;

 private:
  struct Kept {
    std::vector<uint8_t> jpeg;
    bool is_listed = false;
  };
  mutable std::mutex mutex_;
  std::map<std::string, Kept> pictures_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_THUMBNAIL_STORE_H
