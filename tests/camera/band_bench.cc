// The time of a frame by one thread and by several.
//   band_bench BLOB [THREADS]
// Takes the blob's first table, and all processors unless THREADS are told.
// Each round undistorts ten frames by rg_remap() and then ten by the threads,
// as caches then hold what they hold while a camera runs; the medians of 31
// rounds and their ratio are printed. The bytes are compared.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

#include "band_remap.h"

namespace raygrid {
namespace {

constexpr int kRounds = 31, kFrames = 10;

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + kRounds / 2, values.end());
  return values[kRounds / 2];
}

// A frame's planes one behind the other.
struct Frame {
  explicit Frame(const StreamFormat& layout) : bytes(layout.packed_size()) {
    uint8_t* next = bytes.data();
    for (int i = 0; i < layout.num_planes; ++i) {
      planes[i] = next;
      next += size_t{layout.planes[i].row_bytes} * layout.planes[i].rows;
    }
  }

  std::vector<uint8_t> bytes;
  uint8_t* planes[3] = {};
};

rg_target TargetIn(const StreamFormat& layout, Frame* frame) {
  rg_target target = {};
  target.num_rows = layout.height;
  target.kernels = rg_find_kernels(nullptr);
  SetBlackBorder(layout, &target);
  for (int i = 0; i < layout.num_planes; ++i) {
    target.planes[i].data = frame->planes[i];
    target.planes[i].stride = layout.planes[i].stride;
  }
  return target;
}

bool Measure(const rg_camera& camera, const char* name, BandRemap* bands) {
  uint16_t width, height, view_width, view_height;
  rg_frame_size(&camera, &width, &height);
  rg_remap_size(&camera, &view_width, &view_height);
  const PixelFormatInfo& pixel_format = *FindPixelFormat(name);
  const StreamFormat frames = MakeStreamFormat(pixel_format, width, height, 0);
  const StreamFormat views =
      MakeStreamFormat(pixel_format, view_width, view_height, 0);
  Frame source(frames), alone(views), shared(views);
  for (size_t k = 0; k < source.bytes.size(); ++k)
    source.bytes[k] = static_cast<uint8_t>(k * 2654435761u >> 24);
  const rg_image image = MakeImage(frames, source.planes);
  const rg_target by_one = TargetIn(views, &alone);
  const rg_target by_all = TargetIn(views, &shared);
  std::vector<double> one_ms, all_ms;
  using Clock = std::chrono::steady_clock;
  const auto frame_ms = [](Clock::duration time) {
    return std::chrono::duration<double, std::milli>(time).count() / kFrames;
  };
  for (int k = 0; k < kRounds; ++k) {
    const auto start = Clock::now();
    for (int f = 0; f < kFrames; ++f)
      if (rg_remap(&camera, &image, &by_one) != RG_OK) return false;
    const auto middle = Clock::now();
    for (int f = 0; f < kFrames; ++f)
      if (bands->Remap(camera, image, views, by_all) != RG_OK) return false;
    one_ms.push_back(frame_ms(middle - start));
    all_ms.push_back(frame_ms(Clock::now() - middle));
  }
  std::printf(
      "%-8s %ux%u: 1 thread %.3f ms, %u threads %.3f ms, %.2f times as "
      "fast%s\n",
      name, view_width, view_height, Median(one_ms), bands->num_threads(),
      Median(all_ms), Median(one_ms) / Median(all_ms),
      alone.bytes == shared.bytes ? "" : ", OTHER BYTES");
  return alone.bytes == shared.bytes;
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  if (argc < 2) return 1;
  std::ifstream file(argv[1], std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  rg_camera camera;
  if (rg_camera_open(&camera, bytes.data(),
                     static_cast<uint32_t>(bytes.size())) != RG_OK ||
      rg_select_remap(&camera, 0) != RG_OK) {
    std::fprintf(stderr, "%s: no blob with a table\n", argv[1]);
    return 1;
  }
  raygrid::BandRemap bands(argc > 2 ? static_cast<unsigned>(std::atoi(argv[2]))
                                    : 0);
  bool is_good = true;
  for (const char* name : {"R8", "NV12", "YUYV", "RGB888", "XRGB8888"})
    is_good = raygrid::Measure(camera, name, &bands) && is_good;
  return is_good ? 0 : 1;
}
