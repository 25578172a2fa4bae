#include "dataset/camera_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "camera/central_radial.h"
#include "camera/model_registry.h"
#include "camera/noncentral_generic.h"
#include "camera/splined_stereographic.h"
#include "camera/view_camera.h"
#include "dataset/capture_node.h"
#include "dataset/error.h"
#include "dataset/files.h"
#include "dataset/image_header.h"
#include "dataset/operating_point_node.h"
#include "dataset/population_covariance_node.h"
#include "dataset/pose_node.h"
#include "dataset/uncertainty_node.h"
#include "dataset/yaml_file.h"

namespace raygrid {
namespace {

// Parses the B-spline surface of directions. If control points have further
// values (numbers_per_point in all), others receives these.
BSplineSurface ParseGrid(const YAML::Node& root, const Area& area,
                         size_t numbers_per_point,
                         std::vector<std::vector<double>>* others) {
  const YAML::Node grid = root["grid"];
  const int columns = grid["columns"].as<int>();
  const int rows = grid["rows"].as<int>();
  if (grid["chart"].as<std::string>() != "stereographic")
    throw InputError("grid: unsupported chart, expected stereographic");
  if (columns < 4 || rows < 4 || columns > 1027 || rows > 1027)
    throw InputError("grid: columns and rows must be 4 to 1027");
  const YAML::Node points = root["control_points"];
  if (static_cast<int>(points.size()) != columns * rows)
    throw InputError(
        fmt::format("control_points: expected {1} x {2}, found {0}",
                    points.size(), columns, rows));
  BSplineSurface surface(area, columns, rows);
  int index = 0;
  for (const YAML::Node& point : points) {
    if (!point.IsSequence() || point.size() != numbers_per_point)
      throw InputError(fmt::format("control_points: expected {} numbers each",
                                   numbers_per_point));
    std::vector<double> value;
    for (const YAML::Node& number : point)
      value.push_back(YamlNumber(number, "control_points"));
    surface.points()[index++] = {value[0], value[1]};
    others->emplace_back(value.begin() + 2, value.end());
  }
  return surface;
}

std::shared_ptr<CameraModel> ParseCentralGeneric(const YAML::Node& root,
                                                 const ImageSize& size,
                                                 const Area& area) {
  std::vector<std::vector<double>> none;
  return std::make_shared<CentralGeneric>(size,
                                          ParseGrid(root, area, 2, &none));
}

std::shared_ptr<CameraModel> ParseNonCentralGeneric(const YAML::Node& root,
                                                    const ImageSize& size,
                                                    const Area& area) {
  std::vector<std::vector<double>> others;
  BSplineSurface directions =
      ParseGrid(root, area, NonCentralGeneric::kPerNode, &others);
  std::vector<Eigen::Vector3d> points;
  for (const std::vector<double>& point : others)
    points.emplace_back(point[0], point[1], point[2]);
  return std::make_shared<NonCentralGeneric>(size, std::move(directions),
                                             std::move(points));
}

void ParseParameters(const YAML::Node& root,
                     const std::vector<std::string>& names,
                     double* parameters) {
  for (size_t k = 0; k < names.size(); ++k)
    parameters[k] =
        YamlNumber(root["parameters"][names[k]], "parameters: " + names[k]);
}

std::shared_ptr<CameraModel> ParseParametricModel(const YAML::Node& root,
                                                  const ModelInfo& model,
                                                  const ImageSize& size,
                                                  const Area& area) {
  Eigen::VectorXd parameters(model.parameters.size());
  ParseParameters(root, model.parameters, parameters.data());
  return model.make(size, area, parameters);
}

std::shared_ptr<CameraModel> ParseView(const YAML::Node& root,
                                       ViewProjection projection,
                                       const ImageSize& size,
                                       const Area& area) {
  Eigen::Vector4d parameters = Eigen::Vector4d::Ones();
  ParseParameters(
      root, ViewCamera(projection, size, area, parameters).ParameterNames(),
      parameters.data());
  if (!(parameters.head<2>().minCoeff() > 0))
    throw InputError("parameters: fx and fy must be positive");
  return std::make_shared<ViewCamera>(projection, size, area, parameters);
}

std::shared_ptr<CameraModel> ParseCentralRadial(const YAML::Node& root,
                                                const ImageSize& size,
                                                const Area& area) {
  const YAML::Node radial = root["radial"];
  const double max_angle_rad = radial["max_angle_rad"].as<double>();
  std::vector<double> spline;
  for (const YAML::Node& number : radial["spline"])
    spline.push_back(YamlNumber(number, "radial: spline"));
  if (!(max_angle_rad > 0) || !(max_angle_rad <= 3.1))
    throw InputError("radial: max_angle_rad must be in (0, 3.1]");
  if (spline.size() < 3 || spline.size() > 1000)
    throw InputError("radial: spline must have 3 to 1000 numbers");
  CentralRadial::PlanarParameters others = {};
  ParseParameters(
      root,
      CentralRadial(size, area, max_angle_rad, spline, others).ParameterNames(),
      others.data());
  return std::make_shared<CentralRadial>(size, area, max_angle_rad, spline,
                                         others);
}

std::shared_ptr<CameraModel> ParseSplinedStereographic(const YAML::Node& root,
                                                       const ImageSize& size,
                                                       const Area& area) {
  constexpr int kMost = 1027;
  const YAML::Node node = root["spline"];
  const SplinedStereographic::Grid grid = {node["columns"].as<int>(),
                                           node["rows"].as<int>(),
                                           node["fov_x_deg"].as<int>()};
  if (std::min(grid.columns, grid.rows) < 4 ||
      std::max(grid.columns, grid.rows) > kMost)
    throw InputError("spline: columns and rows must be 4 to 1027");
  if (grid.fov_x_deg < 1 || grid.fov_x_deg > 359)
    throw InputError("spline: fov_x_deg must be 1 to 359");
  const YAML::Node points = node["control_points"];
  const int count = 2 * grid.columns * grid.rows;
  if (!points.IsSequence() || static_cast<int>(points.size()) != count)
    throw InputError(
        fmt::format("spline: expected {} numbers in control_points", count));
  Eigen::VectorXd parameters = Eigen::VectorXd::Zero(count + 4);
  int index = 0;
  for (const YAML::Node& number : points)
    parameters[index++] = YamlNumber(number, "spline: control_points");
  ParseParameters(
      root, SplinedStereographic(size, area, grid, parameters).ParameterNames(),
      parameters.data() + count);
  if (!(parameters.segment<2>(count).minCoeff() > 0))
    throw InputError("parameters: fx and fy must be positive");
  return std::make_shared<SplinedStereographic>(size, area, grid, parameters);
}

std::optional<ErrorMetrics> ParseMetrics(const YAML::Node& node) {
  if (!node) return std::nullopt;
  return ErrorMetrics{YamlNumber(node["median_px"], "quality: median_px"),
                      YamlNumber(node["rms_px"], "quality: rms_px"),
                      YamlNumber(node["max_px"], "quality: max_px"),
                      node["count"].as<int>()};
}

// Files of earlier versions lack this section.
MovementErrors ParseResidualMovement(const YAML::Node& node) {
  if (!node) return {};
  const MovementErrors excess_errors = {
      node["scale"].as<double>(), node["shift_px"].as<double>(),
      node["tilt_rad"].as<double>(), node["local_px"].as<double>()};
  for (const double deviation :
       {excess_errors.scale, excess_errors.shift_px, excess_errors.tilt_rad,
        excess_errors.local_px})
    if (!(deviation >= 0 && std::isfinite(deviation)))
      throw InputError(
          "uncertainty modes: the values of 'beyond' must be finite and "
          "non-negative");
  return excess_errors;
}

// Files of earlier versions lack modes.
ErrorModes ParseModes(const YAML::Node& node) {
  ErrorModes modes;
  if (!node) return modes;
  const LatticeSize size = ParseLatticeSize(node, "uncertainty modes", 2, 65);
  modes.columns = size.columns;
  modes.rows = size.rows;
  modes.residual_px = node["rest_px"].as<double>();
  if (!(modes.residual_px >= 0))
    throw InputError("uncertainty modes: 'rest_px' must not be negative");
  modes.excess_errors = ParseResidualMovement(node["beyond"]);
  modes.displacements_px =
      ParseDisplacements(node["displacements_px"], "uncertainty modes",
                         modes.columns * modes.rows);
  return modes;
}

ValidityMask ParseMask(const YAML::Node& node, const ImageSize& size) {
  ValidityMask mask;
  mask.knot_spacing_px = node["cell_px"].as<int>();
  if (mask.knot_spacing_px < 4 || mask.knot_spacing_px > 256 ||
      (mask.knot_spacing_px & (mask.knot_spacing_px - 1)) != 0)
    throw InputError("trusted: cell_px must be a power of two, 4 to 256");
  mask.columns = ValidityMask::NumCells(size.width, mask.knot_spacing_px);
  mask.rows = ValidityMask::NumCells(size.height, mask.knot_spacing_px);
  const YAML::Node rows = node["cells"];
  RequireYamlList(rows, "trusted: cells", mask.rows);
  for (const YAML::Node& row : rows) {
    const std::string text = row.as<std::string>();
    if (static_cast<int>(text.size()) != mask.columns ||
        text.find_first_not_of("#.") != std::string::npos)
      throw InputError(fmt::format(
          "trusted: cells: each row must consist of {} characters # or .",
          mask.columns));
    for (const char cell : text) mask.is_valid.push_back(cell == '#');
  }
  return mask;
}

std::optional<CameraUncertainty> ParseUncertainty(const YAML::Node& root,
                                                  const ImageSize& size) {
  if (!root["uncertainty"] && !root["trusted"]) return std::nullopt;
  if (!root["uncertainty"] && !root["trusted"]["max_deviation_px"])
    return CameraUncertainty::FromMask(ParseMask(root["trusted"], size));
  if (!root["uncertainty"] || !root["trusted"])
    throw InputError(
        "'uncertainty' and 'trusted' require each other, but one is missing; "
        "use the complete file");
  CameraUncertainty uncertainty;
  uncertainty.lattice = ParseUncertaintyLattice(root["uncertainty"]);
  uncertainty.mask = ParseMask(root["trusted"], size);
  uncertainty.max_stddev_px = YamlNumber(root["trusted"]["max_deviation_px"],
                                         "trusted: max_deviation_px");
  uncertainty.modes = ParseModes(root["uncertainty"]["modes"]);
  return uncertainty;
}

std::optional<ImageCircle> ParseImageCircle(const YAML::Node& node) {
  if (!node) return std::nullopt;
  RequireYamlList(node, "image_circle", 3);
  const double radius_px = YamlNumber(node[2], "image_circle");
  if (!(radius_px > 0))
    throw InputError("image_circle: expected x, y and a positive radius");
  return ImageCircle{{YamlNumber(node[0], "image_circle"),
                      YamlNumber(node[1], "image_circle")},
                     Eigen::Vector2d::Constant(radius_px)};
}

std::optional<LineDelay> ParseLineDelay(const YAML::Node& root) {
  const YAML::Node line_delay = root["row_time_us"];
  const YAML::Node deviation = root["row_time_deviation_us"];
  if (deviation && !line_delay)
    throw InputError("row_time_deviation_us requires row_time_us");
  if (!line_delay) return std::nullopt;
  LineDelay value;
  value.seconds = YamlNumber(line_delay, "row_time_us") * 1e-6;
  if (deviation)
    value.stddev_s = YamlNumber(deviation, "row_time_deviation_us") * 1e-6;
  if (!(std::abs(value.seconds) <= kMaxLineDelayS))
    throw InputError("row_time_us: must be -1000 to 1000 microseconds");
  if (!(value.stddev_s >= 0 && value.stddev_s <= kMaxLineDelayS))
    throw InputError("row_time_deviation_us: must be 0 to 1000 microseconds");
  return value;
}

// Throws exceptions of yaml-cpp, and InputError without the file name.
CameraFile Parse(const YAML::Node& root) {
  RequireKind(root, "camera");
  if (root["raygrid_camera"].as<int>() != 1)
    throw InputError("unsupported version of camera.yaml");
  const auto size = root["image_size"].as<std::vector<int>>();
  const auto rectangle = root["area"].as<std::vector<double>>();
  if (size.size() != 2 || size[0] < 1 || size[1] < 1)
    throw InputError("image_size: expected two positive integers");
  if (std::max(size[0], size[1]) > kMaxHugeSidePx)
    throw InputError(
        fmt::format("image_size: at most {} pixels per side are supported",
                    kMaxHugeSidePx));
  if (rectangle.size() != 4 || !(rectangle[0] < rectangle[2]) ||
      !(rectangle[1] < rectangle[3]) || !(rectangle[0] >= -0.5) ||
      !(rectangle[1] >= -0.5) || !(rectangle[2] <= size[0] - 0.5) ||
      !(rectangle[3] <= size[1] - 0.5))
    throw InputError(
        "area: expected x0, y0, x1, y1 of a rectangle within the image");
  const Area area = {rectangle[0], rectangle[1], rectangle[2], rectangle[3]};
  const ImageSize image_size = {size[0], size[1]};

  CameraFile file;
  const std::string model = root["model"].as<std::string>();
  std::shared_ptr<CameraModel> camera;
  if (model == models::kCentralGeneric)
    camera = ParseCentralGeneric(root, image_size, area);
  else if (model == models::kNonCentralGeneric)
    camera = ParseNonCentralGeneric(root, image_size, area);
  else if (model == models::kCentralRadial)
    camera = ParseCentralRadial(root, image_size, area);
  else if (model == models::kSplinedStereographic)
    camera = ParseSplinedStereographic(root, image_size, area);
  else if (const ModelInfo* lens = FindModelInfo(model))
    camera = ParseParametricModel(root, *lens, image_size, area);
  else if (const auto projection = FindProjection(model))
    camera = ParseView(root, *projection, image_size, area);
  else
    throw InputError("unknown model '" + model + "'");
  camera->SetImageCircle(ParseImageCircle(root["image_circle"]));
  file.camera = std::move(camera);
  if (root["camera_from_view"])
    file.camera_from_view =
        ParsePose("camera_from_view", root["camera_from_view"]);
  if (root["name"]) file.name = root["name"].as<std::string>();
  if (root["serial"]) file.serial = root["serial"].as<std::string>();
  if (root["quality"]) {
    file.training = ParseMetrics(root["quality"]["training"]);
    file.held_out = ParseMetrics(root["quality"]["held_out"]);
    if (root["quality"]["verdict"])
      file.assessment = root["quality"]["verdict"].as<std::string>();
  }
  file.uncertainty = ParseUncertainty(root, image_size);
  file.capture = ParseCapture(root["capture"], image_size);
  file.spread = ParsePopulationCovariance(root["spread"]);
  file.stack = ParseOperatingPointModel(root["stack"], *file.camera);
  file.line_delay = ParseLineDelay(root);
  return file;
}

void EmitMetrics(const char* name, const std::optional<ErrorMetrics>& metrics,
                 YAML::Emitter* out) {
  if (!metrics) return;
  *out << YAML::Key << name << YAML::Value << YAML::Flow << YAML::BeginMap
       << YAML::Key << "median_px" << YAML::Value
       << fmt::format("{:.6f}", metrics->median_px) << YAML::Key << "rms_px"
       << YAML::Value << fmt::format("{:.6f}", metrics->rms_px) << YAML::Key
       << "max_px" << YAML::Value << fmt::format("{:.6f}", metrics->max_px)
       << YAML::Key << "count" << YAML::Value << metrics->count << YAML::EndMap;
}

void EmitModes(const ErrorModes& modes, YAML::Emitter* out) {
  if (modes.displacements_px.empty()) return;
  *out << YAML::Key << "modes" << YAML::Value << YAML::BeginMap << YAML::Key
       << "columns" << YAML::Value << modes.columns << YAML::Key << "rows"
       << YAML::Value << modes.rows << YAML::Key << "rest_px" << YAML::Value
       << fmt::format("{:.6f}", modes.residual_px) << YAML::Key << "beyond"
       << YAML::Value << YAML::Flow << YAML::BeginMap << YAML::Key << "scale"
       << YAML::Value << fmt::format("{:.8f}", modes.excess_errors.scale)
       << YAML::Key << "shift_px" << YAML::Value
       << fmt::format("{:.6f}", modes.excess_errors.shift_px) << YAML::Key
       << "tilt_rad" << YAML::Value
       << fmt::format("{:.8f}", modes.excess_errors.tilt_rad) << YAML::Key
       << "local_px" << YAML::Value
       << fmt::format("{:.6f}", modes.excess_errors.local_px) << YAML::EndMap;
  EmitDisplacements(modes.displacements_px, out);
  *out << YAML::EndMap;
}

void EmitLattice(const CameraUncertainty& uncertainty, YAML::Emitter* out) {
  *out << YAML::Key << "uncertainty" << YAML::Value << YAML::BeginMap;
  EmitUncertaintyLattice(uncertainty.lattice, out);
  EmitModes(uncertainty.modes, out);
  *out << YAML::EndMap;
}

void EmitUncertainty(const CameraUncertainty& uncertainty, YAML::Emitter* out) {
  if (uncertainty.HasStdDevs()) EmitLattice(uncertainty, out);
  const ValidityMask& mask = uncertainty.mask;
  *out << YAML::Key << "trusted" << YAML::Value << YAML::BeginMap;
  if (uncertainty.HasStdDevs())
    *out << YAML::Key << "max_deviation_px" << YAML::Value
         << fmt::format("{:.6f}", uncertainty.max_stddev_px);
  *out << YAML::Key << "cell_px" << YAML::Value << mask.knot_spacing_px
       << YAML::Key << "cells" << YAML::Value << YAML::BeginSeq;
  for (int row = 0; row < mask.rows; ++row) {
    std::string text;
    for (int column = 0; column < mask.columns; ++column)
      text += mask.is_valid[row * mask.columns + column] ? '#' : '.';
    *out << YAML::DoubleQuoted << text;
  }
  *out << YAML::EndSeq << YAML::EndMap;
}

void EmitLineDelay(const LineDelay& line_delay, YAML::Emitter* out) {
  *out << YAML::Key << "row_time_us" << YAML::Value
       << fmt::format("{:.6f}", line_delay.seconds * 1e6);
  if (line_delay.stddev_s > 0)
    *out << YAML::Key << "row_time_deviation_us" << YAML::Value
         << fmt::format("{:.6f}", line_delay.stddev_s * 1e6);
}

void EmitPose(const Pose& pose, YAML::Emitter* out) {
  *out << YAML::Key << "camera_from_view" << YAML::Value
       << YAML::Load(FormatPose(pose, ""));
}

void EmitParameters(const ParametricModel& lens, Digits digits,
                    YAML::Emitter* out) {
  const auto number = [digits](double value) {
    return digits == Digits::kAll ? fmt::format("{}", value)
                                  : fmt::format("{:.12g}", value);
  };
  if (const auto* radial = dynamic_cast<const CentralRadial*>(&lens)) {
    *out << YAML::Key << "radial" << YAML::Value << YAML::BeginMap << YAML::Key
         << "max_angle_rad" << YAML::Value
         << fmt::format("{:.17g}", radial->max_angle_rad()) << YAML::Key
         << "spline" << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (const double value : radial->spline()) *out << number(value);
    *out << YAML::EndSeq << YAML::EndMap;
  }
  if (const auto* spline = dynamic_cast<const SplinedStereographic*>(&lens)) {
    const SplinedStereographic::Grid& grid = spline->grid();
    *out << YAML::Key << "spline" << YAML::Value << YAML::BeginMap << YAML::Key
         << "columns" << YAML::Value << grid.columns << YAML::Key << "rows"
         << YAML::Value << grid.rows << YAML::Key << "fov_x_deg" << YAML::Value
         << grid.fov_x_deg << YAML::Key << "control_points" << YAML::Value
         << YAML::Flow << YAML::BeginSeq;
    for (const Eigen::Vector2d& point : spline->surface().points())
      *out << number(point.x()) << number(point.y());
    *out << YAML::EndSeq << YAML::EndMap;
  }
  const std::vector<std::string>& names = lens.ParameterNames();
  const Eigen::VectorXd named = lens.Parameters().tail(names.size());
  *out << YAML::Key << "parameters" << YAML::Value << YAML::BeginMap;
  for (size_t k = 0; k < names.size(); ++k)
    *out << YAML::Key << names[k] << YAML::Value << number(named[k]);
  *out << YAML::EndMap;
}

// Writes the parameters of a grid, with the same number of values per control
// point.
void EmitGrid(const BSplineSurface& surface, const Eigen::VectorXd& parameters,
              YAML::Emitter* out) {
  *out << YAML::Key << "grid" << YAML::Value << YAML::Flow << YAML::BeginMap
       << YAML::Key << "columns" << YAML::Value << surface.columns()
       << YAML::Key << "rows" << YAML::Value << surface.rows() << YAML::Key
       << "chart" << YAML::Value << "stereographic" << YAML::EndMap;
  *out << YAML::Key << "control_points" << YAML::Value << YAML::BeginSeq;
  const Eigen::Index per_point = parameters.size() / surface.num_points();
  for (Eigen::Index first = 0; first < parameters.size(); first += per_point) {
    *out << YAML::Flow << YAML::BeginSeq;
    for (Eigen::Index k = first; k < first + per_point; ++k)
      *out << fmt::format("{:.12f}", parameters[k]);
    *out << YAML::EndSeq;
  }
  *out << YAML::EndSeq;
}

void EmitModel(const CameraModel& camera, Digits digits, YAML::Emitter* out) {
  if (const BSplineSurface* grid = camera.DirectionGrid())
    EmitGrid(*grid, camera.Parameters(), out);
  else
    EmitParameters(*camera.Parametric(), digits, out);
}

}  // namespace

CameraFile ReadCameraFile(const std::string& path) {
  return ParseCameraFile(path, ReadFile(path));
}

CameraFile ParseCameraFile(const std::string& path, const std::string& text) {
  RequireYamlFile(path, text);
  return ReadNamingFile(path, [&] { return Parse(YAML::Load(text)); });
}

std::string FormatCameraFile(const CameraFile& file, Digits digits) {
  const CameraModel& camera = *file.camera;
  const Area& area = camera.area();
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "raygrid_camera" << YAML::Value << 1
      << YAML::Key << "model" << YAML::Value << camera.Name();
  if (!file.name.empty())
    out << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << file.name
        << YAML::Auto;
  if (!file.serial.empty())
    out << YAML::Key << "serial" << YAML::Value << YAML::DoubleQuoted
        << file.serial << YAML::Auto;
  out << YAML::Key << "image_size" << YAML::Value << YAML::Flow
      << YAML::BeginSeq << camera.image_size().width
      << camera.image_size().height << YAML::EndSeq;
  out << YAML::Key << "area" << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const double edge : {area.x0, area.y0, area.x1, area.y1})
    out << fmt::format("{:.17g}", edge);
  out << YAML::EndSeq;
  if (const auto& circle = camera.image_circle())
    out << YAML::Key << "image_circle" << YAML::Value << YAML::Flow
        << YAML::BeginSeq << fmt::format("{:.3f}", circle->center.x())
        << fmt::format("{:.3f}", circle->center.y())
        << fmt::format("{:.3f}", circle->radii_px.x()) << YAML::EndSeq;
  if (file.training || file.held_out) {
    out << YAML::Key << "quality" << YAML::Value << YAML::BeginMap;
    if (!file.assessment.empty())
      out << YAML::Key << "verdict" << YAML::Value << file.assessment;
    EmitMetrics("training", file.training, &out);
    EmitMetrics("held_out", file.held_out, &out);
    out << YAML::EndMap;
  }
  if (file.uncertainty) EmitUncertainty(*file.uncertainty, &out);
  if (file.camera_from_view) EmitPose(*file.camera_from_view, &out);
  if (file.capture) EmitCapture(*file.capture, &out);
  if (file.spread) EmitPopulationCovariance(*file.spread, &out);
  if (file.stack) EmitOperatingPointModel(*file.stack, &out);
  if (file.line_delay) EmitLineDelay(*file.line_delay, &out);
  // The model, which is mandatory, is written last: truncated files are
  // invalid.
  EmitModel(camera, digits, &out);
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace raygrid
