#include "view_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "camera_input.h"
#include "dataset/error.h"
#include "image_size_option.h"

namespace raygrid {
namespace {

[[noreturn]] void ThrowMissing(const std::string& option,
                               const std::string& what) {
  throw Error(ExitCode::kUsage, fmt::format("{}: {}", option, what));
}

// Returns the view of a table, as specified by the option.
VirtualView ParseImportedView(const TableFormat& format,
                              const ViewImport& import,
                              const ViewRequest& request,
                              const ImageSize& size) {
  try {
    return MakeViewWithoutCamera(size, request);
  } catch (const Error& error) {
    throw Error(
        error.code(),
        fmt::format(
            "{}: a {} table must be imported with the output view it was "
            "exported for, such as --view view.camera.yaml or --hfov 90: {}",
            import.path, format.name, error.what()));
  }
}

// Returns the size of the view, if specified.
std::optional<ImageSize> GetRequestedSize(const ViewRequest& request) {
  if (request.size.width != 0) return request.size;
  if (request.like) return request.like->size;
  return std::nullopt;
}

void RequireSize(const std::string& option, const ViewImport& import,
                 const ImageSize& table, const ImageSize& stated) {
  if (table == stated) return;
  throw Error(ExitCode::kUsage,
              fmt::format("{}: {} has {} x {} pixels instead of {} x {}",
                          option, import.path, table.width, table.height,
                          stated.width, stated.height));
}

RayTable EmptyRays(const ViewTable& table) {
  RayTable rays;
  rays.path = table.path;
  for (int x = 0; x < table.size.width; ++x) rays.x.push_back(x);
  for (int y = 0; y < table.size.height; ++y) rays.y.push_back(y);
  rays.directions.resize(table.num_pixels(), Eigen::Vector3d(NAN, NAN, NAN));
  return rays;
}

// The camera's pixels are those of the table; their directions are those of the
// table's positions in the view.
RayTable MakeCameraPixelRays(const ViewTable& table, const VirtualView& view) {
  RayTable rays = EmptyRays(table);
  rays.image_size = table.size;
  for (size_t k = 0; k < table.sources.size(); ++k) {
    if (!table.sources[k].allFinite()) continue;
    const auto direction = view.Direction(table.sources[k]);
    if (direction) rays.directions[k] = direction->normalized();
  }
  return rays;
}

// The camera's pixels are the positions in the table; their directions are
// those of the view's pixels.
RayTable MakeViewPixelRays(const ViewTable& table, const VirtualView& view) {
  constexpr double kRoundingPx = 1e-3;
  const Area image = WholeImage(table.source_size);
  RayTable rays = EmptyRays(table);
  rays.image_size = table.source_size;
  rays.pixels = table.sources;
  for (size_t k = 0; k < table.sources.size(); ++k) {
    Eigen::Vector2d& pixel = rays.pixels[k];
    if (!pixel.allFinite() || !image.Contains(pixel, kRoundingPx)) continue;
    pixel = pixel.cwiseMax(0.0).cwiseMin(Eigen::Vector2d(image.x1, image.y1));
    const size_t column = k % table.size.width, row = k / table.size.width;
    const auto direction =
        view.Direction(Eigen::Vector2d(rays.x[column], rays.y[row]));
    if (direction) rays.directions[k] = direction->normalized();
  }
  return rays;
}

}  // namespace

RayTable ReadViewTableRays(const TableFormat& format,
                           const ViewImport& import) {
  const ViewRequest request = ParseViewOptions(import.view);
  const auto view_size = GetRequestedSize(request);
  std::optional<ImageSize> image_size;
  if (!import.image_size.empty())
    image_size = ParseImageSize("--image-size", import.image_size);
  if (!import.is_reverse && !image_size)
    ThrowMissing(
        "--image-size",
        fmt::format(
            "specify the size of the camera's images, which {} does not store, "
            "or use --inverse if its pixels are those of the camera",
            import.path));
  const ViewTable table = format.read_view(
      import.path, import.bytes, import.is_reverse ? view_size : image_size);
  const ImageSize size =
      import.is_reverse ? table.source_size : view_size.value_or(table.size);
  if (import.is_reverse && image_size)
    RequireSize("--image-size", import, table.size, *image_size);
  if (!import.is_reverse) RequireSize("the view", import, table.size, size);
  const VirtualView view = ParseImportedView(format, import, request, size);
  return import.is_reverse ? MakeCameraPixelRays(table, view)
                           : MakeViewPixelRays(table, view);
}

}  // namespace raygrid
