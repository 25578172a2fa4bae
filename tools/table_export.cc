#include "table_export.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "camera/camera_frame.h"
#include "camera_input.h"
#include "crc32.h"
#include "dataset/dataset.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/parallel_for.h"
#include "dataset/text_encoding.h"
#include "exchange/mesh/mesh_vertices.h"
#include "image_size_option.h"
#include "json_output.h"
#include "packing/view_sources.h"
#include "pattern_input.h"

namespace raygrid {
namespace {

// Parses a 32-bit address, hexadecimal as for flash programmers, or decimal.
uint32_t ParseAddress(const std::string& text) {
  const bool is_hex =
      text.size() > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
  const char *const begin = text.data() + (is_hex ? 2 : 0), *const end =
                                                                text.data() +
                                                                text.size();
  uint32_t address = 0;
  const auto [next, fault] =
      std::from_chars(begin, end, address, is_hex ? 16 : 10);
  if (fault != std::errc() || next != end)
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "--address {}: expected a 32-bit number, such as 0x08080000",
            text));
  return address;
}

BlobTable MakeBlobTable(const TableFormat& format,
                        const TableArguments& arguments) {
  BlobTable table;
  if (!arguments.address.empty())
    table.address = ParseAddress(arguments.address);
  else if (format.AcceptsOption("address"))
    throw Error(ExitCode::kUsage,
                fmt::format("--to {}: specify the flash address of the blob, "
                            "such as --address 0x08080000",
                            format.name));
  table.path = arguments.output;
  table.bytes = ReadFile(arguments.input);
  const CameraInput camera = ParseCamera(arguments.input, table.bytes);
  if (!camera.blob)
    throw InputError(fmt::format(
        "{}: not a blob, which {} requires; create one with 'raygrid pack'",
        arguments.input, format.name));
  table.camera = camera.file.name;
  table.serial = camera.file.serial;
  table.image_size = camera.blob->image_size();
  table.crc32 =
      rg_crc32(0, reinterpret_cast<const uint8_t*>(table.bytes.data()),
               static_cast<uint32_t>(table.bytes.size()));
  return table;
}

std::string GetModelName(const TableFormat& format, const std::string& model) {
  std::string names;
  for (const std::string& known : format.models) {
    if (known == model) return model;
    names += (names.empty() ? "" : ", ") + known;
  }
  if (model.empty()) return format.models.empty() ? "" : format.models.front();
  throw Error(
      ExitCode::kUsage,
      fmt::format("--model {}: not supported by {}{}", model, format.name,
                  names.empty() ? "" : "; use one of " + names));
}

// Returns the central camera with the directions of a camera, which is exact
// for distant scenes. Errors name its file.
std::unique_ptr<CameraModel> Central(const std::string& path,
                                     const CameraModel& camera) {
  try {
    return CentralCamera(camera);
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", path, error.what()));
  }
}

// A view and its central camera.
struct ExportedView {
  VirtualView view;
  std::unique_ptr<CameraModel> camera;
};

ExportedView ReadView(const TableArguments& arguments,
                      const CommonOptions& common) {
  CameraInput input = ReadCamera(arguments.input, common.at);
  if (!common.quiet) WarnAboutFailedCalibration(arguments.input, input.file);
  if (!input.blob) AlignToCanonicalFrame(&input.file.camera);
  const VirtualView view = RectifiedView(input, arguments.view);
  return {view, Central(arguments.input, *input.file.camera)};
}

ViewTable MakeViewTable(const TableFormat& format,
                        const TableArguments& arguments,
                        const ExportedView& seen, int num_threads) {
  ViewTable table;
  table.model = GetModelName(format, arguments.model);
  table.path = arguments.output;
  if (seen.view.projection == ViewProjection::kPinhole)
    table.matrix = GetCameraMatrix(seen.view);
  ViewSources found = MakeViewSources(*seen.camera, seen.view,
                                      arguments.is_reverse, num_threads);
  table.size = found.size;
  table.source_size = found.source_size;
  table.sources = std::move(found.sources);
  return table;
}

// Returns every n-th pixel along an axis, and the last one.
std::vector<double> SampleAlong(int count, int every) {
  std::vector<double> places;
  for (int k = 0; k + 1 < count; k += every) places.push_back(k);
  places.push_back(count - 1);
  return places;
}

int ParseEvery(const std::string& text) {
  int every = 0;
  const char* const end = text.data() + text.size();
  const auto [next, fault] = std::from_chars(text.data(), end, every);
  if (fault != std::errc() || next != end || every < 1)
    throw Error(
        ExitCode::kUsage,
        fmt::format("--stride {}: expected a number of pixels, at least 1",
                    text));
  return every;
}

RayTable MakeRayTable(const TableArguments& arguments,
                      const CommonOptions& common) {
  const int every = arguments.every.empty() ? 1 : ParseEvery(arguments.every);
  const CameraInput input = ReadCamera(arguments.input, common.at);
  if (!common.quiet) WarnAboutFailedCalibration(arguments.input, input.file);
  const CameraModel& camera = *input.file.camera;
  RayTable table;
  table.path = arguments.output;
  table.image_size = camera.image_size();
  table.x = SampleAlong(table.image_size.width, every);
  table.y = SampleAlong(table.image_size.height, every);
  const Eigen::Vector3d none(NAN, NAN, NAN);
  table.directions.resize(table.x.size() * table.y.size(), none);
  if (!camera.IsCentral()) table.origins = table.directions;
  ParallelFor(
      static_cast<int>(table.y.size()), NumThreads(common.threads),
      [&](int row) {
        for (size_t k = 0; k < table.x.size(); ++k) {
          const auto line = camera.Line({table.x[k], table.y[row]});
          if (!line || !camera.IsInImageCircle({table.x[k], table.y[row]}))
            continue;
          const size_t index = row * table.x.size() + k;
          table.directions[index] = line->direction.normalized();
          if (!table.origins.empty()) table.origins[index] = line->origin;
        }
      });
  return table;
}

// Returns the maximum distance of a non-central camera's observation lines from
// the origin, in metres.
double ComputeMaxOffsetM(const CameraModel& camera) {
  constexpr int kPixelsAcross = 80;
  const Area& area = camera.area();
  double largest = 0;
  for (int k = 0; k <= kPixelsAcross * kPixelsAcross; ++k) {
    const double x = k % kPixelsAcross, y = k / kPixelsAcross;
    const auto line =
        camera.Line({area.x0 + area.width() * x / kPixelsAcross,
                     area.y0 + area.height() * y / kPixelsAcross});
    if (line)
      largest = std::max(
          largest, line->origin.cross(line->direction.normalized()).norm());
  }
  return largest;
}

TableOutput MakeCameraTable(const TableFormat& format,
                            const TableArguments& arguments,
                            const CommonOptions& common,
                            nlohmann::ordered_json* json) {
  ExportedCamera table;
  table.path = arguments.output;
  table.model = GetModelName(format, arguments.model);
  const CameraInput input = ReadCamera(arguments.input, common.at);
  if (!common.quiet) WarnAboutFailedCalibration(arguments.input, input.file);
  const std::optional<ValidityMask> valid_region = LoadValidityMask(input);
  const auto camera = Central(arguments.input, *input.file.camera);
  table.camera = camera.get();
  table.valid_region = valid_region ? &*valid_region : nullptr;
  table.max_error_px = arguments.max_fit_error_px;
  table.num_threads = common.threads;
  TableOutput output;
  try {
    output = format.write_camera(table);
  } catch (const Error& error) {
    throw Error(error.code(),
                fmt::format("{}: {}", arguments.input, error.what()));
  }
  (*json)["model"] = table.model;
  (*json)["valid_region_only"] = valid_region.has_value();
  if (input.file.camera->IsCentral()) return output;
  const double offset_m = ComputeMaxOffsetM(*input.file.camera);
  (*json)["offset_m"] = offset_m;
  output.configuration += fmt::format(
      "; all rays start at one origin, up to {:.2g} mm from the camera's rays; "
      "use them for distant scenes only",
      offset_m * 1000);
  return output;
}

// Returns the source positions of required vertices; NaN for the others, and
// where the camera does not project.
std::vector<Eigen::Vector2d> ComputeVertexPositions(const ExportedView& seen,
                                                    const MeshTable& mesh,
                                                    int num_threads) {
  const MeshLattice& lattice = mesh.lattice;
  // Vertices outside the output image are within one cell of it.
  const double margin_px = 64 + 4 * std::max(lattice.x[1], lattice.y[1]);
  std::vector<Eigen::Vector2d> places(lattice.num_vertices(),
                                      Eigen::Vector2d(NAN, NAN));
  ParallelFor(lattice.rows(), NumThreads(num_threads), [&](int row) {
    for (int column = 0; column < lattice.columns(); ++column) {
      const size_t k = static_cast<size_t>(row) * lattice.columns() + column;
      if (!mesh.is_needed[k]) continue;
      const int x = lattice.x[column], y = lattice.y[row];
      const bool is_pixel = x < mesh.size.width && y < mesh.size.height;
      if (is_pixel)
        places[k] = mesh.sources[static_cast<size_t>(y) * mesh.size.width + x];
      if (places[k].allFinite()) continue;
      const auto direction = seen.view.Direction(Eigen::Vector2d(x, y));
      const auto place =
          direction ? seen.camera->Project(*direction, nullptr, margin_px)
                    : std::nullopt;
      if (place) places[k] = *place;
    }
  });
  return places;
}

// Whether the hardware unit may interpolate quadratically between the vertices
// of this mesh.
bool IsBent(const TableFormat& format, const MeshLattice& lattice) {
  return format.mesh_unit->interpolations.size() > 1 && lattice.x[1] > 1;
}

MeshTable MakeMeshTable(const TableFormat& format,
                        const TableArguments& arguments,
                        const ExportedView& seen, int num_threads) {
  MeshRequest request = {seen.view.size, seen.camera->image_size(), {}};
  if (!arguments.every.empty()) request.step = ParseEvery(arguments.every);
  MeshTable mesh;
  mesh.path = arguments.output;
  mesh.size = request.size;
  mesh.source_size = request.source_size;
  mesh.lattice = format.mesh_unit->lattice(request);
  mesh.sources = MakeViewTable(format, arguments, seen, num_threads).sources;
  mesh.is_needed = FindRequiredVertices(mesh.lattice, mesh.size, mesh.sources);
  // Quadratic interpolation involves more vertices, and its errors already have
  // both signs.
  const bool is_bent = IsBent(format, mesh.lattice);
  if (is_bent) mesh.is_needed.assign(mesh.is_needed.size(), true);
  mesh.vertices = ComputeVertexPositions(seen, mesh, num_threads);
  ExtrapolateVertices(mesh.lattice, &mesh.vertices);
  if (!is_bent) BalanceVertices(&mesh);
  return mesh;
}

void RequireSmallMeshError(const TableFormat& format,
                           const TableArguments& arguments,
                           const MeshError& error) {
  const MeshUnit& unit = *format.mesh_unit;
  const std::optional<double> most = arguments.max_fit_error_px
                                         ? arguments.max_fit_error_px
                                         : unit.max_error_px;
  if (!most || error.max_px <= *most) return;
  std::string text =
      fmt::format("{}: the error of {} exceeds {:g} px: {}", arguments.input,
                  format.name, *most, FormatMeshError(error));
  if (!unit.reason.empty()) text += "; " + unit.reason;
  if (!arguments.max_fit_error_px) text += ", or set --max-fit-error-px";
  throw Error(ExitCode::kQualityTooLow, text);
}

// The errors for all interpolation methods that the hardware unit may use.
struct MeshErrors {
  MeshError largest;
  std::string text;  // one entry for each method; empty if there is only one
  nlohmann::ordered_json json;
};

MeshErrors ComputeMeshErrors(const TableFormat& format, const MeshTable& mesh,
                             const UnitMesh& unit) {
  MeshErrors errors;
  for (const MeshInterpolation interpolation :
       format.mesh_unit->interpolations) {
    const MeshError own = ComputeMeshError(mesh, unit, interpolation);
    if (errors.json.empty() || own.max_px > errors.largest.max_px)
      errors.largest = own;
    if (!IsBent(format, mesh.lattice)) break;
    errors.json[GetInterpolationName(interpolation)] = {
        {"max_px", own.max_px},
        {"rms_px", own.rms_px},
        {"max_error_position_px", {own.x, own.y}}};
    errors.text += fmt::format("{} {:.2g} px with {}",
                               errors.text.empty() ? "; at most" : ",",
                               own.max_px, GetInterpolationName(interpolation));
  }
  return errors;
}

TableOutput MakeMesh(const TableFormat& format, const TableArguments& arguments,
                     const ExportedView& seen, int num_threads,
                     nlohmann::ordered_json* json) {
  const MeshTable mesh = MakeMeshTable(format, arguments, seen, num_threads);
  const UnitMesh unit = format.mesh_unit->write(mesh);
  const MeshErrors errors = ComputeMeshErrors(format, mesh, unit);
  const MeshError& error = errors.largest;
  RequireSmallMeshError(format, arguments, error);
  (*json)["mesh"] = {
      {"vertices", {mesh.lattice.columns(), mesh.lattice.rows()}},
      {"step_px", {mesh.lattice.x[1], mesh.lattice.y[1]}},
      {"max_px", error.max_px},
      {"rms_px", error.rms_px},
      {"max_error_position_px", {error.x, error.y}},
      {"pixels", error.num_pixels},
      {"num_filled_pixels", error.num_filled},
      {"num_clamped_vertices", error.num_inaccurate},
      {"configuration", unit.configuration}};
  if (!errors.text.empty()) (*json)["mesh"]["by_interpolation"] = errors.json;
  return {unit.files,
          fmt::format("{} x {} vertices, {}{}; {}", mesh.lattice.columns(),
                      mesh.lattice.rows(), FormatMeshError(error), errors.text,
                      unit.configuration)};
}

// Reads the poses of poses.csv, which must be those of a single camera.
PoseTable MakePoseTable(const TableFormat& format,
                        const TableArguments& arguments) {
  const std::string& path = arguments.input;
  if (std::filesystem::path(path).extension() != ".csv")
    throw InputError(
        fmt::format("{}: {} requires poses.csv, which calibrate writes", path,
                    format.name));
  const auto cameras = ReadPoses(path);
  if (cameras.empty()) throw InputError(path + ": contains no poses");
  if (cameras.size() > 1)
    throw InputError(
        fmt::format("{}: contains poses of {} cameras, but {} stores a single "
                    "trajectory; keep the rows of one camera",
                    path, cameras.size(), format.name));
  const std::vector<BoardPose>& poses = cameras.begin()->second;
  return {path, arguments.output, poses};
}

// Returns the image size given for a camera; WxH applies to all cameras without
// their own NAME=WxH.
ImageSize GetFeatureImageSize(const TableArguments& arguments,
                              const std::string& camera) {
  std::string size;
  for (const std::string& text : arguments.image_sizes) {
    const size_t at = text.find('=');
    const std::string name = at == std::string::npos ? "" : text.substr(0, at);
    if (name == camera || (name.empty() && size.empty()))
      size = at == std::string::npos ? text : text.substr(at + 1);
  }
  if (size.empty())
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "--image-size WxH is required: features.csv has no image size{}",
            camera.empty() ? "" : " for camera '" + camera + "'"));
  return ParseImageSize("--image-size", size);
}

void RequireKnownCameras(const TableArguments& arguments,
                         const std::map<std::string, Dataset>& cameras) {
  for (const std::string& text : arguments.image_sizes) {
    const size_t at = text.find('=');
    if (at != std::string::npos && cameras.count(text.substr(0, at)) == 0)
      throw Error(ExitCode::kUsage,
                  fmt::format("--image-size {}: {} has no camera '{}'", text,
                              arguments.input, text.substr(0, at)));
  }
}

FeatureTable MakeFeatureTable(const TableFormat& format,
                              const TableArguments& arguments) {
  if (std::filesystem::path(arguments.input).extension() != ".csv")
    throw InputError(fmt::format("{}: {} requires features.csv",
                                 arguments.input, format.name));
  if (arguments.pattern.empty())
    throw Error(
        ExitCode::kUsage,
        fmt::format(
            "--pattern is required: {} contains the geometry of the target",
            format.name));
  const Pattern pattern = LoadPattern(arguments.pattern);
  auto cameras = ReadFeatures(arguments.input);
  RequireKnownCameras(arguments, cameras);
  FeatureTable table = {arguments.input, arguments.output, {}, pattern.boards};
  for (auto& [name, dataset] : cameras) {
    dataset.image_size = GetFeatureImageSize(arguments, name);
    RequireConsistent(arguments.input, dataset, pattern);
    table.cameras.push_back({name, std::move(dataset)});
  }
  return table;
}

TableOutput MakeTable(const TableFormat& format,
                      const TableArguments& arguments,
                      const CommonOptions& common,
                      nlohmann::ordered_json* json) {
  if (format.write_rays) {
    const RayTable table = MakeRayTable(arguments, common);
    (*json)["pixels"] = {table.x.size(), table.y.size()};
    (*json)["central"] = table.origins.empty();
    return format.write_rays(table);
  }
  if (format.write_features) {
    const FeatureTable table = MakeFeatureTable(format, arguments);
    for (const NamedDataset& camera : table.cameras)
      (*json)["cameras"].push_back(camera.camera);
    return format.write_features(table);
  }
  if (format.write_camera)
    return MakeCameraTable(format, arguments, common, json);
  if (format.write_poses) {
    const PoseTable table = MakePoseTable(format, arguments);
    (*json)["poses"] = table.poses.size();
    return format.write_poses(table);
  }
  if (format.IsOfView()) {
    const ExportedView seen = ReadView(arguments, common);
    (*json)["view"] = MakeViewJson(seen.view);
    TableOutput output =
        format.mesh_unit
            ? MakeMesh(format, arguments, seen, common.threads, json)
            : format.write_view(
                  MakeViewTable(format, arguments, seen, common.threads));
    output.configuration +=
        (arguments.is_reverse ? "; from the undistorted view: "
                              : "; output view: ") +
        FormatView(seen.view);
    return output;
  }
  const BlobTable table = MakeBlobTable(format, arguments);
  (*json)["bytes"] = table.bytes.size();
  (*json)["crc32"] = table.crc32;
  return format.write_blob(table);
}

}  // namespace

void ExportTable(const TableFormat& format, const TableArguments& arguments,
                 const CommonOptions& common) {
  format.RequireEnding(arguments.output);
  nlohmann::ordered_json json = {{"format", format.name},
                                 {"files", nlohmann::ordered_json::array()}};
  const TableOutput made = MakeTable(format, arguments, common, &json);
  for (const auto& [name, number] : made.metrics) json[name] = number;
  std::vector<std::string> paths;
  OutputFiles outputs;
  for (const auto& [path, contents] : made.files) {
    paths.push_back(path);
    json["files"].push_back(path);
    outputs.Add(path, contents);
  }
  RequireNoInputReplaced({arguments.input, arguments.pattern}, paths);
  outputs.Commit();
  if (common.json)
    PrintCommandJson(json);
  else if (!common.quiet)
    fmt::print("{}: {}\n", Printable(arguments.output), made.configuration);
}

}  // namespace raygrid
