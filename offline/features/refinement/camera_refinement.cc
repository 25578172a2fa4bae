#include "features/refinement/camera_refinement.h"

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "dataset/files.h"
#include "dataset/image_memory_budget.h"
#include "dataset/parallel_for.h"
#include "features/refinement/feature_refinement.h"

namespace raygrid {
namespace {

// Returns the target point at an offset from a feature, in squares.
Eigen::Vector3d OffsetPoint(const Board& board, const Feature& feature,
                            const Eigen::Vector2d& offset) {
  Eigen::Vector3d point =
      board.points[board.PointIndex(feature.column, feature.row)];
  point.head<2>() += board.square_m * offset;
  return point;
}

using PoseByView = std::map<std::pair<std::string, int>, Pose>;

PoseByView IndexByView(const std::vector<BoardPose>& poses) {
  PoseByView pose_by_view;
  for (const BoardPose& pose : poses)
    pose_by_view[{pose.image, pose.board}] = pose.camera_from_board;
  return pose_by_view;
}

class Refiner {
 public:
  Refiner(const EstimatedScene& scene, const DetectionOptions& options)
      : scene_(scene),
        options_(options),
        pose_by_view_(IndexByView(scene.poses)) {
    for (const Board& board : scene.pattern->boards)
      boards_.push_back(
          {&board, std::make_unique<FeatureRefiner>(board, options)});
  }

  bool HasPose(const std::string& image) const {
    return std::any_of(boards_.begin(), boards_.end(), [&](const auto& board) {
      return pose_by_view_.count({image, board.first->id}) > 0;
    });
  }

  ImageFeatures Refine(const GreyImage& image,
                       const ImageFeatures& measured) const {
    ImageFeatures refined = {measured.image, {}};
    for (const auto& [board, refiner] : boards_) {
      std::vector<Feature> features;
      for (const Feature& feature : measured.features)
        if (feature.board == board->id) features.push_back(feature);
      const auto pose = pose_by_view_.find({measured.image, board->id});
      if (pose != pose_by_view_.end())
        features = refiner->RefineWith(
            image, features, [this, &pose, b = board](const Feature& feature) {
              return ComputeCameraMapping(*scene_.camera, pose->second, *b,
                                          feature, options_.window_px);
            });
      refined.features.insert(refined.features.end(), features.begin(),
                              features.end());
    }
    return refined;
  }

 private:
  const EstimatedScene& scene_;
  const DetectionOptions& options_;
  PoseByView pose_by_view_;
  std::vector<std::pair<const Board*, std::unique_ptr<FeatureRefiner>>> boards_;
};

}  // namespace

std::optional<LocalMapping> ComputeCameraMapping(const CameraModel& camera,
                                                 const Pose& camera_from_board,
                                                 const Board& board,
                                                 const Feature& feature,
                                                 int window_px) {
  const auto project = [&](const Eigen::Vector2d& offset) {
    return camera.Project(
        camera_from_board * OffsetPoint(board, feature, offset), &feature.pixel,
        window_px);
  };
  // The linear part first, to determine how many squares the window covers.
  constexpr double kStep = 0.05;
  const auto x0 = project({-kStep, 0}), x1 = project({kStep, 0});
  const auto y0 = project({0, -kStep}), y1 = project({0, kStep});
  if (!x0 || !x1 || !y0 || !y1) return std::nullopt;
  Eigen::Matrix2d linear;
  linear << (*x1 - *x0) / (2 * kStep), (*y1 - *y0) / (2 * kStep);
  const Eigen::Matrix2d inverse = linear.inverse();
  if (!inverse.allFinite()) return std::nullopt;

  constexpr int kSteps = 3;  // from the centre to the window's edge
  constexpr int kDegree = 3;
  std::vector<Correspondence> around;
  for (int j = -kSteps; j <= kSteps; ++j) {
    for (int i = -kSteps; i <= kSteps; ++i) {
      const Eigen::Vector2d offset =
          inverse * (Eigen::Vector2d(i, j) * (0.5 * window_px / kSteps));
      if (const auto pixel = project(offset))
        around.push_back({offset, *pixel, 1});
    }
  }
  LocalMapping mapping;
  if (FitLocalMapping(around, kDegree, &mapping) < kDegree) return std::nullopt;
  mapping.center = feature.pixel;
  return mapping;
}

Dataset RefineFeaturesWithCamera(const std::vector<std::string>& paths,
                                 const Dataset& dataset,
                                 const EstimatedScene& scene,
                                 const DetectionOptions& options,
                                 int num_threads,
                                 const std::function<void(double)>& progress) {
  const Refiner refiner(scene, options);
  Dataset refined = dataset;
  const int count = static_cast<int>(paths.size());
  std::mutex mutex;
  int num_done = 0;
  ParallelFor(count, NumThreads(num_threads), [&](int i) {
    if (!dataset.images[i].features.empty() &&
        !refiner.HasPose(dataset.images[i].image)) {
      refined.images[i] = refiner.Refine({}, dataset.images[i]);
    } else if (!dataset.images[i].features.empty()) {
      const ImageMemoryBudget room(dataset.image_size);
      refined.images[i] = refiner.Refine(
          MakeGreyImage(ReadGreyLevels(paths[i])), dataset.images[i]);
    }
    const std::lock_guard<std::mutex> lock(mutex);
    if (progress) progress(static_cast<double>(++num_done) / count);
  });
  return refined;
}

}  // namespace raygrid
