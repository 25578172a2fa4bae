#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "adjustment/bundle_adjustment.h"
#include "dataset/error.h"
#include "evaluation/residual_statistics.h"
#include "experiments/calibrated_cameras.h"
#include "simulation/random.h"

namespace raygrid {
namespace {

// A walk along a corridor that bends to and fro.
constexpr int kFrames = 120, kPoints = 1500;
constexpr double kStepM = 0.1, kReachM = 6, kMinDepthM = 0.7;
constexpr double kNoisePx = 0.3;  // of features of natural scenes
constexpr int kFirstFrames = 12;  // which the paths are aligned by

const ModelChoice kChoices[] = {
    {"opencv", 0}, {"thin-prism-fisheye", 0}, {"central-generic", 16}};

struct Walk {
  std::vector<Pose> camera_from_world;
  std::vector<Eigen::Vector3d> points;
  std::vector<View> views;
};

std::vector<Pose> MakePath() {
  std::vector<Pose> path;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int i = 0; i < kFrames; ++i) {
    const double yaw = 0.4 * std::sin(2 * M_PI * i / 60);
    const Eigen::Quaterniond world_from_camera(
        Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(0.03 * std::sin(0.9 * i), Eigen::Vector3d::UnitX()));
    path.push_back(Pose{world_from_camera, position}.Inverse());
    position += kStepM * (world_from_camera * Eigen::Vector3d::UnitZ());
  }
  return path;
}

// Things on the walls, floor and ceiling around the path.
std::vector<Eigen::Vector3d> MakePoints(const std::vector<Pose>& path,
                                        Random* random) {
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < kPoints; ++k) {
    const int frame = random->Index(static_cast<int>(path.size()));
    const double angle = random->Uniform(0, 2 * M_PI);
    const double radius = random->Uniform(0.8, 2);
    const Eigen::Vector3d place(radius * std::cos(angle),
                                0.7 * radius * std::sin(angle),
                                random->Uniform(0, kReachM));
    points.push_back(path[frame].Inverse() * place);
  }
  return points;
}

Walk MakeWalk(const CameraModel& truth, const Area& area, uint64_t seed) {
  Random random(seed);
  Walk walk;
  walk.camera_from_world = MakePath();
  walk.points = MakePoints(walk.camera_from_world, &random);
  for (int i = 0; i < kFrames; ++i) {
    View view;
    view.pose = i;
    for (int k = 0; k < kPoints; ++k) {
      const Eigen::Vector3d point = walk.camera_from_world[i] * walk.points[k];
      if (point.z() < kMinDepthM || point.z() > kReachM) continue;
      const auto pixel = truth.Project(point);
      if (!pixel) continue;
      const Eigen::Vector2d seen =
          *pixel + kNoisePx * Eigen::Vector2d(random.Normal(), random.Normal());
      if (area.Contains(seen, -2)) view.observations.push_back({k, seen});
    }
    walk.views.push_back(std::move(view));
  }
  return walk;
}

struct Drift {
  double end_percent = 0;  // of the path's length
  double median_px = 0;    // residuals
};

std::vector<Eigen::Vector3d> CentersOf(const std::vector<Pose>& path) {
  std::vector<Eigen::Vector3d> centers;
  for (const Pose& pose : path) centers.push_back(pose.Inverse().translation);
  return centers;
}

// How far the last place is from the truth when the first ones are brought
// together by a similarity.
double EndErrorPercent(const std::vector<Eigen::Vector3d>& found,
                       const std::vector<Eigen::Vector3d>& truth) {
  Eigen::Matrix3Xd from(3, kFirstFrames), to(3, kFirstFrames);
  for (int i = 0; i < kFirstFrames; ++i) {
    from.col(i) = found[i];
    to.col(i) = truth[i];
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(from, to, true);
  const Eigen::Vector3d end =
      (similarity * found.back().homogeneous()).head<3>();
  return 100 * (end - truth.back()).norm() / (kStepM * (kFrames - 1));
}

// The first pose is known, and a little of where points are: nothing else tells
// where the whole is, and how large.
Drift AdjustWalk(const CameraModel& camera, const Walk& walk,
                 const ExperimentOptions& options) {
  constexpr double kWeakWeight = 1e-4;
  AdjustmentState state;
  state.SetCamera(camera);
  state.rig_from_pattern = walk.camera_from_world;
  state.points = walk.points;
  GaussianPrior prior;
  prior.points_mean = walk.points;
  prior.points_weight = kWeakWeight;
  AdjustmentOptions adjustment;
  adjustment.fix_cameras = true;
  adjustment.num_threads = options.num_threads;
  adjustment.max_iterations = 100;
  const AdjustmentSummary summary =
      AdjustBundle(walk.views, prior, adjustment, &state);
  Drift drift;
  drift.end_percent = EndErrorPercent(CentersOf(state.rig_from_pattern),
                                      CentersOf(walk.camera_from_world));
  std::vector<double> norms;
  for (const Residual& residual : summary.residuals)
    if (residual.valid) norms.push_back(residual.error_px.norm());
  drift.median_px = Quantile(norms, 0.5);
  return drift;
}

}  // namespace

ExperimentResult MeasureTrajectoryDrift(const ExperimentOptions& options) {
  constexpr int kWalks = 3;
  const ExperimentFeatures features = FeaturesFor(options);
  struct NamedCamera {
    std::string name;
    std::shared_ptr<const CameraModel> model;
  };
  std::vector<NamedCamera> cameras;
  for (const ModelChoice& choice : kChoices)
    cameras.push_back(
        {choice.model,
         CalibrateModel(features, choice, options).camera.camera});
  std::shared_ptr<const CameraModel> truth = features.truth;
  if (truth) {
    cameras.push_back({"truth", truth});
  } else {
    truth = cameras.back().model;
    cameras.back().name += " (the truth here)";
  }
  if (options.progress) options.progress(0.3);

  ExperimentResult table;
  table.conditions = features.conditions;
  table.conditions.push_back(
      {"walk",
       fmt::format("{} images, {:g} m apart, {} points, {:g} px of "
                   "noise in an axis; bundle adjustment from the truth, "
                   "intrinsics fixed",
                   kFrames, kStepM, kPoints, kNoisePx)});
  table.conditions.push_back(
      {"error", fmt::format("of the last place, of the path's length, with the "
                            "first {} brought together by a similarity",
                            kFirstFrames)});
  table.columns = {"camera", "walk", "residual_median_px", "end_error_percent"};
  table.chart.title = "Error at the end of a walk";
  table.chart.note = "intrinsics fixed at those of each calibration";
  table.chart.x_label = "walk (its noise and points)";
  table.chart.y_label = "error of the last place, % of the path";
  table.chart.is_logarithmic = true;
  for (int k = 0; k < kWalks; ++k)
    table.chart.ticks.push_back({double(k), std::to_string(k + 1)});
  for (const NamedCamera& camera : cameras)
    table.chart.series.push_back({camera.name, {}, false});
  Area area = truth->area();
  for (const NamedCamera& camera : cameras) {
    const Area& own = camera.model->area();
    area = {std::max(area.x0, own.x0), std::max(area.y0, own.y0),
            std::min(area.x1, own.x1), std::min(area.y1, own.y1)};
  }
  for (int k = 0; k < kWalks; ++k) {
    const Walk walk = MakeWalk(*truth, area, options.seed * 31 + k + 1);
    for (size_t c = 0; c < cameras.size(); ++c) {
      const Drift drift = AdjustWalk(*cameras[c].model, walk, options);
      table.rows.push_back(
          {cameras[c].name, k + 1, drift.median_px, drift.end_percent});
      table.chart.series[c].points.push_back({double(k), drift.end_percent});
    }
    if (options.progress) options.progress(0.3 + 0.7 * (k + 1) / kWalks);
  }
  return table;
}

}  // namespace raygrid
