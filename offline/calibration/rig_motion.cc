#include "calibration/rig_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "dataset/error.h"
#include "hand_eye/linear_hand_eye.h"
#include "hand_eye/motion_observability.h"

namespace raygrid {
namespace {

// Sets that are merged pairwise.
class DisjointSets {
 public:
  explicit DisjointSets(size_t count) : sets_(count) {
    for (size_t i = 0; i < count; ++i) sets_[i] = i;
  }
  bool AreJoined(size_t a, size_t b) const { return sets_[a] == sets_[b]; }
  void Join(size_t a, size_t b) {
    const size_t kept = sets_[a], joined = sets_[b];
    std::replace(sets_.begin(), sets_.end(), joined, kept);
  }
  bool AreAllJoined() const {
    return std::count(sets_.begin(), sets_.end(), sets_.front()) ==
           static_cast<std::ptrdiff_t>(sets_.size());
  }

 private:
  std::vector<size_t> sets_;
};

// rig_from_target of a group of cameras, by target and image.
using PosesByImage = std::map<std::string, Pose>;
using PosesByTarget = std::map<int, PosesByImage>;

// Returns the pose of each target, from its board with the most features.
PosesByTarget CollectTargetPoses(const AdjustmentResult& adjusted,
                                 const RigidTargets& rigid_targets) {
  const CalibrationProblem& problem = adjusted.problem;
  PosesByTarget poses;
  std::map<std::pair<int, std::string>, size_t> most;
  for (size_t v = 0; v < problem.views.size(); ++v) {
    const int board = problem.boards[v];
    const std::string& image = problem.images[v];
    if (rigid_targets.apart.count({image, board}) > 0) continue;
    const int target = rigid_targets.frames[board];
    size_t& num_features = most[{target, image}];
    if (problem.views[v].observations.size() <= num_features) continue;
    num_features = problem.views[v].observations.size();
    poses[target][image] =
        adjusted.state.rig_from_pattern[problem.views[v].pose] *
        rigid_targets.frame_from_board[board].Inverse();
  }
  return poses;
}

// Two targets, each observed by one of two groups in the same frames.
struct MotionPair {
  size_t first_group = 0, second_group = 0;
  int first_target = 0, second_target = 0;
  /// In the terms of a robot, the first group is the gripper, the first target
  /// its base, and the second group the camera.
  std::vector<HandEyeObservation> observations;
  MotionObservability observability;

  double Quality() const {
    return std::sqrt(static_cast<double>(observations.size())) *
           std::min(observability.position_rad[0],
                    observability.orientation_rad[0]);
  }
};

std::vector<HandEyeObservation> CollectObservations(
    const PosesByImage& first, const PosesByImage& second) {
  std::vector<HandEyeObservation> observations;
  for (const auto& [image, pose] : first) {
    const auto other = second.find(image);
    if (other == second.end()) continue;
    HandEyeObservation& observation = observations.emplace_back();
    observation.image = image;
    observation.base_from_gripper = pose.Inverse();
    observation.camera_from_target = other->second;
  }
  return observations;
}

MotionObservability MeasureMotion(
    const std::vector<HandEyeObservation>& observations) {
  std::vector<Pose> poses;
  for (const HandEyeObservation& observation : observations)
    poses.push_back(observation.base_from_gripper.Inverse());
  return MeasureObservability(poses, MedianDistance(observations));
}

// Whether boards of two targets were seen to move relative to each other.
bool AreMoving(int first, int second, const RigidTargets& rigid_targets,
               const Pattern& pattern, const std::vector<BoardPair>& pairs) {
  std::map<int, int> target_of;
  for (size_t b = 0; b < pattern.boards.size(); ++b)
    target_of[pattern.boards[b].id] = rigid_targets.frames[b];
  return std::any_of(pairs.begin(), pairs.end(), [&](const BoardPair& pair) {
    const int a = target_of.at(pair.first), b = target_of.at(pair.second);
    return !pair.fixed &&
           ((a == first && b == second) || (a == second && b == first));
  });
}

// Returns the relative pose of the targets, first_from_second, unless no pose
// fits three quarters of the frames within 5 % of the distance.
std::optional<Pose> SolveRelativeTargetPose(const MotionPair& pair) {
  constexpr double kMaxMisfit = 0.05;
  constexpr double kMinFraction = 0.75;
  const std::vector<HandEyeObservation>& observations = pair.observations;
  const auto start = FindRobustStart(observations, Mounting::kEyeInHand);
  if (!start) return std::nullopt;
  const double lever_m = MedianDistance(observations);
  const std::vector<double> misfits_m = MeasureDifferences(
      start->hand_eye, observations, Mounting::kEyeInHand, lever_m);
  const auto num_fitting = std::count_if(
      misfits_m.begin(), misfits_m.end(),
      [&](double misfit_m) { return misfit_m <= kMaxMisfit * lever_m; });
  if (static_cast<double>(num_fitting) <
      kMinFraction * static_cast<double>(misfits_m.size()))
    return std::nullopt;
  return start->hand_eye.anchor_from_target;
}

// The search for pairs of targets that connect groups of cameras.
class MotionConnection {
 public:
  MotionConnection(const std::vector<std::string>& names,
                   const std::vector<std::vector<int>>& groups,
                   const std::vector<AdjustmentResult>& adjusted,
                   const Pattern& pattern, const std::vector<BoardPair>& pairs,
                   RigidTargets* rigid_targets)
      : names_(names),
        groups_(groups),
        adjusted_(adjusted),
        pattern_(pattern),
        pairs_(pairs),
        rigid_targets_(rigid_targets) {}

  void Run() {
    for (;;) {
      poses_.clear();
      for (const AdjustmentResult& group : adjusted_)
        poses_.push_back(CollectTargetPoses(group, *rigid_targets_));
      const DisjointSets connected = FindConnected();
      if (connected.AreAllJoined()) return;
      std::vector<MotionPair> candidates = FindCandidates(connected);
      std::stable_sort(candidates.begin(), candidates.end(),
                       [](const MotionPair& a, const MotionPair& b) {
                         return a.Quality() > b.Quality();
                       });
      if (candidates.empty()) return;
      if (std::none_of(candidates.begin(), candidates.end(),
                       [this](const auto& pair) { return Connect(pair); }))
        ThrowUnconnected(candidates.front());
    }
  }

 private:
  // Groups that observe a target in the same frame are connected.
  DisjointSets FindConnected() const {
    DisjointSets connected(groups_.size());
    std::map<std::pair<int, std::string>, size_t> first_group;
    for (size_t g = 0; g < poses_.size(); ++g)
      for (const auto& [target, poses] : poses_[g])
        for (const auto& [image, pose] : poses)
          connected.Join(
              first_group.emplace(std::pair(target, image), g).first->second,
              g);
    return connected;
  }

  std::vector<MotionPair> FindCandidates(const DisjointSets& connected) const {
    std::vector<MotionPair> candidates;
    for (size_t g = 0; g < poses_.size(); ++g)
      for (size_t h = g + 1; h < poses_.size(); ++h) {
        if (connected.AreJoined(g, h)) continue;
        for (const auto& [first, first_poses] : poses_[g])
          for (const auto& [second, second_poses] : poses_[h]) {
            if (first == second ||
                AreMoving(first, second, *rigid_targets_, pattern_, pairs_))
              continue;
            MotionPair pair = {g,
                               h,
                               first,
                               second,
                               CollectObservations(first_poses, second_poses),
                               {}};
            if (pair.observations.size() < kMinMotionFrames) continue;
            pair.observability = MeasureMotion(pair.observations);
            candidates.push_back(std::move(pair));
          }
      }
    return candidates;
  }

  bool Connect(const MotionPair& pair) const {
    if (!pair.observability.IsDetermined()) return false;
    const auto first_from_second = SolveRelativeTargetPose(pair);
    if (!first_from_second) return false;
    UniteTargets(pair.first_target, pair.second_target, *first_from_second,
                 rigid_targets_);
    return true;
  }

  std::string NameGroup(size_t group) const {
    std::vector<std::string> names;
    for (const int c : groups_[group]) names.push_back(names_[c]);
    return fmt::format("{{{}}}", fmt::join(names, ", "));
  }

  [[noreturn]] void ThrowUnconnected(const MotionPair& pair) const {
    const std::string& first = names_[groups_[pair.first_group].front()];
    const std::string& second = names_[groups_[pair.second_group].front()];
    std::string reason = DescribeMissingMotion(
        pair.observability, {"the rig", "camera " + first, "camera " + second});
    if (reason.empty())
      reason = fmt::format(
          "no relative pose fits the motion of boards {} and {}; check that "
          "they are fixed to each other, that images of the same name are "
          "synchronized, and that the cameras are rigidly mounted",
          pattern_.boards[pair.first_target].id,
          pattern_.boards[pair.second_target].id);
    throw Error(
        ExitCode::kInitializationFailed,
        fmt::format("{}, {}: these cameras share no view, and in their {} "
                    "common frames {}",
                    NameGroup(pair.first_group), NameGroup(pair.second_group),
                    pair.observations.size(), reason));
  }

  const std::vector<std::string>& names_;
  const std::vector<std::vector<int>>& groups_;
  const std::vector<AdjustmentResult>& adjusted_;
  const Pattern& pattern_;
  const std::vector<BoardPair>& pairs_;
  RigidTargets* rigid_targets_;
  std::vector<PosesByTarget> poses_;  // by group
};

}  // namespace

bool CanConnectByMotion(const CalibrationProblem& problem,
                        const std::vector<std::vector<int>>& groups) {
  std::vector<std::set<std::string>> images(groups.size());
  for (size_t v = 0; v < problem.views.size(); ++v)
    for (size_t g = 0; g < groups.size(); ++g)
      if (std::count(groups[g].begin(), groups[g].end(),
                     problem.views[v].camera) > 0)
        images[g].insert(problem.images[v]);
  DisjointSets connected(groups.size());
  for (size_t g = 0; g < groups.size(); ++g)
    for (size_t h = g + 1; h < groups.size(); ++h)
      if (std::count_if(images[g].begin(), images[g].end(),
                        [&](const std::string& image) {
                          return images[h].count(image) > 0;
                        }) >= kMinMotionFrames)
        connected.Join(g, h);
  return connected.AreAllJoined();
}

void ConnectByMotion(const std::vector<std::string>& names,
                     const std::vector<std::vector<int>>& groups,
                     const std::vector<AdjustmentResult>& adjusted,
                     const Pattern& pattern,
                     const std::vector<BoardPair>& pairs,
                     RigidTargets* rigid_targets) {
  if (rigid_targets->empty())
    *rigid_targets = SeparateTargets(pattern.boards.size());
  MotionConnection(names, groups, adjusted, pattern, pairs, rigid_targets)
      .Run();
  if (rigid_targets->Groups().empty()) *rigid_targets = {};
}

}  // namespace raygrid
