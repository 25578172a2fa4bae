#include <array>
#include <cstdarg>
#include <cstdio>

#include "atomic_file.h"
#include "frame_output.h"

namespace raygrid {
namespace {

class Header {
 public:
  [[gnu::format(printf, 2, 3)]] void Add(const char* format, ...) {
    va_list values;
    va_start(values, format);
    const int added = std::vsnprintf(text_.data() + size_, text_.size() - size_,
                                     format, values);
    va_end(values);
    if (added > 0) size_ += static_cast<size_t>(added);
  }
  const char* data() const { return text_.data(); }
  size_t size() const { return size_; }

 private:
  std::array<char, 1024> text_;  // sufficient for all fields
  size_t size_ = 0;
};

Header MakeHeader(const StreamFormat& format, const FrameInfo& info) {
  Header header;
  header.Add("raygrid_frame: 1\nformat: %s\nsize: [%u, %u]\n",
             format.pixel_format->name, format.width, format.height);
  header.Add("planes: [");
  for (int i = 0; i < format.num_planes; ++i)
    header.Add("%s%u", i == 0 ? "" : ", ",
               format.planes[i].row_bytes * format.planes[i].rows);
  header.Add("]\nsequence: %u\ntimestamp_ns: %llu\n", info.sequence,
             static_cast<unsigned long long>(info.timestamp_ns));
  if (info.crop)
    header.Add("crop: [%d, %d, %u, %u]\n", info.crop->x, info.crop->y,
               info.crop->width, info.crop->height);
  if (info.lens_position)
    header.Add("lens_position: %.6g\n", double{*info.lens_position});
  if (info.sensor_temperature_c)
    header.Add("sensor_temperature_c: %.6g\n",
               double{*info.sensor_temperature_c});
  header.Add("...\n");
  return header;
}

class RawFiles : public FrameOutput {
 public:
  RawFiles(const std::string& folder, const StreamFormat& format)
      : folder_(folder), format_(format) {
    MakeFolder(folder);
  }

  void Write(const UndistortedFrame& frame, uint64_t number) override {
    char path[PATH_MAX];
    std::snprintf(path, sizeof(path), "%s/frame-%06llu.raw", folder_.c_str(),
                  static_cast<unsigned long long>(number));
    const Header header = MakeHeader(format_, frame.info);
    AtomicFile file(path);
    file.Write(header.data(), header.size());
    file.Write(frame.bytes.data(), frame.bytes.size());
    file.Commit();
  }

 private:
  const std::string folder_;
  const StreamFormat format_;
};

}  // namespace

std::unique_ptr<FrameOutput> MakeRawFiles(const std::string& folder,
                                          const StreamFormat& format) {
  return std::make_unique<RawFiles>(folder, format);
}

}  // namespace raygrid
