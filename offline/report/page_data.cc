#include "report/page_data.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "camera/bspline_surface.h"
#include "report/html.h"

namespace raygrid {
namespace {

using Json = nlohmann::ordered_json;
using Residuals = std::vector<FeatureResidual>;

// The maximum number of residuals in a page; beyond it, the residuals of each
// image are subsampled evenly.
constexpr size_t kMaxResiduals = 600000;
constexpr size_t kMaxBoards = 300;

double Rounded(double value) {
  return std::isfinite(value) ? std::round(value * 1e6) / 1e6 : 0;
}

// ---- Residuals -------------------------------------------------------------

using ResidualsByImage =
    std::map<std::string, std::vector<const FeatureResidual*>>;

ResidualsByImage GroupByImage(const Residuals& residuals) {
  ResidualsByImage images;
  for (const FeatureResidual& residual : residuals)
    images[residual.image].push_back(&residual);
  return images;
}

void Append(double value, double quantum, std::string* bytes) {
  const auto number = static_cast<int16_t>(
      std::clamp(std::lround(value / quantum), -32767L, 32767L));
  const auto bits = static_cast<uint16_t>(number);
  *bytes += static_cast<char>(bits & 255);
  *bytes += static_cast<char>(bits >> 8);
}

// x, y, dx, dy as little-endian 16-bit integers, image by image.
struct PackedResiduals {
  std::string bytes;
  size_t count = 0;
  double position_px = 1, error_px = 1;  // scale of the integers
};

Json AddImages(const ResidualsByImage& images, const char* set, size_t step,
               PackedResiduals* packed, Json* list) {
  for (const auto& [name, residuals] : images) {
    std::vector<double> norms;
    const size_t first = packed->count;
    for (size_t i = 0; i < residuals.size(); ++i) {
      const FeatureResidual& r = *residuals[i];
      norms.push_back(r.error_px.norm());
      if (i % step != 0) continue;
      Append(r.pixel.x(), packed->position_px, &packed->bytes);
      Append(r.pixel.y(), packed->position_px, &packed->bytes);
      Append(r.error_px.x(), packed->error_px, &packed->bytes);
      Append(r.error_px.y(), packed->error_px, &packed->bytes);
      ++packed->count;
    }
    Json& entry = (*list)[name];
    entry[set] = {{"first", first},
                  {"count", packed->count - first},
                  {"median", Rounded(Quantile(norms, 0.5))},
                  {"max", Rounded(Quantile(norms, 1))}};
  }
  return *list;
}

double ComputeMaxComponent(const Residuals& residuals) {
  double largest = 0;
  for (const FeatureResidual& residual : residuals)
    largest = std::max(largest, residual.error_px.cwiseAbs().maxCoeff());
  return largest;
}

void AddResiduals(const CalibrationResult& result, Json* json) {
  const ImageSize& size = result.camera.camera->image_size();
  PackedResiduals packed;
  packed.position_px = std::max(size.width, size.height) / 32000.0;
  packed.error_px =
      std::max({ComputeMaxComponent(result.training),
                ComputeMaxComponent(result.held_out),
                ComputeMaxComponent(result.rejected_features), 1e-6}) /
      32000;
  const size_t total = result.training.size() + result.held_out.size();
  const size_t step = total / kMaxResiduals + 1;
  Json list = Json::object();
  AddImages(GroupByImage(result.training), "training", step, &packed, &list);
  AddImages(GroupByImage(result.held_out), "held_out", step, &packed, &list);
  AddImages(GroupByImage(result.rejected_features), "rejected", 1, &packed,
            &list);
  Json images = Json::array();
  for (auto& [name, entry] : list.items()) {
    entry["name"] = name;
    images.push_back(entry);
  }
  std::sort(images.begin(), images.end(), [](const Json& a, const Json& b) {
    return a["name"].get<std::string>() < b["name"].get<std::string>();
  });
  (*json)["images"] = std::move(images);
  (*json)["step"] = step;
  (*json)["position_px"] = packed.position_px;
  (*json)["error_px"] = packed.error_px;
  (*json)["residuals"] = Base64(packed.bytes);
}

// Returns the quantiles of the residuals' norms, from 0 to 99.5 %.
Json Quantiles(const Residuals& residuals) {
  std::vector<double> norms;
  for (const FeatureResidual& residual : residuals)
    norms.push_back(residual.error_px.norm());
  std::sort(norms.begin(), norms.end());
  Json quantiles = Json::array();
  for (int k = 0; k < 200 && !norms.empty(); ++k)
    quantiles.push_back(
        Rounded(norms[static_cast<size_t>(k / 200.0 * (norms.size() - 1))]));
  return quantiles;
}

// ---- Camera ----------------------------------------------------------------

// Returns the number of features that depend on each control point.
std::vector<int> CountFeaturesByControlPoint(const BSplineSurface& surface,
                                             const Residuals& residuals) {
  const int columns = surface.columns(), rows = surface.rows();
  const Area& area = surface.area();
  std::vector<int> counts(surface.num_points(), 0);
  for (const FeatureResidual& residual : residuals) {
    const int column = std::clamp(
        static_cast<int>((residual.pixel.x() - area.x0) / surface.cell_width()),
        0, columns - 4);
    const int row = std::clamp(static_cast<int>((residual.pixel.y() - area.y0) /
                                                surface.cell_height()),
                               0, rows - 4);
    for (int k = 0; k < 16; ++k)
      ++counts[(row + k / 4) * columns + column + k % 4];
  }
  return counts;
}

void AddGrid(const CalibrationResult& result, Json* json) {
  const BSplineSurface* surface = result.camera.camera->DirectionGrid();
  if (!surface) return;
  Json angles = Json::array();
  for (const Eigen::Vector2d& point : surface->points())
    angles.push_back(
        std::round(2 * std::atan(point.norm()) * 180 / M_PI * 100) / 100);
  (*json)["grid"] = {
      {"columns", surface->columns()},
      {"rows", surface->rows()},
      {"cell", {surface->cell_width(), surface->cell_height()}},
      {"angle_deg", angles},
      {"support", CountFeaturesByControlPoint(*surface, result.training)}};
}

// Adds the distance of observation lines from the point closest to all of them,
// by their angle.
void AddLines(const CameraModel& camera, Json* json) {
  if (camera.IsCentral()) return;
  constexpr int kSteps = 24;
  const Eigen::Vector3d center = ComputeNoncentrality(camera).nearest_point;
  Json lines = Json::array();
  const Area& area = camera.area();
  for (int k = 0; k < (kSteps + 1) * (kSteps + 1); ++k) {
    const auto line =
        camera.Line({area.x0 + area.width() * (k % (kSteps + 1)) / kSteps,
                     area.y0 + area.height() * (k / (kSteps + 1)) / kSteps});
    if (!line) continue;
    const double angle = std::acos(std::clamp(line->direction.z(), -1.0, 1.0));
    const double distance_m =
        line->direction.cross(line->origin - center).norm();
    lines.push_back({Rounded(angle * 180 / M_PI), Rounded(1000 * distance_m)});
  }
  (*json)["lines"] = std::move(lines);
}

// ---- Poses -----------------------------------------------------------------

Json Vector(const Eigen::Vector3d& v) {
  return {Rounded(v.x()), Rounded(v.y()), Rounded(v.z())};
}

// Returns the corners of the rectangle of a board's features.
std::vector<Eigen::Vector3d> BoardCorners(const Board& board) {
  if (board.IsPointSet() || board.points.empty()) {
    Eigen::Vector3d low = board.points[0], high = board.points[0];
    for (const Eigen::Vector3d& point : board.points) {
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
    return {low, {high.x(), low.y(), low.z()}, high, {low.x(), high.y(), 0}};
  }
  const int right = board.columns - 1, bottom = board.rows - 1;
  return {board.points[board.PointIndex(0, 0)],
          board.points[board.PointIndex(right, 0)],
          board.points[board.PointIndex(right, bottom)],
          board.points[board.PointIndex(0, bottom)]};
}

Json MakeCameraJson(const CameraModel& camera, const std::string& name,
                    const Pose& rig_from_camera) {
  const Area& area = camera.area();
  Json rays = Json::array();
  for (const Eigen::Vector2d& pixel :
       {Eigen::Vector2d(area.x0, area.y0), Eigen::Vector2d(area.x1, area.y0),
        Eigen::Vector2d(area.x1, area.y1), Eigen::Vector2d(area.x0, area.y1)}) {
    const auto direction = camera.Unproject(pixel);
    if (direction)
      rays.push_back(Vector(rig_from_camera.rotation * *direction));
  }
  return {{"name", name},
          {"center", Vector(rig_from_camera.translation)},
          {"rays", rays}};
}

// Adds each board once per frame, in the pose from the first camera that
// observed it.
void AddBoards(const CalibrationResult& camera, const Pattern& pattern,
               const Pose& rig_from_camera,
               std::map<std::pair<std::string, int>, Json>* boards) {
  std::set<std::string> used;  // near-duplicates would overlap
  for (const ImageFeatures& image : camera.features.images)
    used.insert(image.image);
  for (const BoardPose& pose : camera.poses) {
    const Board* board = pattern.FindBoard(pose.board);
    if (!board || used.count(pose.image) == 0 ||
        boards->count({pose.image, pose.board}))
      continue;
    Json corners = Json::array();
    for (const Eigen::Vector3d& corner : BoardCorners(*board))
      corners.push_back(
          Vector(rig_from_camera * (pose.camera_from_board * corner)));
    (*boards)[{pose.image, pose.board}] = {{"name", pose.image},
                                           {"corners", corners}};
  }
}

Json MakeSceneJson(const Json& cameras,
                   const std::map<std::pair<std::string, int>, Json>& boards) {
  const size_t step = boards.size() / kMaxBoards + 1;
  Json shown = Json::array();
  size_t index = 0;
  for (const auto& [key, board] : boards)
    if (index++ % step == 0) shown.push_back(board);
  return {{"cameras", cameras}, {"boards", shown}, {"all", boards.size()}};
}

}  // namespace

std::string FormatPageData(const CalibrationResult& result,
                           const ThumbnailTexts& thumbnails) {
  const CameraModel& camera = *result.camera.camera;
  const Area& area = camera.area();
  Json json;
  json["size"] = {camera.image_size().width, camera.image_size().height};
  json["area"] = {area.x0, area.y0, area.x1, area.y1};
  AddResiduals(result, &json);
  if (!thumbnails.empty()) json["thumbnails"] = thumbnails;
  json["quantiles"] = {{"training", Quantiles(result.training)},
                       {"held_out", Quantiles(result.held_out)}};
  AddGrid(result, &json);
  AddLines(camera, &json);
  std::map<std::pair<std::string, int>, Json> boards;
  AddBoards(result, result.pattern, {}, &boards);
  json["space"] = MakeSceneJson(
      Json::array({MakeCameraJson(camera, result.camera.name, {})}), boards);
  return json.dump();
}

std::string FormatPageData(const RigResult& result) {
  std::map<std::pair<std::string, int>, Json> boards;
  Json cameras = Json::array();
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const Pose rig_from_camera = result.camera_from_rig[c].Inverse();
    const CalibrationResult& camera = result.cameras[c];
    AddBoards(camera, result.pattern, rig_from_camera, &boards);
    cameras.push_back(MakeCameraJson(*camera.camera.camera, camera.camera.name,
                                     rig_from_camera));
  }
  Json json;
  json["space"] = MakeSceneJson(cameras, boards);
  return json.dump();
}

}  // namespace raygrid
