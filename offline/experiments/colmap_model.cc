#include "experiments/colmap_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/token_lines.h"
#include "exchange/pixel_origin.h"

namespace raygrid {
namespace {

constexpr char kExpected[] = "a COLMAP text model";

ImageSize ReadSize(const std::string& path) {
  TokenLines lines(path, ReadFile(path), kExpected);
  ImageSize size;
  while (lines.NextNonEmpty()) {
    const ImageSize own = {lines.Get<int>(2), lines.Get<int>(3)};
    if (size.width > 0 && own != size)
      lines.ThrowError(
          "cameras have different image sizes, which this experiment does not "
          "support");
    size = own;
  }
  if (size.width < 1 || size.height < 1)
    throw InputError(path + ": contains no camera");
  return size;
}

// Reads the points, and maps each point's ID to its index.
std::vector<Eigen::Vector3d> ReadPoints(const std::string& path,
                                        std::map<int64_t, int>* indices) {
  TokenLines lines(path, ReadFile(path), kExpected);
  std::vector<Eigen::Vector3d> points;
  while (lines.NextNonEmpty()) {
    const bool is_new =
        indices->emplace(lines.Get<int64_t>(0), points.size()).second;
    if (!is_new) lines.ThrowError("duplicate point");
    points.emplace_back(lines.Get<double>(1), lines.Get<double>(2),
                        lines.Get<double>(3));
  }
  return points;
}

ColmapModel::Image ReadHead(const TokenLines& lines) {
  ColmapModel::Image image;
  const Eigen::Quaterniond rotation(lines.Get<double>(1), lines.Get<double>(2),
                                    lines.Get<double>(3), lines.Get<double>(4));
  if (!(rotation.norm() > 0.5)) lines.ThrowError("not a rotation");
  image.camera_from_world.rotation = rotation.normalized();
  image.camera_from_world.translation = {
      lines.Get<double>(5), lines.Get<double>(6), lines.Get<double>(7)};
  image.name = lines.Text(9);
  return image;
}

std::vector<ColmapModel::Observation> ReadObservations(
    const TokenLines& lines, const std::map<int64_t, int>& indices) {
  std::vector<ColmapModel::Observation> observations;
  if (lines.size() % 3 != 0)
    lines.ThrowError("expected x, y and a point id each");
  for (size_t i = 0; i < lines.size(); i += 3) {
    const auto point = lines.Get<int64_t>(i + 2);
    if (point == -1) continue;
    const auto index = indices.find(point);
    if (index == indices.end())
      lines.ThrowError(fmt::format("point {} is not in points3D.txt", point));
    const Eigen::Vector2d pixel(lines.Get<double>(i), lines.Get<double>(i + 1));
    observations.push_back(
        {FromProgram(PixelOrigin::kImageCorner, {}, pixel), index->second});
  }
  return observations;
}

}  // namespace

ColmapModel ReadColmapModel(const std::string& folder) {
  const auto path = [&folder](const char* name) {
    return (std::filesystem::path(folder) / name).string();
  };
  ColmapModel model;
  model.size = ReadSize(path("cameras.txt"));
  std::map<int64_t, int> indices;
  model.points = ReadPoints(path("points3D.txt"), &indices);
  const std::string images = path("images.txt");
  TokenLines lines(images, ReadFile(images), kExpected);
  while (lines.NextNonEmpty()) {
    model.images.push_back(ReadHead(lines));
    if (lines.Next())  // the second line may be empty
      model.images.back().observations = ReadObservations(lines, indices);
  }
  std::sort(model.images.begin(), model.images.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  return model;
}

}  // namespace raygrid
