#include "thumbnail_store.h"

#include <set>
#include <utility>

#include "downscaled_jpeg.h"

namespace raygrid {
namespace {

constexpr int kMaxThumbnailSidePx = 320;
constexpr size_t kMaxThumbnailBytes = 24 * 1024;

}  // namespace

void ThumbnailStore::Add(const std::string& name, const StreamFormat& format,
                         const rg_image& image) {
  DownscaledJpegEncoder smaller;
  std::vector<uint8_t> jpeg;
  // Downscaling reduces noise, and thereby the size of the JPEG file.
  for (int side = kMaxThumbnailSidePx; side > 1; side /= 2) {
    jpeg = smaller.Encode(format, image, side);
    if (jpeg.size() <= kMaxThumbnailBytes) break;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  pictures_[name] = {std::move(jpeg), false};
}

void ThumbnailStore::KeepOnly(const std::vector<std::string>& names) {
  const std::set<std::string> listed(names.begin(), names.end());
  const std::lock_guard<std::mutex> lock(mutex_);
  for (auto i = pictures_.begin(); i != pictures_.end();) {
    const bool is_listed = listed.count(i->first) > 0;
    if (i->second.is_listed && !is_listed) {
      i = pictures_.erase(i);
    } else {
      i->second.is_listed = is_listed;
      ++i;
    }
  }
}

std::vector<uint8_t> ThumbnailStore::Find(const std::string& name) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = pictures_.find(name);
  return found == pictures_.end() ? std::vector<uint8_t>() : found->second.jpeg;
}

}  // namespace raygrid
