#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "camera_input.h"
#include "commands.h"
#include "dataset/dataset.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/rig_file.h"

namespace raygrid {
namespace {

std::string Pixels(uint32_t upx) {
  return upx == RG_UNKNOWN_FIGURE ? "unknown"
                                  : fmt::format("{:.4f} px", upx * 1e-6);
}

void InspectRemap(const uint8_t* section) {
  rg_remap_section remap;
  rg_read_remap(section, &remap);
  fmt::print(
      "remap: {} x {} px, focal length {:.3f} px, centre ({:.3f}, "
      "{:.3f}), blocks of {} px, {} x {} vertices\n",
      remap.width, remap.height, remap.fx_q16 / 65536.0, remap.cx_q16 / 65536.0,
      remap.cy_q16 / 65536.0, 1 << remap.block_log2, remap.columns, remap.rows);
  fmt::print("remap geometry error: {} (asked for {})\n",
             Pixels(remap.max_error_upx), Pixels(remap.bound_upx));
}

void InspectQuality(const rg_blob& blob) {
  rg_quality_section quality;
  rg_blob_quality(&blob, &quality);
  fmt::print("training error: median {}, RMS {}, largest {}, {} features\n",
             Pixels(quality.training_median_upx),
             Pixels(quality.training_rms_upx), Pixels(quality.training_max_upx),
             quality.training_count);
  fmt::print("held-out error: median {}, RMS {}, largest {}, {} features\n",
             Pixels(quality.held_out_median_upx),
             Pixels(quality.held_out_rms_upx), Pixels(quality.held_out_max_upx),
             quality.held_out_count);
  fmt::print("un-projection error added by packing: {:.3g} px, {:.3g} rad\n",
             quality.packing_error_npx * 1e-9,
             quality.packing_error_prad * 1e-12);
}

void InspectUncertainty(const rg_blob& blob) {
  rg_uncertainty_section uncertainty;
  rg_blob_uncertainty(&blob, &uncertainty);
  std::vector<int> values_q12;
  for (int i = 0; i < uncertainty.columns * uncertainty.rows; ++i)
    values_q12.push_back(uncertainty.values[2 * i] +
                         256 * uncertainty.values[2 * i + 1]);
  std::sort(values_q12.begin(), values_q12.end());
  fmt::print("uncertainty: {} x {} values, median {:.4f} px\n",
             uncertainty.columns, uncertainty.rows,
             values_q12[values_q12.size() / 2] / 4096.0);
}

void InspectMask(const rg_blob& blob) {
  rg_mask_section mask;
  rg_blob_mask(&blob, &mask);
  const int count = mask.columns * mask.rows;
  int num_valid = 0;
  for (int k = 0; k < count; ++k) num_valid += mask.bits[k / 8] >> k % 8 & 1;
  fmt::print("trusted: {} of {} x {} cells of {} px\n", num_valid, mask.columns,
             mask.rows, 1 << mask.cell_log2);
}

void InspectBlob(const BlobCamera& camera) {
  const rg_blob& blob = camera.blob();
  rg_camera_section identity;
  rg_grid_section grid;
  rg_blob_camera(&blob, &identity);
  rg_blob_grid(&blob, &grid);
  fmt::print("raygrid blob, {} bytes, valid\n", blob.size);
  fmt::print("camera: '{}', serial '{}', {} x {} px\n", identity.name,
             identity.serial, identity.width, identity.height);
  fmt::print(
      "central grid: {} x {} control points, area x {:.3f} to {:.3f}, "
      "y {:.3f} to {:.3f}\n",
      grid.columns, grid.rows, grid.x0_q16 / 65536.0, grid.x1_q16 / 65536.0,
      grid.y0_q16 / 65536.0, grid.y1_q16 / 65536.0);
  if (blob.remap) InspectRemap(blob.bytes + blob.remap);
  if (blob.quality) InspectQuality(blob);
  if (blob.uncertainty) InspectUncertainty(blob);
  if (blob.mask) InspectMask(blob);
}

void PrintFigures(const char* name,
                  const std::optional<ErrorFigures>& figures) {
  if (figures)
    fmt::print(
        "{} error: median {:.4f} px, RMS {:.4f} px, largest {:.3f} px, "
        "{} features\n",
        name, figures->median_px, figures->rms_px, figures->max_px,
        figures->count);
}

void InspectCamera(const CameraFile& file) {
  const Area& area = file.camera->area();
  fmt::print("{} camera '{}', serial '{}', {} x {} px, {} parameters\n",
             file.camera->Name(), file.name, file.serial,
             file.camera->image_size().width, file.camera->image_size().height,
             file.camera->NumParameters());
  fmt::print("area x {:.3f} to {:.3f}, y {:.3f} to {:.3f}\n", area.x0, area.x1,
             area.y0, area.y1);
  PrintFigures("training", file.training);
  PrintFigures("held-out", file.held_out);
  if (file.uncertainty)
    fmt::print(
        "uncertainty: median {:.4f} px, trusted to {:.4f} px: {:.0f} % of the "
        "image\n",
        file.uncertainty->lattice.MedianPx(),
        file.uncertainty->max_deviation_px,
        100 * file.uncertainty->TrustedPart(file.camera->image_size(), area));
}

void InspectPattern(const Pattern& pattern) {
  for (const Board& board : pattern.boards)
    fmt::print("board {}: {}, {} x {} features, squares of {:g} mm\n", board.id,
               board.kind, board.columns, board.rows, board.square_m * 1000);
}

void InspectRig(const std::string& path) {
  for (const RigFileCamera& camera : ReadRigFile(path)) {
    const Eigen::Vector3d center = camera.camera_from_rig.Inverse().translation;
    fmt::print(
        "camera '{}': {}, centre in the rig ({:.6f}, {:.6f}, {:.6f}) m\n",
        camera.name, camera.file, center.x(), center.y(), center.z());
  }
}

void InspectFeatures(const std::string& path) {
  for (const auto& [camera, dataset] : ReadFeatures(path))
    fmt::print("camera '{}': {} features in {} images\n", camera,
               dataset.num_features(), dataset.images.size());
}

void Run(const std::string& path) {
  const std::string bytes = ReadFile(path);
  if (IsBlob(path, bytes))
    InspectBlob(BlobCamera(path, bytes));
  else if (bytes.find("raygrid_camera:") != std::string::npos)
    InspectCamera(ReadCameraFile(path));
  else if (bytes.find("raygrid_rig:") != std::string::npos)
    InspectRig(path);
  else if (bytes.find("raygrid_pattern:") != std::string::npos)
    InspectPattern(ReadPattern(path));
  else if (bytes.find("board") != std::string::npos)
    InspectFeatures(path);
  else
    throw InputError(
        path + ": neither a blob, a camera, a rig, a pattern, nor features");
}

}  // namespace

void AddInspect(CLI::App* app, CommonOptions* common) {
  CLI::App* command = AddCommand(
      app, "inspect",
      "Says what a blob, camera, rig, pattern or features file holds; "
      "verifies blobs.",
      "raygrid inspect front.raygrid", common);
  auto path = std::make_shared<std::string>();
  command->add_option("file", *path, "file")->required();
  command->callback([path] { Run(*path); });
}

}  // namespace raygrid
