#include "kept_pictures.h"

#include <set>
#include <utility>

#include "smaller_picture.h"

namespace raygrid {
namespace {

constexpr int kMaxKeptSide = 320;
constexpr size_t kMaxKeptSize = 24 * 1024;

}  // namespace

void KeptPictures::Add(const std::string& name, const StreamFormat& format,
                       const rg_image& image) {
  SmallerPicture smaller;
  std::vector<uint8_t> jpeg;
  // Downscaling reduces noise, and thereby the size of the JPEG file.
  for (int side = kMaxKeptSide; side > 1; side /= 2) {
    jpeg = smaller.Encode(format, image, side);
    if (jpeg.size() <= kMaxKeptSize) break;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  pictures_[name] = {std::move(jpeg), false};
}

void KeptPictures::KeepOnly(const std::vector<std::string>& names) {
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

std::vector<uint8_t> KeptPictures::Find(const std::string& name) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = pictures_.find(name);
  return found == pictures_.end() ? std::vector<uint8_t>() : found->second.jpeg;
}

}  // namespace raygrid
