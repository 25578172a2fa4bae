#include "exchange/ffmpeg_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "exchange/pixel_origin.h"

namespace raygrid {
namespace {

// Position outside any image, where ffmpeg inserts the fill colour.
constexpr uint16_t kInvalidPosition = 65535;

// Returns the column or row of the nearest pixel.
uint16_t ComputeNearestIndex(double position, int count) {
  return static_cast<uint16_t>(std::clamp<long>(
      std::lround(position), 0, std::min<long>(count, kInvalidPosition) - 1));
}

void AppendSample(uint16_t sample, std::string* pgm) {
  *pgm += static_cast<char>(sample >> 8);
  *pgm += static_cast<char>(sample & 255);
}

// Returns the path of one axis's map: "front_x.pgm" in the folder of
// "front.pgm".
std::string MakeAxisPath(const std::filesystem::path& path, char axis) {
  return (path.parent_path() /
          fmt::format("{}_{}.pgm", path.stem().string(), axis))
      .string();
}

TableOutput WriteFfmpeg(const ViewTable& view) {
  std::string x_map =
      fmt::format("P5\n{} {}\n65535\n", view.size.width, view.size.height);
  std::string y_map = x_map;
  for (int y = 0; y < view.size.height; ++y)
    for (int x = 0; x < view.size.width; ++x) {
      const auto source = view.At(x, y);
      const Eigen::Vector2d at =
          source ? ToProgram(PixelOrigin::kFirstPixelCenter, {}, *source)
                 : Eigen::Vector2d(0, 0);
      AppendSample(source ? ComputeNearestIndex(at.x(), view.source_size.width)
                          : kInvalidPosition,
                   &x_map);
      AppendSample(source ? ComputeNearestIndex(at.y(), view.source_size.height)
                          : kInvalidPosition,
                   &y_map);
    }
  const std::string x_path = MakeAxisPath(view.path, 'x'),
                    y_path = MakeAxisPath(view.path, 'y');
  return {
      {{x_path, x_map}, {y_path, y_map}},
      fmt::format("{} and {}, rounded to pixels: error up to 0.5 px per axis",
                  x_path, y_path)};
}

}  // namespace

TableFormat MakeFfmpegFormat() {
  TableFormat format;
  format.name = "ffmpeg";
  format.holds =
      "remap filter of ffmpeg: NAME_x.pgm and NAME_y.pgm, rounded to pixels "
      "(--inverse: inverse remap)";
  format.endings = {".pgm"};
  format.options = {"rectified", "inverse"};
  format.write_view = WriteFfmpeg;
  return format;
}

}  // namespace raygrid
