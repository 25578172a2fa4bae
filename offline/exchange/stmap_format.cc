#include "exchange/stmap_format.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "dataset/error.h"
#include "dataset/image_header.h"
#include "dataset/text_encoding.h"
#include "exchange/exr.h"
#include "exchange/pixel_origin.h"

namespace raygrid {
namespace {

constexpr std::array<const char*, 4> kChannels = {"R", "G", "B", "A"};
using StPixel = std::array<float, kChannels.size()>;

// Returns the source position relative to the image size, measured from the
// lower left corner, and 1 if there is a source.
StPixel GetPixel(const ViewTable& view, int x, int y) {
  const auto source = view.At(x, y);
  if (!source) return {-1, -1, 0, 0};
  const Eigen::Vector2d at = ToProgram(PixelOrigin::kImageCorner, {}, *source);
  return {static_cast<float>(at.x() / view.source_size.width),
          static_cast<float>(1 - at.y() / view.source_size.height), 0, 1};
}

TableOutput WriteStMap(const ViewTable& view) {
  std::vector<float> numbers;
  numbers.reserve(view.sources.size() * kChannels.size());
  for (int y = 0; y < view.size.height; ++y)
    for (int x = 0; x < view.size.width; ++x)
      for (const float number : GetPixel(view, x, y)) numbers.push_back(number);
  return {{{view.path, WriteExr(view.size, {kChannels.begin(), kChannels.end()},
                                numbers)}},
          "s from the left, t from the bottom, alpha: valid pixels"};
}

// ---- Reading ---------------------------------------------------------------

constexpr char kExrMagic[] = "\x76\x2f\x31\x01";

bool IsExr(const std::string& bytes) {
  return bytes.compare(0, std::strlen(kExrMagic), kExrMagic) == 0;
}

// In-memory input stream for OpenEXR.
class ExrInput : public Imf::IStream {
 public:
  ExrInput(const std::string& path, const std::string& bytes)
      : Imf::IStream(path.c_str()), bytes_(bytes) {}
  bool read(char into[], int count) override {
    if (count < 0 || at_ > bytes_.size() ||
        static_cast<size_t>(count) > bytes_.size() - at_)
      throw InputError("the file is truncated");
    std::memcpy(into, bytes_.data() + at_, count);
    at_ += count;
    return at_ < bytes_.size();
  }
  uint64_t tellg() override { return at_; }
  void seekg(uint64_t at) override { at_ = at; }

 private:
  const std::string& bytes_;
  uint64_t at_ = 0;
};

// Returns the size of a pixel window. Throws if a file of num_bytes cannot
// contain it.
ImageSize GetWindowSize(const Imath::Box2i& window, size_t num_bytes) {
  constexpr int64_t kMaxPixelsPerByte = 1024;
  const int64_t width = int64_t{window.max.x} - window.min.x + 1,
                height = int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || height < 1) throw InputError("image size is zero");
  const std::string why = DescribeSizeLimit(static_cast<uint64_t>(width),
                                            static_cast<uint64_t>(height));
  if (!why.empty()) throw InputError(why);
  if (width * height > kMaxPixelsPerByte * static_cast<int64_t>(num_bytes))
    throw InputError(fmt::format("{} bytes are too few for {} x {} pixels",
                                 num_bytes, width, height));
  return {static_cast<int>(width), static_cast<int>(height)};
}

void RequireStChannels(const Imf::ChannelList& channels) {
  for (const char* name : {"R", "G"}) {
    const Imf::Channel* channel = channels.findChannel(name);
    if (!channel)
      throw InputError(fmt::format(
          "missing channel {}; an STMap has s in R and t in G", name));
    if (channel->xSampling != 1 || channel->ySampling != 1)
      throw InputError(
          fmt::format("channel {}: subsampling is not supported", name));
  }
}

// Reads the pixels of the file's data window; the alpha channel is optional.
std::vector<StPixel> ReadPixels(Imf::InputFile* file, const ImageSize& size) {
  RequireStChannels(file->header().channels());
  const Imath::Box2i& window = file->header().dataWindow();
  std::vector<StPixel> pixels(static_cast<size_t>(size.width) * size.height,
                              {-1, -1, 0, 1});
  Imf::FrameBuffer buffer;
  for (const size_t c : {0, 1, 3})
    buffer.insert(
        kChannels[c],
        Imf::Slice::Make(Imf::FLOAT, &pixels[0][c], window, sizeof(StPixel),
                         sizeof(StPixel) * size.width, 1, 1, c == 3 ? 1 : -1));
  file->setFrameBuffer(buffer);
  file->readPixels(window.min.y, window.max.y);
  return pixels;
}

// Whether a pixel has a source: partially transparent pixels mix neighbouring
// values, and programs fill undefined pixels with -1 or black.
bool HasPosition(const StPixel& pixel, bool has_alpha) {
  constexpr float kMinOpaqueAlpha = 0.999F;
  const auto [s, t, unused, alpha] = pixel;
  return std::isfinite(s) && std::isfinite(t) &&
         (!has_alpha || alpha >= kMinOpaqueAlpha) && !(s == -1 && t == -1) &&
         !(s == 0 && t == 0);
}

// Whether alpha is usable: a channel without any 1 contains no information.
bool HasAlpha(const std::vector<StPixel>& pixels) {
  return std::any_of(pixels.begin(), pixels.end(),
                     [](const StPixel& pixel) { return pixel[3] == 1; });
}

Eigen::Vector2d GetSourcePosition(const StPixel& pixel, const ImageSize& size) {
  return FromProgram(
      PixelOrigin::kImageCorner, {},
      {double{pixel[0]} * size.width, (1 - double{pixel[1]}) * size.height});
}

ViewTable ReadExrView(const std::string& path, const std::string& bytes,
                      const std::optional<ImageSize>& source_size) {
  ExrInput input(path, bytes);
  Imf::InputFile file(input);
  const Imath::Box2i &display_window = file.header().displayWindow(),
                     &stored = file.header().dataWindow();
  ViewTable view;
  view.path = path;
  view.size = GetWindowSize(display_window, bytes.size());
  view.source_size = source_size.value_or(view.size);
  const ImageSize stored_size = GetWindowSize(stored, bytes.size());
  const std::vector<StPixel> pixels = ReadPixels(&file, stored_size);
  const bool has_alpha = HasAlpha(pixels);
  view.sources.resize(view.num_pixels(), Eigen::Vector2d(NAN, NAN));
  size_t k = 0;
  for (int y = stored.min.y; y <= stored.max.y; ++y)
    for (int x = stored.min.x; x <= stored.max.x; ++x, ++k)
      if (display_window.intersects(Imath::V2i(x, y)) &&
          HasPosition(pixels[k], has_alpha))
        view.sources[static_cast<size_t>(y - display_window.min.y) *
                         view.size.width +
                     (x - display_window.min.x)] =
            GetSourcePosition(pixels[k], view.source_size);
  return view;
}

ViewTable ReadStMap(const std::string& path, const std::string& bytes,
                    const std::optional<ImageSize>& source_size) {
  try {
    return ReadExrView(path, bytes, source_size);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", path, error.what()));
  } catch (const std::exception& error) {  // thrown by OpenEXR
    throw InputError(fmt::format("{}: OpenEXR cannot read it: {}", path,
                                 Printable(error.what())));
  }
}

}  // namespace

TableFormat MakeStMapFormat() {
  TableFormat format;
  format.name = "stmap";
  format.holds = "compositing: STMap as .exr (--inverse: inverse remap)";
  format.endings = {".exr"};
  format.options = {"rectified", "inverse"};
  format.write_view = WriteStMap;
  format.recognizes = IsExr;
  format.read_view = ReadStMap;
  return format;
}

}  // namespace raygrid
