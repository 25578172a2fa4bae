#include "exchange/stmap_format.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>

#include <array>

#include "exchange/pixel_origin.h"

namespace raygrid {
namespace {

// A file in memory, which OpenEXR writes in several places.
class ExrBytes : public Imf::OStream {
 public:
  ExrBytes() : Imf::OStream("STMap") {}
  void write(const char bytes[], int count) override {
    if (at_ + count > bytes_.size()) bytes_.resize(at_ + count);
    bytes_.replace(at_, count, bytes, count);
    at_ += count;
  }
  uint64_t tellp() override { return at_; }
  void seekp(uint64_t at) override { at_ = at; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  size_t at_ = 0;
};

constexpr std::array<const char*, 4> kChannels = {"R", "G", "B", "A"};
using StPixel = std::array<float, kChannels.size()>;

// The source as a part of the image's width and height, from its lower left
// corner on, and whether there is one.
StPixel PixelOf(const ViewTable& view, int x, int y) {
  const auto source = view.At(x, y);
  if (!source) return {-1, -1, 0, 0};
  const Eigen::Vector2d at = ToProgram(PixelOrigin::kImageCorner, {}, *source);
  return {static_cast<float>(at.x() / view.source_size.width),
          static_cast<float>(1 - at.y() / view.source_size.height), 0, 1};
}

std::string ExrOf(const ImageSize& size, const std::vector<StPixel>& pixels) {
  Imf::Header header(size.width, size.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer buffer;
  char* const first =
      reinterpret_cast<char*>(const_cast<StPixel*>(pixels.data()));
  for (size_t c = 0; c < kChannels.size(); ++c) {
    header.channels().insert(kChannels[c], Imf::Channel(Imf::FLOAT));
    buffer.insert(kChannels[c],
                  Imf::Slice(Imf::FLOAT, first + c * sizeof(float),
                             sizeof(StPixel), sizeof(StPixel) * size.width));
  }
  ExrBytes bytes;
  {
    Imf::OutputFile file(bytes, header);
    file.setFrameBuffer(buffer);
    file.writePixels(size.height);
  }  // which completes the file
  return bytes.bytes();
}

TableOutput WriteStMap(const ViewTable& view) {
  std::vector<StPixel> pixels;
  pixels.reserve(view.sources.size());
  for (int y = 0; y < view.size.height; ++y)
    for (int x = 0; x < view.size.width; ++x)
      pixels.push_back(PixelOf(view, x, y));
  return {{{view.path, ExrOf(view.size, pixels)}},
          "s from the left, t from below, alpha where there is a source"};
}

}  // namespace

TableFormat StMapFormat() {
  TableFormat format;
  format.name = "stmap";
  format.holds =
      "compositing: the STMap of a view, or with --reverse of the camera, in "
      ".exr";
  format.endings = {".exr"};
  format.options = {"rectified", "reverse"};
  format.write_view = WriteStMap;
  return format;
}

}  // namespace raygrid
