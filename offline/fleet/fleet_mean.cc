#include "fleet/fleet_mean.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "camera/bspline_surface.h"
#include "camera/central_generic.h"
#include "camera/stereographic.h"
#include "fleet/robust_series.h"

namespace raygrid {
namespace {

// The cameras of usual units; empty if one is not central.
std::vector<std::shared_ptr<const CameraModel>> UsualCameras(
    const FleetAnalysis& fleet, const std::vector<std::string>& folders) {
  std::vector<size_t> usual;
  for (const size_t row : fleet.compared)
    if (fleet.rows[row].unusual.empty()) usual.push_back(row);
  constexpr size_t kMost = 200;
  const size_t count = std::min(usual.size(), kMost);
  std::vector<std::shared_ptr<const CameraModel>> cameras;
  for (size_t k = 0; k < count; ++k) {
    const std::string& folder = folders[usual[k * usual.size() / count]];
    cameras.push_back(ReadCameraFile(folder + "/camera.yaml").camera);
    if (!cameras.back()->IsCentral()) return {};
  }
  return cameras;
}

// The area that holds all of theirs.
Area JoinedArea(
    const std::vector<std::shared_ptr<const CameraModel>>& cameras) {
  Area area = cameras[0]->area();
  for (const auto& camera : cameras) {
    const Area& own = camera->area();
    area.Extend({own.x0, own.y0});
    area.Extend({own.x1, own.y1});
  }
  return area;
}

}  // namespace

std::optional<CameraFile> MeanCamera(const FleetAnalysis& fleet,
                                     const std::vector<std::string>& folders) {
  if (fleet.statistics.charts.empty()) return std::nullopt;
  const auto cameras = UsualCameras(fleet, folders);
  if (cameras.empty()) return std::nullopt;
  // Cells of a thirty-second of the image's width.
  constexpr int kColumns = 35, kSamplesPerCell = 3;
  const Area area = JoinedArea(cameras);
  const int rows =
      std::max(7, static_cast<int>(kColumns * area.height() / area.width()));
  std::vector<SurfaceSample> samples;
  for (const Eigen::Vector2d& pixel :
       BSplineSurface(area, kColumns, rows).SamplePixels(kSamplesPerCell)) {
    std::vector<double> x, y;
    for (const auto& camera : cameras)
      if (const auto ray = camera->Unproject(pixel)) {
        const Eigen::Vector2d chart = ToChart(*ray);
        x.push_back(chart.x());
        y.push_back(chart.y());
      }
    if (2 * x.size() > cameras.size())
      samples.push_back({pixel, {Median(x), Median(y)}});
  }
  if (samples.empty()) return std::nullopt;
  CameraFile file;
  file.camera = std::make_shared<CentralGeneric>(
      cameras[0]->image_size(), FitSurface(area, kColumns, rows, samples));
  file.name = fmt::format("middle of {} units", cameras.size());
  return file;
}

}  // namespace raygrid
