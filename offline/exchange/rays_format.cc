#include "exchange/rays_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/error.h"
#include "dataset/image_header.h"
#include "exchange/npz.h"
#include "exchange/pixel_origin.h"
#include "exchange/python_format.h"

namespace raygrid {
namespace {

// Makes an array of rows x columns x 3 numbers.
NpyArray MakeVectorArray(const std::string& name, const RayTable& rays,
                         const std::vector<Eigen::Vector3d>& vectors) {
  return MakeNpyArray(name, {rays.y.size(), rays.x.size(), 3},
                      vectors.front().data());
}

std::vector<double> ToProgramAxis(std::vector<double> places) {
  for (double& place : places)
    place = ToProgram(PixelOrigin::kFirstPixelCenter, {}, {place, 0}).x();
  return places;
}

TableOutput WriteRays(const RayTable& rays) {
  const int32_t size[] = {rays.image_size.width, rays.image_size.height};
  const std::vector<double> x = ToProgramAxis(rays.x),
                            y = ToProgramAxis(rays.y);
  std::vector<NpyArray> arrays = {
      MakeNpyArray("image_size", {2}, size),
      MakeNpyArray("x", {x.size()}, x.data()),
      MakeNpyArray("y", {y.size()}, y.data()),
      MakeVectorArray("directions", rays, rays.directions)};
  if (!rays.origins.empty())
    arrays.push_back(MakeVectorArray("origins", rays, rays.origins));
  return {{{rays.path, WriteNpz(arrays)}},
          fmt::format(
              "{} of {} x {} pixels, unit vectors{}",
              rays.origins.empty() ? "directions" : "directions and origins",
              rays.x.size(), rays.y.size(),
              rays.origins.empty() ? "" : " and metres")};
}

// ---- Reading ---------------------------------------------------------------

const NpyArray* FindArray(const std::vector<NpyArray>& arrays,
                          const std::string& name) {
  for (const NpyArray& array : arrays)
    if (array.name == name) return &array;
  return nullptr;
}

std::vector<double> ReadNumbers(const NpyArray& array, size_t num_axes) {
  if (array.shape.size() != num_axes)
    throw InputError(fmt::format("{}: has {} dimensions instead of {}",
                                 array.name, array.shape.size(), num_axes));
  return NpyNumbers(array);
}

// Reads an array of rows x columns x 3 numbers.
std::vector<Eigen::Vector3d> ReadVectorArray(const NpyArray& array, size_t rows,
                                             size_t columns) {
  const std::vector<double> numbers = ReadNumbers(array, 3);
  if (array.shape != std::vector<size_t>{rows, columns, 3})
    throw InputError(fmt::format(
        "{}: has shape {} x {} x {} instead of {} x {} x 3", array.name,
        array.shape[0], array.shape[1], array.shape[2], rows, columns));
  std::vector<Eigen::Vector3d> vectors(rows * columns);
  for (size_t k = 0; k < vectors.size(); ++k)
    vectors[k] = {numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]};
  return vectors;
}

// Returns the pixel positions of columns or rows; 0, 1, ... if missing.
std::vector<double> CollectFeaturePositions(const std::vector<NpyArray>& arrays,
                                            const std::string& name,
                                            size_t count) {
  std::vector<double> places(count);
  for (size_t k = 0; k < count; ++k) places[k] = static_cast<double>(k);
  const NpyArray* array = FindArray(arrays, name);
  if (array) places = ReadNumbers(*array, 1);
  if (places.size() != count)
    throw InputError(fmt::format("{}: has {} entries, but 'directions' has {}",
                                 name, places.size(), count));
  for (double& place : places) {
    if (!std::isfinite(place))
      throw InputError(fmt::format("{}: expected finite numbers", name));
    place = FromProgram(PixelOrigin::kFirstPixelCenter, {}, {place, 0}).x();
  }
  for (size_t k = 1; k < count; ++k)
    if (!(places[k] > places[k - 1]))
      throw InputError(fmt::format("{}: must be in ascending order", name));
  return places;
}

// Returns the image size of the file, or the smallest one that contains the
// last positions.
ImageSize ReadSize(const std::vector<NpyArray>& arrays, const RayTable& rays) {
  double width = std::floor(rays.x.back()) + 1,
         height = std::floor(rays.y.back()) + 1;
  if (const NpyArray* array = FindArray(arrays, "image_size")) {
    const std::vector<double> size = ReadNumbers(*array, 1);
    if (size.size() != 2 || !(size[0] >= width) || !(size[1] >= height))
      throw InputError(
          "image_size: expected the width and height of an image that contains "
          "all positions in x and y");
    width = size[0];
    height = size[1];
  }
  constexpr double kMaxExtent = 1e9;
  const std::string why =
      rays.x.front() < 0 || rays.y.front() < 0
          ? "x, y: must not be negative"
          : DescribeSizeLimit(
                static_cast<uint64_t>(std::min(width, kMaxExtent)),
                static_cast<uint64_t>(std::min(height, kMaxExtent)));
  if (!why.empty()) throw InputError(why);
  return {static_cast<int>(width), static_cast<int>(height)};
}

// Normalizes directions; rays are invalid if the direction or the origin is not
// finite.
void NormalizeDirections(RayTable* rays) {
  for (size_t k = 0; k < rays->directions.size(); ++k) {
    Eigen::Vector3d& direction = rays->directions[k];
    direction.normalize();
    if (!direction.allFinite() || !(direction.norm() > 0.5) ||
        (!rays->origins.empty() && !rays->origins[k].allFinite()))
      direction.setConstant(NAN);
  }
}

RayTable MakeRayTable(const std::vector<NpyArray>& arrays) {
  const NpyArray* directions = FindArray(arrays, "directions");
  if (!directions)
    throw InputError("missing array 'directions' of rows x columns x 3");
  if (directions->shape.size() != 3 || directions->shape[0] < 2 ||
      directions->shape[1] < 2)
    throw InputError("directions: expected rows x columns x 3 numbers");
  RayTable rays;
  rays.y = CollectFeaturePositions(arrays, "y", directions->shape[0]);
  rays.x = CollectFeaturePositions(arrays, "x", directions->shape[1]);
  rays.image_size = ReadSize(arrays, rays);
  rays.directions = ReadVectorArray(*directions, rays.y.size(), rays.x.size());
  if (const NpyArray* origins = FindArray(arrays, "origins"))
    rays.origins = ReadVectorArray(*origins, rays.y.size(), rays.x.size());
  NormalizeDirections(&rays);
  return rays;
}

RayTable ReadRays(const std::string& path, const std::string& bytes) {
  try {
    RayTable rays = MakeRayTable(ReadNpz(bytes));
    rays.path = path;
    return rays;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", path, error.what()));
  }
}

}  // namespace

TableFormat MakeRaysFormat() {
  TableFormat format;
  format.name = "rays";
  format.holds =
      "numpy: ray directions per pixel, and ray origins of a non-central "
      "camera, as .npz";
  format.endings = {".npz"};
  format.options = {"stride"};
  format.write_rays = WriteRays;
  format.recognizes = [](const std::string& bytes) {
    return IsNpz(bytes) && !IsCameraNpz(bytes);
  };
  format.read_rays = ReadRays;
  return format;
}

}  // namespace raygrid
