#include "calibration/calibration_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "dataset/parallel_for.h"

namespace raygrid {
namespace {

CalibrationProblem EmptyProblem(const std::vector<Dataset>& cameras,
                                const Pattern& pattern) {
  CalibrationProblem problem;
  for (const Dataset& dataset : cameras)
    problem.image_sizes.push_back(dataset.image_size);
  for (const Board& board : pattern.boards) {
    problem.first_points.push_back(static_cast<int>(problem.nominal.size()));
    problem.nominal.insert(problem.nominal.end(), board.points.begin(),
                           board.points.end());
  }
  return problem;
}

std::vector<Observation> MakeObservations(const Board& board, int first_point,
                                          const ImageFeatures& image) {
  std::vector<Observation> observations;
  for (const Feature& feature : image.features)
    if (feature.board == board.id)
      observations.push_back(
          {first_point + board.PointIndex(feature.column, feature.row),
           feature.pixel});
  return observations;
}

}  // namespace

Feature CalibrationProblem::GetFeature(const Pattern& pattern, int view,
                                       const Observation& observation) const {
  const Board& board = pattern.boards[boards[view]];
  const int index = observation.point - first_points[boards[view]];
  return {board.id, index % board.columns, index / board.columns,
          observation.pixel};
}

CalibrationProblem BuildProblem(const std::vector<Dataset>& cameras,
                                const Pattern& pattern,
                                std::vector<RejectedImage>* rejected) {
  CalibrationProblem problem = EmptyProblem(cameras, pattern);
  std::map<std::pair<std::string, size_t>, int> pose_indices;
  for (size_t c = 0; c < cameras.size(); ++c) {
    for (const ImageFeatures& image : cameras[c].images) {
      bool used = false;
      for (size_t b = 0; b < pattern.boards.size(); ++b) {
        View view;
        view.observations =
            MakeObservations(pattern.boards[b], problem.first_points[b], image);
        if (view.observations.size() < kMinViewFeatures) continue;
        view.camera = static_cast<int>(c);
        view.pose =
            pose_indices.emplace(std::pair(image.image, b), pose_indices.size())
                .first->second;
        problem.views.push_back(std::move(view));
        problem.images.push_back(image.image);
        problem.boards.push_back(static_cast<int>(b));
        used = true;
      }
      if (!used)
        rejected->push_back(
            {image.image,
             fmt::format("only {} features", image.features.size()), true});
    }
  }
  problem.num_poses = static_cast<int>(pose_indices.size());
  return problem;
}

void RemoveViews(const std::vector<bool>& remove, CalibrationProblem* problem) {
  size_t kept = 0;
  for (size_t v = 0; v < problem->views.size(); ++v) {
    if (remove[v]) continue;
    if (kept != v) problem->views[kept] = std::move(problem->views[v]);
    problem->images[kept] = problem->images[v];
    problem->boards[kept] = problem->boards[v];
    ++kept;
  }
  problem->views.resize(kept);
  problem->images.resize(kept);
  problem->boards.resize(kept);
  std::map<int, int> new_pose;
  for (View& view : problem->views)
    view.pose = new_pose.emplace(view.pose, new_pose.size()).first->second;
  problem->num_poses = static_cast<int>(new_pose.size());
}

std::vector<Eigen::Vector2d> ObservedPixels(const CalibrationProblem& problem,
                                            int camera) {
  std::vector<Eigen::Vector2d> pixels;
  for (const View& view : problem.views)
    if (view.camera == camera)
      for (const Observation& observation : view.observations)
        pixels.push_back(observation.pixel);
  return pixels;
}

Area ComputeFeatureArea(const CalibrationProblem& problem, int camera) {
  Area area = {1e9, 1e9, -1e9, -1e9};
  for (const View& view : problem.views) {
    if (view.camera != camera) continue;
    for (const Observation& observation : view.observations)
      area.Extend(observation.pixel);
  }
  constexpr double kUnit = 65536;
  return {
      std::floor(area.x0 * kUnit) / kUnit, std::floor(area.y0 * kUnit) / kUnit,
      std::ceil(area.x1 * kUnit) / kUnit, std::ceil(area.y1 * kUnit) / kUnit};
}

Area ComputeCalibratedArea(const CalibrationProblem& problem, int camera) {
  return problem.area == AreaChoice::kFeatures
             ? ComputeFeatureArea(problem, camera)
             : WholeImage(problem.image_sizes[camera]);
}

DeformationModes GetDeformationModes(const CalibrationProblem& problem) {
  std::vector<BoardPoints> boards;
  for (size_t b = 0; b < problem.first_points.size(); ++b) {
    const auto first = problem.nominal.begin() + problem.first_points[b];
    const auto end = b + 1 < problem.first_points.size()
                         ? problem.nominal.begin() + problem.first_points[b + 1]
                         : problem.nominal.end();
    boards.push_back({problem.first_points[b], {first, end}});
  }
  return MakeDeformationModes(boards, static_cast<int>(problem.nominal.size()));
}

std::vector<PointPixelMatch> MakeMatches(
    const View& view, const std::vector<Eigen::Vector3d>& points) {
  std::vector<PointPixelMatch> matches;
  for (const Observation& observation : view.observations)
    matches.push_back({points[observation.point], observation.pixel});
  return matches;
}

std::vector<std::optional<Pose>> LocalizeViews(
    const CameraModel& camera, int camera_index,
    const CalibrationProblem& problem, int num_threads) {
  const int num_views = static_cast<int>(problem.views.size());
  std::vector<std::optional<Pose>> poses(num_views);
  ParallelFor(num_views, NumThreads(num_threads), [&](int v) {
    if (problem.views[v].camera == camera_index)
      poses[v] =
          Localize(camera, MakeMatches(problem.views[v], problem.nominal));
  });
  return poses;
}

}  // namespace raygrid
