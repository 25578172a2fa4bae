#ifndef RAYGRID_CAPTURE_KEPT_PICTURES_H
#define RAYGRID_CAPTURE_KEPT_PICTURES_H

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "stream_format.h"

namespace raygrid {

/// Small JPEGs of kept frames, of at most 320 pixels a side and 24 kB.
class KeptPictures {
 public:
  void Add(const std::string& name, const StreamFormat& format,
           const rg_image& image);
  /// Forgets those of a former list that this one has not.
  void KeepOnly(const std::vector<std::string>& names);
  /// Empty where there is none.
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

#endif  // RAYGRID_CAPTURE_KEPT_PICTURES_H
