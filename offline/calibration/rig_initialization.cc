#include "calibration/rig_initialization.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "calibration/camera_adjustment.h"
#include "dataset/error.h"
#include "dataset/parallel_for.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

// A relative pose is invalid if its error in half of the shared views exceeds
// this fraction of the image width.
constexpr double kMaxRelativeDisagreement = 0.05;
constexpr double kMissingErrorPx =
    1e4;  // error of a point without a projection
constexpr int kMaxCandidates = 40;
// Outlier removal handles views with smaller errors.
constexpr double kMinViewErrorPx = 1;

using Views = std::vector<int>;

// The problem of a rig, and camera_from_pattern of each view as estimated by
// its camera alone, in the frame of the rigid target.
struct JoinedProblem {
  CalibrationProblem problem;
  std::vector<Pose> camera_from_pattern;
  std::vector<Pose> target_from_board;
};

// Joins the problems of single cameras. Views of a rigid target in images of
// the same name share a pose.
JoinedProblem JoinProblems(const std::vector<AdjustmentResult>& cameras,
                           const RigidTargets& rigid_targets) {
  JoinedProblem joined;
  CalibrationProblem& problem = joined.problem;
  problem.first_points = cameras.front().problem.first_points;
  problem.nominal = cameras.front().problem.nominal;
  problem.area = cameras.front().problem.area;
  problem.base_model = cameras.front().problem.base_model;
  for (const AdjustmentResult& camera : cameras)
    if (camera.problem.base_model != problem.base_model)
      problem.base_model.clear();
  std::map<std::pair<std::string, int>, int> pose_of;
  for (size_t c = 0; c < cameras.size(); ++c) {
    const CalibrationProblem& own = cameras[c].problem;
    problem.image_sizes.push_back(own.image_sizes.front());
    for (size_t v = 0; v < own.views.size(); ++v) {
      View view = own.views[v];
      joined.camera_from_pattern.push_back(
          cameras[c].state.ComputeCameraFromPattern(view));
      view.camera = static_cast<int>(c);
      view.pose =
          pose_of
              .emplace(std::pair(own.images[v], own.boards[v]), pose_of.size())
              .first->second;
      problem.views.push_back(std::move(view));
      problem.images.push_back(own.images[v]);
      problem.boards.push_back(own.boards[v]);
    }
  }
  problem.num_poses = static_cast<int>(pose_of.size());
  JoinBoards(rigid_targets, &problem, &joined.target_from_board);
  for (size_t v = 0; v < problem.views.size(); ++v)
    joined.camera_from_pattern[v] =
        ComputeTargetPose(problem.views[v], joined.camera_from_pattern[v],
                          joined.target_from_board);
  return joined;
}

std::vector<Views> GroupViewsByPose(const CalibrationProblem& problem) {
  std::vector<Views> views(problem.num_poses);
  for (size_t v = 0; v < problem.views.size(); ++v)
    views[problem.views[v].pose].push_back(static_cast<int>(v));
  return views;
}

// Returns the pairs of views in which two cameras observe a target in the same
// frame.
std::vector<std::pair<int, int>> FindSharedViews(
    const CalibrationProblem& problem, int first, int second) {
  std::vector<std::pair<int, int>> shared;
  for (const Views& views : GroupViewsByPose(problem))
    for (const int a : views)
      for (const int b : views)
        if (problem.views[a].camera == first &&
            problem.views[b].camera == second)
          shared.emplace_back(a, b);
  return shared;
}

// Returns the median reprojection error of a view.
double ComputeViewErrorPx(const CameraModel& camera,
                          const Pose& camera_from_board, const View& view,
                          const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> errors;
  for (const Observation& observation : view.observations) {
    const auto pixel =
        camera.Project(camera_from_board * points[observation.point],
                       &observation.pixel, kAdjustmentMarginPx);
    errors.push_back(pixel ? (*pixel - observation.pixel).norm()
                           : kMissingErrorPx);
  }
  return Quantile(errors, 0.5);
}

// Returns camera_from_board of a view for a given pose of its target.
Pose ComputeBoardPoseOnTarget(const JoinedProblem& joined, int view,
                              const Pose& camera_from_target) {
  return ComputeBoardPose(joined.problem.views[view], camera_from_target,
                          joined.target_from_board);
}

struct RelativePose {
  Pose second_from_first;
  double error_px = INFINITY;  // maximum over the best half of the shared views
};

// Error of a view for a given pose of its target, minimized over the rotations
// of a symmetric board if these are to be resolved.
struct RotatedViewError {
  double error_px = INFINITY;
  int turn = 0;
};

RotatedViewError FindBestRotation(const JoinedProblem& joined,
                                  const CameraModel& camera, int view,
                                  const Pose& camera_from_target,
                                  const Pattern* turned) {
  const CalibrationProblem& problem = joined.problem;
  const Pose camera_from_board =
      ComputeBoardPoseOnTarget(joined, view, camera_from_target);
  RotatedViewError best;
  best.error_px = ComputeViewErrorPx(camera, camera_from_board,
                                     problem.views[view], problem.nominal);
  if (!turned) return best;
  const Board& board = turned->boards[problem.boards[view]];
  for (int turn = 1; turn < board.NumRotations(); ++turn) {
    const double error_px = ComputeViewErrorPx(
        camera, camera_from_board * ComputeRotation(board, turn),
        problem.views[view], problem.nominal);
    if (error_px < best.error_px) best = {error_px, turn};
  }
  return best;
}

// Returns the relative poses estimated from single shared views, for each board
// rotation that is to be resolved.
std::vector<RelativePose> ListRelativePoses(
    const JoinedProblem& joined, const CameraModel& second,
    const std::vector<std::pair<int, int>>& shared, int num_threads,
    const Pattern* turned) {
  const int num_shared = static_cast<int>(shared.size());
  const int num_views = std::min(num_shared, kMaxCandidates);
  std::vector<RelativePose> candidates;
  for (int i = 0; i < num_views; ++i) {
    const auto [a, b] = shared[i * num_shared / num_views];
    const Board* const board =
        turned ? &turned->boards[joined.problem.boards[b]] : nullptr;
    for (int turn = 0; turn < (board ? board->NumRotations() : 1); ++turn) {
      Pose second_from_target = joined.camera_from_pattern[b];
      if (turn > 0)
        second_from_target = second_from_target * ComputeRotation(*board, turn);
      candidates.push_back(
          {second_from_target * joined.camera_from_pattern[a].Inverse(), {}});
    }
  }
  ParallelFor(static_cast<int>(candidates.size()), num_threads, [&](int i) {
    RelativePose& candidate = candidates[i];
    std::vector<double> errors;
    for (const auto& [v, w] : shared)
      errors.push_back(FindBestRotation(joined, second, w,
                                        candidate.second_from_first *
                                            joined.camera_from_pattern[v],
                                        turned)
                           .error_px);
    candidate.error_px = Quantile(errors, 0.5);
  });
  return candidates;
}

const RelativePose& SelectBest(const std::vector<RelativePose>& candidates) {
  return *std::min_element(candidates.begin(), candidates.end(),
                           [](const RelativePose& a, const RelativePose& b) {
                             return a.error_px < b.error_px;
                           });
}

// Returns the best of the relative poses that are estimated from single shared
// views.
RelativePose EstimateBestRelativePose(
    const JoinedProblem& joined, const CameraModel& second,
    const std::vector<std::pair<int, int>>& shared, int num_threads) {
  return SelectBest(
      ListRelativePoses(joined, second, shared, num_threads, nullptr));
}

// Whether another relative pose has a comparable error.
bool HasSimilarError(const RelativePose& other, const RelativePose& best) {
  constexpr double kComparableErrorRatio = 3;
  return other.error_px <
         kComparableErrorRatio * best.error_px + kMinViewErrorPx;
}

bool IsAmbiguous(const std::vector<RelativePose>& candidates,
                 const RelativePose& best) {
  constexpr double kMaxRotationRad = 0.5;
  return std::any_of(
      candidates.begin(), candidates.end(), [&](const RelativePose& other) {
        return other.second_from_first.rotation.angularDistance(
                   best.second_from_first.rotation) > kMaxRotationRad &&
               HasSimilarError(other, best);
      });
}

// Returns the pair of a connected and an unconnected camera with the most
// shared views.
std::pair<int, int> FindNextPair(
    const std::vector<std::vector<int>>& num_shared,
    const std::vector<bool>& reached) {
  std::pair<int, int> best = {-1, -1};
  int most = 0;
  for (size_t a = 0; a < reached.size(); ++a)
    for (size_t b = 0; b < reached.size(); ++b)
      if (reached[a] && !reached[b] && num_shared[a][b] > most) {
        most = num_shared[a][b];
        best = {static_cast<int>(a), static_cast<int>(b)};
      }
  return best;
}

// Returns the cameras that shared views connect to the first one.
std::vector<bool> FindConnectedCameras(
    const std::vector<std::vector<int>>& num_shared, int first) {
  std::vector<bool> reached(num_shared.size());
  reached[first] = true;
  for (int next; (next = FindNextPair(num_shared, reached).second) >= 0;)
    reached[next] = true;
  return reached;
}

// Groups of cameras with known relative poses: one tree per group.
class LocalizedCameras {
 public:
  explicit LocalizedCameras(size_t count)
      : tree_by_camera_(count, -1), from_first_(count) {}

  void AddFirst(size_t camera) {
    tree_by_camera_[camera] = static_cast<int>(camera);
    order_.push_back(camera);
  }
  // Leaves the second camera unconnected if the first one is unconnected.
  void Add(size_t first, size_t second, const Pose& second_from_first) {
    if (tree_by_camera_[first] < 0) return;
    tree_by_camera_[second] = tree_by_camera_[first];
    from_first_[second] = second_from_first * from_first_[first];
    order_.push_back(second);
  }
  std::optional<Pose> GetRelativePose(int from, int to) const {
    if (tree_by_camera_[from] < 0 ||
        tree_by_camera_[from] != tree_by_camera_[to])
      return std::nullopt;
    return from_first_[to] * from_first_[from].Inverse();
  }
  // Returns the view of the camera that was added first.
  int FindEarliest(const CalibrationProblem& problem,
                   const Views& views) const {
    for (const size_t camera : order_)
      for (const int v : views)
        if (problem.views[v].camera == static_cast<int>(camera)) return v;
    return views.front();
  }

 private:
  std::vector<int> tree_by_camera_;  // index of its first camera
  std::vector<Pose> from_first_;
  std::vector<size_t> order_;
};

void RequireAgreement(const std::vector<std::string>& names, int first,
                      int second, const RelativePose& best, size_t num_shared,
                      const ImageSize& size) {
  if (best.error_px <= kMaxRelativeDisagreement * size.width) return;
  throw Error(
      ExitCode::kInitializationFailed,
      fmt::format("cameras {} and {}: no relative pose fits their {} common "
                  "views (best median error {:.0f} px); images of the same "
                  "name must be synchronized, and the cameras rigidly mounted",
                  names[first], names[second], num_shared, best.error_px));
}

// Computes camera_from_rig by chaining relative poses along the spanning tree.
std::vector<Pose> ChainCameraPoses(const std::vector<std::string>& names,
                                   const JoinedProblem& joined,
                                   const AdjustmentState& state,
                                   int num_threads) {
  const auto num_shared = CountSharedViews(joined.problem);
  std::vector<Pose> camera_from_rig(names.size());
  std::vector<bool> reached(names.size());
  reached[0] = true;
  for (;;) {
    const auto [first, second] = FindNextPair(num_shared, reached);
    if (second < 0) return camera_from_rig;
    const auto shared = FindSharedViews(joined.problem, first, second);
    const RelativePose best = EstimateBestRelativePose(
        joined, *state.cameras[second], shared, num_threads);
    RequireAgreement(names, first, second, best, shared.size(),
                     joined.problem.image_sizes[second]);
    camera_from_rig[second] = best.second_from_first * camera_from_rig[first];
    reached[second] = true;
  }
}

// Initializes the rig's poses, each from the view that best explains all views
// of the pose.
std::vector<Pose> InitializeRigPoses(const JoinedProblem& joined,
                                     const AdjustmentState& state) {
  std::vector<Pose> rig_from_pattern;
  for (const Views& views : GroupViewsByPose(joined.problem)) {
    Pose best;
    double best_error_px = INFINITY;
    for (const int v : views) {
      const Pose candidate =
          state.camera_from_rig[joined.problem.views[v].camera].Inverse() *
          joined.camera_from_pattern[v];
      double error_px = 0;
      for (const int w : views) {
        const View& view = joined.problem.views[w];
        error_px += ComputeViewErrorPx(
            *state.cameras[view.camera],
            ComputeBoardPoseOnTarget(
                joined, w, state.camera_from_rig[view.camera] * candidate),
            view, joined.problem.nominal);
      }
      if (error_px >= best_error_px) continue;
      best_error_px = error_px;
      best = candidate;
    }
    rig_from_pattern.push_back(best);
  }
  return rig_from_pattern;
}

// Finds views with shared poses whose error exceeds the third quartile of such
// views by more than 6 interquartile ranges.
std::vector<bool> FindInconsistentViews(const CalibrationProblem& problem,
                                        const AdjustmentState& state) {
  const std::vector<Views> views_by_pose = GroupViewsByPose(problem);
  std::vector<double> errors_px(problem.views.size()), shared_px;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    const View& view = problem.views[v];
    if (views_by_pose[view.pose].size() < 2) continue;
    errors_px[v] = ComputeViewErrorPx(*state.cameras[view.camera],
                                      state.ComputeCameraFromPattern(view),
                                      view, problem.nominal);
    shared_px.push_back(errors_px[v]);
  }
  const double q1 = Quantile(shared_px, 0.25), q3 = Quantile(shared_px, 0.75);
  const double threshold = std::max(q3 + 6 * (q3 - q1), kMinViewErrorPx);
  std::vector<bool> inconsistent;
  for (const double error_px : errors_px)
    inconsistent.push_back(error_px > threshold);
  return inconsistent;
}

// Removes views from the problem, and poses without remaining views from the
// state.
void RemoveViewsAndPoses(const std::vector<bool>& remove,
                         AdjustmentResult* adjusted) {
  std::vector<int> old_pose;
  for (size_t v = 0; v < remove.size(); ++v)
    if (!remove[v]) old_pose.push_back(adjusted->problem.views[v].pose);
  RemoveViews(remove, &adjusted->problem);
  std::vector<Pose> poses(adjusted->problem.num_poses);
  for (size_t v = 0; v < old_pose.size(); ++v)
    poses[adjusted->problem.views[v].pose] =
        adjusted->state.rig_from_pattern[old_pose[v]];
  adjusted->state.rig_from_pattern = std::move(poses);
}

}  // namespace

std::vector<std::vector<int>> CountSharedViews(
    const CalibrationProblem& problem) {
  const size_t num_cameras = problem.image_sizes.size();
  std::vector<std::vector<int>> counts(num_cameras,
                                       std::vector<int>(num_cameras));
  for (const Views& views : GroupViewsByPose(problem)) {
    std::set<int> cameras;
    for (const int v : views) cameras.insert(problem.views[v].camera);
    for (const int a : cameras)
      for (const int b : cameras)
        if (a != b) ++counts[a][b];
  }
  return counts;
}

std::vector<std::vector<int>> ConnectedGroups(
    const CalibrationProblem& problem) {
  const auto num_shared = CountSharedViews(problem);
  std::vector<bool> is_known(num_shared.size());
  std::vector<std::vector<int>> groups;
  for (size_t first = 0; first < num_shared.size(); ++first) {
    if (is_known[first]) continue;
    const std::vector<bool> reached =
        FindConnectedCameras(num_shared, static_cast<int>(first));
    groups.emplace_back();
    for (size_t c = 0; c < reached.size(); ++c) {
      if (!reached[c]) continue;
      groups.back().push_back(static_cast<int>(c));
      is_known[c] = true;
    }
  }
  return groups;
}

std::vector<std::vector<int>> ConnectedGroups(
    const std::vector<AdjustmentResult>& cameras) {
  return ConnectedGroups(JoinProblems(cameras, {}).problem);
}

RigRotations ResolveRotationsAcrossCameras(
    const std::vector<AdjustmentResult>& cameras, const Pattern& pattern,
    int num_threads) {
  RigRotations result;
  result.by_camera.resize(cameras.size());
  const JoinedProblem joined = JoinProblems(cameras, {});
  const CalibrationProblem& problem = joined.problem;
  const auto num_shared = CountSharedViews(problem);
  LocalizedCameras placed(cameras.size());
  std::vector<bool> reached(cameras.size());
  for (size_t root = 0; root < cameras.size(); ++root) {
    if (reached[root]) continue;
    reached[root] = true;
    placed.AddFirst(root);
    for (;;) {
      const auto [first, second] = FindNextPair(num_shared, reached);
      if (second < 0) break;
      reached[second] = true;
      const CameraModel& camera = cameras[second].state.camera();
      const auto shared = FindSharedViews(problem, first, second);
      const auto candidates =
          ListRelativePoses(joined, camera, shared, num_threads, &pattern);
      RelativePose best = SelectBest(candidates);
      // InitializeRig() reports inconsistent views.
      if (best.error_px >
          kMaxRelativeDisagreement * problem.image_sizes[second].width)
        continue;
      if (IsAmbiguous(candidates, best)) {
        result.ambiguous.push_back({static_cast<size_t>(first),
                                    static_cast<size_t>(second),
                                    static_cast<int>(shared.size())});
        // Ambiguous rotations: prefers boards that are upright in the images,
        // as detected.
        const RelativePose unrotated =
            EstimateBestRelativePose(joined, camera, shared, num_threads);
        if (HasSimilarError(unrotated, best)) best = unrotated;
      }
      placed.Add(first, second, best.second_from_first);
    }
  }
  for (const Views& views : GroupViewsByPose(problem)) {
    const int reference = placed.FindEarliest(problem, views);
    for (const int v : views) {
      const View& view = problem.views[v];
      const auto from_reference =
          placed.GetRelativePose(problem.views[reference].camera, view.camera);
      if (v == reference || !from_reference) continue;
      const int turn =
          FindBestRotation(
              joined, cameras[view.camera].state.camera(), v,
              *from_reference * joined.camera_from_pattern[reference], &pattern)
              .turn;
      if (turn != 0)
        result.by_camera[view.camera][{
            problem.images[v], pattern.boards[problem.boards[v]].id}] = turn;
    }
  }
  return result;
}

void RequireConnected(const std::vector<std::string>& names,
                      const CalibrationProblem& problem) {
  std::vector<std::string> groups;
  for (const std::vector<int>& cameras : ConnectedGroups(problem)) {
    std::vector<std::string> group;
    for (const int c : cameras) group.push_back(names[c]);
    groups.push_back(fmt::format("{{{}}}", fmt::join(group, ", ")));
  }
  if (groups.size() < 2) return;
  throw Error(
      ExitCode::kInitializationFailed,
      fmt::format(
          "the cameras are not connected: no frame shows a board with at least "
          "{} features in two of the groups {}; capture such frames, or move "
          "the rig so that each observes a board in common frames, with boards "
          "that are fixed to each other; give synchronized images the same "
          "name (or use --sync-by number)",
          kMinViewFeatures, fmt::join(groups, ", ")));
}

AdjustmentResult InitializeRig(
    const std::vector<std::string>& names,
    const std::vector<AdjustmentResult>& cameras,
    const RigidTargets& rigid_targets, const AdjustmentOptions& options,
    std::vector<std::vector<RejectedImage>>* rejected) {
  rejected->resize(cameras.size());
  if (cameras.size() == 1 && rigid_targets.empty()) return cameras.front();
  JoinedProblem joined = JoinProblems(cameras, rigid_targets);
  RequireConnected(names, joined.problem);
  AdjustmentResult rig;
  for (const AdjustmentResult& camera : cameras) {
    rig.state.cameras.push_back(camera.state.camera().Clone());
    rig.rejected_features.push_back(camera.rejected_features.front());
  }
  rig.state.points = joined.problem.nominal;
  rig.state.camera_from_rig =
      ChainCameraPoses(names, joined, rig.state, options.num_threads);
  rig.state.rig_from_pattern = InitializeRigPoses(joined, rig.state);
  rig.state.target_from_board = std::move(joined.target_from_board);
  rig.problem = std::move(joined.problem);

  AdjustmentOptions fixed_points = options;
  fixed_points.fix_points = true;
  rig.summary = RefineCameras(rig.problem, fixed_points, &rig.state);
  const std::vector<bool> remove =
      FindInconsistentViews(rig.problem, rig.state);
  for (size_t v = 0; v < remove.size(); ++v)
    if (remove[v])
      (*rejected)[rig.problem.views[v].camera].push_back(
          {rig.problem.images[v],
           cameras.size() == 1
               ? "the pose disagrees with the rigid multi-board target"
               : "the pose disagrees with the other cameras; check that they "
                 "are synchronized"});
  if (std::count(remove.begin(), remove.end(), true) == 0) return rig;
  RemoveViewsAndPoses(remove, &rig);
  RequireConnected(names, rig.problem);
  rig.summary = RefineCameras(rig.problem, fixed_points, &rig.state);
  return rig;
}

}  // namespace raygrid
