#include "fleet/fleet_input.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "dataset/camera_file.h"

namespace raygrid {
namespace {

// Returns the directions of a grid of pixels.
std::vector<Eigen::Vector3d> SampleDirections(const CameraModel& camera) {
  constexpr int kColumns = 9, kRows = 7;
  const ImageSize size = camera.image_size();
  std::vector<Eigen::Vector3d> directions;
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kColumns; ++i) {
      const Eigen::Vector2d pixel((i + 0.5) / kColumns * size.width - 0.5,
                                  (j + 0.5) / kRows * size.height - 0.5);
      if (const auto ray = camera.Unproject(pixel)) directions.push_back(*ray);
    }
  return directions;
}

std::vector<std::optional<Eigen::Vector2d>> ProjectDirections(
    const CameraModel& camera, const std::vector<Eigen::Vector3d>& directions) {
  std::vector<std::optional<Eigen::Vector2d>> pixels;
  for (const Eigen::Vector3d& direction : directions)
    pixels.push_back(camera.Project(direction));
  return pixels;
}

// Returns a metric that is charted by itself; the others follow from the
// camera.
FleetMetric MakeIndependentMetric(const std::string& name, bool is_positive,
                                  const std::vector<UnitRow>& rows,
                                  const std::vector<size_t>& compared) {
  FleetMetric metric{name, {}, is_positive};
  for (const size_t row : compared) {
    const auto found = rows[row].metrics.find(name);
    metric.values.push_back(found == rows[row].metrics.end() ? std::nan("")
                                                             : found->second);
  }
  return metric;
}

}  // namespace

ComparedUnits CompareUnits(const std::vector<UnitRow>& rows,
                           const std::vector<std::string>& folders,
                           const std::vector<size_t>& chosen) {
  ComparedUnits units;
  std::optional<ImageSize> size;
  std::vector<Eigen::Vector3d> directions;
  std::vector<std::vector<std::optional<Eigen::Vector2d>>> pixels;
  for (const size_t k : chosen) {
    const std::string path = folders[k] + "/camera.yaml";
    if (rows[k].status == "error" || rows[k].status == "missing" ||
        !std::filesystem::exists(path))
      continue;
    const CameraFile file = ReadCameraFile(path);
    if (!size) {
      size = file.camera->image_size();
      directions = SampleDirections(*file.camera);
    }
    if (file.camera->image_size() != *size) continue;
    units.rows.push_back(k);
    pixels.push_back(ProjectDirections(*file.camera, directions));
  }
  std::vector<size_t> common_directions;
  for (size_t d = 0; d < directions.size(); ++d) {
    bool is_seen = true;
    for (const auto& unit_pixels : pixels)
      is_seen &= unit_pixels[d].has_value();
    if (is_seen) common_directions.push_back(d);
  }
  units.input.pixels.resize(
      static_cast<Eigen::Index>(pixels.size()),
      2 * static_cast<Eigen::Index>(common_directions.size()));
  for (size_t u = 0; u < pixels.size(); ++u)
    for (size_t k = 0; k < common_directions.size(); ++k)
      units.input.pixels.block<1, 2>(static_cast<Eigen::Index>(u),
                                     2 * static_cast<Eigen::Index>(k)) =
          pixels[u][common_directions[k]]->transpose();
  for (const auto& [name, is_positive] :
       {std::pair("focal_px", false), std::pair("center_x_px", false),
        std::pair("center_y_px", false), std::pair("held_out_median_px", true),
        std::pair("max_uncertainty_px", true),
        std::pair("sensor_temperature_c", false)}) {
    FleetMetric metric =
        MakeIndependentMetric(name, is_positive, rows, units.rows);
    const bool is_known =
        std::any_of(metric.values.begin(), metric.values.end(),
                    [](double value) { return std::isfinite(value); });
    if (is_known) units.input.metrics.push_back(std::move(metric));
  }
  return units;
}

}  // namespace raygrid
