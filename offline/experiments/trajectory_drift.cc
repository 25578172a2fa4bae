#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "adjustment/bundle_adjustment.h"
#include "dataset/error.h"
#include "evaluation/residual_statistics.h"
#include "experiments/calibrated_cameras.h"
#include "simulation/random.h"

namespace raygrid {
namespace {

// A trajectory along a winding corridor.
constexpr int kTrajectoryFrames = 120, kPoints = 1500;
constexpr double kStepM = 0.1, kMaxObservationDistanceM = 6, kMinDepthM = 0.7;
constexpr double kNoisePx = 0.3;  // typical for features of natural scenes
constexpr int kFirstFrames = 12;  // for alignment of the paths

// The errors of the initial trajectory, as accumulated by odometry: rotation
// about each axis, relative translation and scale errors of each step; and
// depth errors of points. Standard deviations.
constexpr double kRotationDeg = 0.1, kStepFraction = 0.02,
                 kScaleFraction = 0.005;
constexpr double kDepthFraction = 0.05;
constexpr int kNumStarts = 2;

// For the user's features, the last model is the paper's reference.
std::vector<std::string> DriftModels() {
  return ListModelNames(ModelUse::kAuto,
                        {models::kCentralGeneric, models::kNonCentralGeneric});
}

struct Trajectory {
  std::vector<Pose> camera_from_world;
  std::vector<Eigen::Vector3d> points;
  std::vector<View> views;

  double Length() const;
};

std::vector<Eigen::Vector3d> GetCenters(const std::vector<Pose>& path) {
  std::vector<Eigen::Vector3d> centers;
  for (const Pose& pose : path) centers.push_back(pose.Inverse().translation);
  return centers;
}

double Trajectory::Length() const {
  const std::vector<Eigen::Vector3d> centers = GetCenters(camera_from_world);
  double length = 0;
  for (size_t i = 1; i < centers.size(); ++i)
    length += (centers[i] - centers[i - 1]).norm();
  return length;
}

std::vector<Pose> MakePath() {
  std::vector<Pose> path;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int i = 0; i < kTrajectoryFrames; ++i) {
    const double yaw = 0.4 * std::sin(2 * M_PI * i / 60);
    const Eigen::Quaterniond world_from_camera(
        Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(0.03 * std::sin(0.9 * i), Eigen::Vector3d::UnitX()));
    path.push_back(Pose{world_from_camera, position}.Inverse());
    position += kStepM * (world_from_camera * Eigen::Vector3d::UnitZ());
  }
  return path;
}

// Returns points on the walls, floor and ceiling around the path.
std::vector<Eigen::Vector3d> MakePoints(const std::vector<Pose>& path,
                                        Random* random) {
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < kPoints; ++k) {
    const int frame = random->Index(static_cast<int>(path.size()));
    const double angle = random->Uniform(0, 2 * M_PI);
    const double radius = random->Uniform(0.8, 2);
    const Eigen::Vector3d place(radius * std::cos(angle),
                                0.7 * radius * std::sin(angle),
                                random->Uniform(0, kMaxObservationDistanceM));
    points.push_back(path[frame].Inverse() * place);
  }
  return points;
}

constexpr size_t kMinObserved = 8;  // points per image

Trajectory SimulateTrajectory(const ComparedCameras& compared, uint64_t seed) {
  const CameraModel& truth = compared.truth();
  const Area area = ComputeCommonArea(compared.cameras);
  Random random(seed);
  Trajectory trajectory;
  trajectory.camera_from_world = MakePath();
  trajectory.points = MakePoints(trajectory.camera_from_world, &random);
  for (int i = 0; i < kTrajectoryFrames; ++i) {
    View view;
    view.pose = i;
    for (int k = 0; k < kPoints; ++k) {
      const Eigen::Vector3d point =
          trajectory.camera_from_world[i] * trajectory.points[k];
      if (point.z() < kMinDepthM || point.z() > kMaxObservationDistanceM)
        continue;
      const auto pixel = truth.Project(point);
      if (!pixel) continue;
      const Eigen::Vector2d seen =
          *pixel + kNoisePx * Eigen::Vector2d(random.Normal(), random.Normal());
      if (area.Contains(seen, -2) && AreAllDefined(compared, seen))
        view.observations.push_back({k, seen});
    }
    if (view.observations.size() < kMinObserved)
      throw Error(ExitCode::kInsufficientData,
                  "trajectory-drift: the common valid region of the cameras is "
                  "too small; calibrate from more images");
    trajectory.views.push_back(std::move(view));
  }
  return trajectory;
}

// Returns the user's trajectory, without observations outside the area of any
// camera.
Trajectory MakeTrajectory(const ColmapModel& model, const Area& area) {
  Trajectory trajectory;
  trajectory.points = model.points;
  std::vector<int> num_seen(model.points.size(), 0);
  for (const ColmapModel::Image& image : model.images)
    for (const auto& observation : image.observations)
      num_seen[observation.point] += area.Contains(observation.pixel);
  for (const ColmapModel::Image& image : model.images) {
    View view;
    for (const auto& observation : image.observations)
      if (area.Contains(observation.pixel) && num_seen[observation.point] > 1)
        view.observations.push_back({observation.point, observation.pixel});
    if (view.observations.size() < kMinObserved) continue;
    view.pose = static_cast<int>(trajectory.camera_from_world.size());
    trajectory.camera_from_world.push_back(image.camera_from_world);
    trajectory.views.push_back(std::move(view));
  }
  if (static_cast<int>(trajectory.views.size()) < 2 * kFirstFrames)
    throw Error(
        ExitCode::kInsufficientData,
        fmt::format("--colmap-model: only {} images have at least {} points in "
                    "the calibrated area; at least {} are required",
                    trajectory.views.size(), kMinObserved, 2 * kFirstFrames));
  return trajectory;
}

// ---- Initialization --------------------------------------------------------

// The poses and points before or after optimization.
struct Reconstruction {
  std::vector<Pose> camera_from_world;
  std::vector<Eigen::Vector3d> points;
};

struct AdjustmentResult : Reconstruction {
  double median_px = 0;  // residuals
  bool converged = false;
};

Eigen::Vector3d RandomVector(Random* random) {
  const double x = random->Normal(), y = random->Normal();
  return {x, y, random->Normal()};
}

// Returns the trajectory with accumulated errors. Points are displaced with the
// first image that observes them.
Reconstruction PerturbedStart(const Trajectory& trajectory, uint64_t seed) {
  Random random(seed);
  const double turn_rad = kRotationDeg * M_PI / 180;
  Reconstruction start = {{trajectory.camera_from_world[0]}, trajectory.points};
  std::vector<bool> is_perturbed(trajectory.points.size(), false);
  double scale = 1;
  for (size_t i = 0; i < trajectory.views.size(); ++i) {
    const Pose& pose = trajectory.camera_from_world[i];
    if (i > 0) {
      Pose step = pose * trajectory.camera_from_world[i - 1].Inverse();
      step.rotation =
          RotationFromVector(turn_rad * RandomVector(&random)) * step.rotation;
      scale *= std::exp(kScaleFraction * random.Normal());
      step.translation =
          scale * (step.translation + kStepFraction * step.translation.norm() *
                                          RandomVector(&random));
      start.camera_from_world.push_back(step * start.camera_from_world.back());
    }
    const Pose world_from_camera = start.camera_from_world.back().Inverse();
    for (const Observation& observation : trajectory.views[i].observations) {
      if (is_perturbed[observation.point]) continue;
      is_perturbed[observation.point] = true;
      const double depth = scale * std::exp(kDepthFraction * random.Normal());
      start.points[observation.point] =
          world_from_camera *
          (depth * (pose * trajectory.points[observation.point]));
    }
  }
  return start;
}

// ---- Optimization ----------------------------------------------------------

// Bundle adjustment: gauge and scale are constrained only by the weak prior of
// the points.
AdjustmentResult OptimizeTrajectory(const CameraModel& camera,
                                    const Trajectory& trajectory,
                                    const Reconstruction& start,
                                    const ExperimentOptions& options) {
  constexpr double kWeakPx = 0.01;  // for a shift by the path's length
  AdjustmentState state;
  state.SetCamera(camera);
  state.rig_from_pattern = start.camera_from_world;
  state.points = start.points;
  GaussianPrior prior;
  prior.points_mean = start.points;
  prior.points_precision = std::pow(kWeakPx / trajectory.Length(), 2);
  AdjustmentOptions adjustment;
  adjustment.fix_cameras = true;
  adjustment.num_threads = options.num_threads;
  const AdjustmentSummary summary =
      RunBundleAdjustment(trajectory.views, prior, adjustment, &state);
  std::vector<double> norms;
  for (const Residual& residual : summary.residuals)
    if (residual.valid) norms.push_back(residual.error_px.norm());
  return {{state.rig_from_pattern, state.points},
          Quantile(norms, 0.5),
          summary.converged};
}

// ---- End-point error -------------------------------------------------------

// Returns the distance between the end points of two trajectories, relative to
// their length, after aligning corresponding points by a similarity transform
// (Umeyama, 1991).
double EndErrorPercent(const Trajectory& trajectory,
                       const std::vector<Pose>& path,
                       const std::vector<Pose>& reference,
                       const std::vector<Eigen::Vector3d>& from,
                       const std::vector<Eigen::Vector3d>& to) {
  Eigen::Matrix3Xd a(3, from.size()), b(3, to.size());
  for (size_t i = 0; i < from.size(); ++i) {
    a.col(static_cast<Eigen::Index>(i)) = from[i];
    b.col(static_cast<Eigen::Index>(i)) = to[i];
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(a, b, true);
  const Eigen::Vector3d end =
      (similarity * GetCenters(path).back().homogeneous()).head<3>();
  return 100 * (end - GetCenters(reference).back()).norm() /
         trajectory.Length();
}

// Returns the end-point error relative to the ground truth, after aligning the
// first poses.
double EndErrorPercent(const Reconstruction& found, const Trajectory& truth) {
  std::vector<Eigen::Vector3d> from = GetCenters(found.camera_from_world),
                               to = GetCenters(truth.camera_from_world);
  from.resize(kFirstFrames);
  to.resize(kFirstFrames);
  return EndErrorPercent(truth, found.camera_from_world,
                         truth.camera_from_world, from, to);
}

// Returns the difference of the end point from that of another optimization of
// the same noisy observations, after aligning the points in the first images,
// which constrain the similarity better than camera positions that may be
// collinear.
double EndDifferencePercent(const Reconstruction& found,
                            const Reconstruction& reference,
                            const Trajectory& trajectory) {
  std::set<int> seen;
  for (int i = 0; i < kFirstFrames; ++i)
    for (const Observation& observation : trajectory.views[i].observations)
      seen.insert(observation.point);
  std::vector<Eigen::Vector3d> from, to;
  for (const int point : seen) {
    from.push_back(found.points[point]);
    to.push_back(reference.points[point]);
  }
  return EndErrorPercent(trajectory, found.camera_from_world,
                         reference.camera_from_world, from, to);
}

// ---- Experiment ------------------------------------------------------------

// The optimizations of a trajectory with one camera.
struct CameraDrift {
  std::vector<AdjustmentResult> results_by_start;

  bool Converged() const {
    return std::all_of(results_by_start.begin(), results_by_start.end(),
                       [](const AdjustmentResult& a) { return a.converged; });
  }
};

std::vector<Reconstruction> MakeStarts(const Trajectory& trajectory,
                                       const ExperimentOptions& options,
                                       int index) {
  std::vector<Reconstruction> starts;
  for (int k = 0; k < kNumStarts; ++k)
    starts.push_back(PerturbedStart(
        trajectory, options.seed * 6007 + kNumStarts * index + k + 1));
  return starts;
}

CameraDrift AdjustFromStarts(const CameraModel& camera,
                             const Trajectory& trajectory,
                             const std::vector<Reconstruction>& starts,
                             const ExperimentOptions& options) {
  CameraDrift drift;
  for (const Reconstruction& start : starts)
    drift.results_by_start.push_back(
        OptimizeTrajectory(camera, trajectory, start, options));
  return drift;
}

ExperimentResult EmptyTable(const std::vector<NamedCamera>& cameras) {
  ExperimentResult table;
  table.columns = {"camera",
                   "trajectory",
                   "residual_median_px",
                   "start_error_percent",
                   "end_error_percent",
                   "from_other_start_percent"};
  table.chart.title = "Drift at the end of a trajectory";
  table.chart.note = "intrinsics fixed to each calibration";
  table.chart.is_logarithmic = true;
  for (const NamedCamera& camera : cameras)
    table.chart.series.push_back({camera.name, {}, false});
  return table;
}

void AddStartConditions(ExperimentResult* table) {
  table->conditions.push_back(
      {"start",
       fmt::format(
           "perturbed per step by {:g} degrees about each axis, {:g} % of the "
           "step and {:g} % of the scale; points by {:g} % of their depth (1 "
           "sigma); start_error is the position error at its end",
           kRotationDeg, 100 * kStepFraction, 100 * kScaleFraction,
           100 * kDepthFraction)});
  table->conditions.push_back({"other start",
                               "another random initialization; both should "
                               "converge to the same error"});
}

// The end-point errors before the first optimization, and after the
// optimization from each initial trajectory.
struct EndErrors {
  double before = 0;
  std::array<double, kNumStarts> after = {};
};

void AddDriftRow(const NamedCamera& camera, size_t index, int trajectory,
                 const CameraDrift& drift, const EndErrors& errors,
                 ExperimentResult* table) {
  table->rows.push_back({camera.name, trajectory,
                         drift.results_by_start[0].median_px, errors.before,
                         errors.after[0], errors.after[1]});
  table->chart.series[index].points.push_back(
      {trajectory - 1.0, errors.after[0]});
  if (!drift.Converged())
    table->conditions.push_back(
        {"warning", fmt::format("{}, trajectory {}: did not converge",
                                camera.name, trajectory)});
}

ExperimentResult OptimizeSimulatedTrajectories(
    const ExperimentOptions& options) {
  const ComparedCameras compared =
      SelectComparedCameras(options, DriftModels());
  const std::vector<NamedCamera>& cameras = compared.cameras;
  ExperimentResult table = EmptyTable(cameras);
  table.conditions = compared.conditions;
  table.conditions.push_back(
      {"trajectory",
       fmt::format("{} images, {:g} m apart, {} points, {:g} px noise "
                   "per axis; bundle adjustment with fixed intrinsics",
                   kTrajectoryFrames, kStepM, kPoints, kNoisePx)});
  AddStartConditions(&table);
  table.conditions.push_back(
      {"error",
       fmt::format("of the last position, relative to the path length, after "
                   "aligning the first {} by a similarity",
                   kFirstFrames)});
  table.chart.x_label = "trajectory (with its own noise and points)";
  table.chart.y_label = "final position error, % of the path length";
  for (int k = 0; k < options.num_trajectories; ++k) {
    table.chart.ticks.push_back({double(k), std::to_string(k + 1)});
    const Trajectory trajectory =
        SimulateTrajectory(compared, options.seed * 31 + k + 1);
    const std::vector<Reconstruction> starts =
        MakeStarts(trajectory, options, k);
    for (size_t c = 0; c < cameras.size(); ++c) {
      const CameraDrift drift =
          AdjustFromStarts(*cameras[c].model, trajectory, starts, options);
      AddDriftRow(cameras[c], c, k + 1, drift,
                  {EndErrorPercent(starts[0], trajectory),
                   {EndErrorPercent(drift.results_by_start[0], trajectory),
                    EndErrorPercent(drift.results_by_start[1], trajectory)}},
                  &table);
      if (options.progress)
        options.progress(0.5 + 0.5 * (k + double(c + 1) / cameras.size()) /
                                   options.num_trajectories);
    }
  }
  return table;
}

void RequireSize(const ColmapModel& model,
                 const std::vector<NamedCamera>& cameras) {
  for (const NamedCamera& camera : cameras) {
    const ImageSize& size = camera.model->image_size();
    if (model.size != size)
      throw InputError(fmt::format(
          "--colmap-model: its images have {} x {} pixels, those of {} have {} "
          "x {}; use images of the calibrated sensor mode",
          model.size.width, model.size.height, camera.name, size.width,
          size.height));
  }
}

// Returns the user's cameras, or cameras calibrated from the user's features.
ComparedCameras SelectTrajectoryCameras(const ExperimentOptions& options) {
  if (options.data.features)
    return SelectComparedCameras(options, DriftModels());
  ComparedCameras given;
  given.cameras = options.data.cameras;
  if (given.cameras.size() < 2 || given.cameras.size() > 6)
    throw Error(ExitCode::kUsage,
                "--colmap-model requires two to six --camera options, or "
                "--features to calibrate from");
  return given;
}

ExperimentResult OptimizeUserTrajectory(const ExperimentOptions& options) {
  const ComparedCameras compared = SelectTrajectoryCameras(options);
  const std::vector<NamedCamera>& cameras = compared.cameras;
  const ColmapModel& model = *options.data.trajectory;
  RequireSize(model, cameras);
  const Trajectory trajectory =
      MakeTrajectory(model, ComputeCommonArea(cameras));
  const std::vector<Reconstruction> starts = MakeStarts(trajectory, options, 0);
  std::vector<CameraDrift> drifts;
  for (const NamedCamera& camera : cameras) {
    drifts.push_back(
        AdjustFromStarts(*camera.model, trajectory, starts, options));
    if (options.progress)
      options.progress(double(drifts.size()) / double(cameras.size()));
  }
  const AdjustmentResult& reference = drifts.back().results_by_start[0];

  ExperimentResult table = EmptyTable(cameras);
  table.conditions = compared.conditions;
  table.conditions.push_back(
      {"trajectory",
       fmt::format("user-provided, {} of {} images, {} points; bundle "
                   "adjustment with fixed intrinsics",
                   trajectory.views.size(), model.images.size(),
                   model.points.size())});
  AddStartConditions(&table);
  table.conditions.push_back(
      {"error", fmt::format("of the last position, relative to the path "
                            "length, from that with {}, after aligning the "
                            "points of the first {} images by a similarity",
                            cameras.back().name, kFirstFrames)});
  table.chart.title = "Difference at the end of a trajectory";
  table.chart.x_label = "trajectory";
  table.chart.y_label = "% of the path length, from " + cameras.back().name;
  table.chart.is_logarithmic = false;
  table.chart.ticks = {{0, "user-provided images"}};
  for (size_t c = 0; c < cameras.size(); ++c)
    AddDriftRow(cameras[c], c, 1, drifts[c],
                {EndDifferencePercent(starts[0], reference, trajectory),
                 {EndDifferencePercent(drifts[c].results_by_start[0], reference,
                                       trajectory),
                  EndDifferencePercent(drifts[c].results_by_start[1], reference,
                                       trajectory)}},
                &table);
  return table;
}

}  // namespace

ExperimentResult MeasureTrajectoryDrift(const ExperimentOptions& options) {
  return options.data.trajectory ? OptimizeUserTrajectory(options)
                                 : OptimizeSimulatedTrajectories(options);
}

}  // namespace raygrid
