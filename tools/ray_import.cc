#include "ray_import.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "dataset/camera_file.h"
#include "dataset/files.h"
#include "dataset/text_encoding.h"
#include "exchange/ray_grid.h"
#include "json_output.h"

namespace raygrid {
namespace {

std::vector<std::string> FormatGridWarnings(const RayGrid& grid) {
  if (grid.fraction_without_rays == 0) return {};
  return {
      fmt::format("{:.1f} % of the pixels have no ray; gaps are interpolated",
                  100 * grid.fraction_without_rays)};
}

nlohmann::ordered_json MakeGridJson(const RayGrid& grid,
                                    const std::string& format) {
  const ImageSize& size = grid.camera->image_size();
  return {{"name", ""},
          {"model", grid.camera->Name()},
          {"file_model", format},
          {"image_size", {size.width, size.height}},
          {"control_points", {grid.columns, grid.rows}},
          {"fit",
           {{"rms_px", grid.rms_px},
            {"max_px", grid.max_px},
            {"held_out_rms_px", grid.left_out_rms_px},
            {"pixels", grid.num_pixels}}}};
}

}  // namespace

void ImportRays(const RayTable& rays, const std::string& format,
                const std::string& model, const std::string& output,
                const CommonOptions& common) {
  RequireNoInputReplaced({rays.path}, {output});
  RayGrid grid = FitRayGrid(rays, model, common.threads);
  const std::vector<std::string> warnings = FormatGridWarnings(grid);
  const nlohmann::ordered_json grid_json = MakeGridJson(grid, format);
  const std::string text = fmt::format(
      "{}: {} of {} x {} px, {} x {} control points; fit error {:.2g} px RMS, "
      "{:.2g} px max at {} pixels; cross-validation (fitted to half of the "
      "pixels) {:.2g} px RMS\n",
      Printable(output), grid.camera->Name(), rays.image_size.width,
      rays.image_size.height, grid.columns, grid.rows, grid.rms_px, grid.max_px,
      grid.num_pixels, grid.left_out_rms_px);
  CameraFile file;
  file.camera = std::move(grid.camera);
  WriteFile(output, FormatCameraFile(file, Digits::kAll));
  for (const std::string& warning : warnings)
    fmt::print(stderr, "raygrid: {}\n", warning);
  if (common.json)
    PrintCommandJson({{"rig", false},
                      {"cameras", nlohmann::ordered_json::array({grid_json})},
                      {"warnings", warnings}});
  else if (!common.quiet)
    fmt::print("{}", text);
}

}  // namespace raygrid
