#include "simulation/observation_lines.h"

#include <fmt/format.h>

namespace raygrid {
namespace {

constexpr int kColumns = 33, kRows = 25;

std::string FormatLine(const ObservationLine& line) {
  const Eigen::Vector3d d = line.direction.normalized();
  const Eigen::Vector3d& o = line.origin;
  return fmt::format("{:.15f},{:.15f},{:.15f},{:.15f},{:.15f},{:.15f}", d.x(),
                     d.y(), d.z(), o.x(), o.y(), o.z());
}

}  // namespace

std::string FormatObservationLines(const CameraModel& camera) {
  const ImageSize& size = camera.image_size();
  std::string text =
      "# The observation line of pixel (x, y): points (ox, oy, oz) + t (dx, "
      "dy, dz), t > 0, in metres.\n"
      "x,y,dx,dy,dz,ox,oy,oz\n";
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Eigen::Vector2d pixel(column * (size.width - 1.0) / (kColumns - 1),
                                  row * (size.height - 1.0) / (kRows - 1));
      const auto line = camera.Line(pixel);
      text += fmt::format("{:.17g},{:.17g},{}\n", pixel.x(), pixel.y(),
                          line ? FormatLine(*line) : ",,,,,");
    }
  }
  return text;
}

}  // namespace raygrid
