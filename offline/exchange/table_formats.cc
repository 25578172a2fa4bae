#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "dataset/error.h"
#include "exchange/c_array_format.h"
#include "exchange/ffmpeg_format.h"
#include "exchange/format.h"
#include "exchange/intel_hex_format.h"
#include "exchange/isaac_format.h"
#include "exchange/maps_format.h"
#include "exchange/mesh/mesh_units.h"
#include "exchange/puzzlepaint_dataset_format.h"
#include "exchange/rays_format.h"
#include "exchange/stmap_format.h"
#include "exchange/table_format.h"
#include "exchange/tum_format.h"

namespace raygrid {
namespace {

// Joins items with commas and "or": "a, b or c".
std::string FormatList(const std::vector<std::string>& words) {
  std::string text = words.front();
  for (size_t k = 1; k < words.size(); ++k)
    text += (k + 1 < words.size() ? ", " : " or ") + words[k];
  return text;
}

}  // namespace

const std::vector<TableFormat>& TableFormats() {
  static const std::vector<TableFormat> formats = {
      MakeCArrayFormat(),      MakeIntelHexFormat(),
      MakeMapsFormat(),        MakeStMapFormat(),
      MakeFfmpegFormat(),      MakeRaysFormat(),
      MakeIsaacFormat(),       MakeDw100Format(),
      MakeTiLdcFormat(),       MakeVpiFormat(),
      MakeRockchipFecFormat(), MakeRockchipLdchFormat(),
      MakeHailoFormat(),       MakeDepthAiMeshFormat(),
      MakeTumFormat(),         MakePuzzlepaintDatasetFormat()};
  return formats;
}

const TableFormat* FindTableFormat(const std::string& name) {
  for (const TableFormat& format : TableFormats())
    if (format.name == name) return &format;
  return nullptr;
}

const TableFormat* RecognizeTable(const std::string& bytes) {
  for (const TableFormat& format : TableFormats())
    if (format.recognizes && format.recognizes(bytes)) return &format;
  return nullptr;
}

bool TableFormat::AcceptsOption(const std::string& option) const {
  return std::find(options.begin(), options.end(), option) != options.end();
}

void TableFormat::RequireEnding(const std::string& path) const {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (endings.empty() ||
      std::find(endings.begin(), endings.end(), ending) != endings.end())
    return;
  throw Error(ExitCode::kUsage, fmt::format("-o {}: {} writes {}", path, name,
                                            FormatList(endings)));
}

std::string TableFormat::Source() const {
  return write_blob       ? "a blob"
         : IsOfView()     ? "a view of a camera"
         : write_rays     ? "the rays of a camera's pixels"
         : write_camera   ? "a camera"
         : write_features ? "features.csv"
                          : "poses.csv";
}

std::string TableFormat::ExplainMissingCamera() const {
  return fmt::format(
      "has the format {}; convert it with 'raygrid import' to {}", name,
      read_poses      ? "poses.csv"
      : read_features ? "features.csv and pattern.yaml"
                      : "a camera");
}

std::optional<Eigen::Vector2d> ViewTable::At(int x, int y) const {
  const Eigen::Vector2d& source =
      sources[static_cast<size_t>(y) * size.width + x];
  if (!source.allFinite()) return std::nullopt;
  return source;
}

std::string WrittenFormatNames() {
  std::vector<std::string> all;
  for (const Format& format : GetFormats())
    if (format.write) all.push_back(format.name);
  for (const TableFormat& format : TableFormats()) all.push_back(format.name);
  return FormatList(all);
}

}  // namespace raygrid
