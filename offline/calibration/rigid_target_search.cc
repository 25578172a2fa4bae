#include "calibration/rigid_target_search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "calibration/relative_board_pose.h"

namespace raygrid {
namespace {

// Minimum number of frames for a decision.
constexpr size_t kMinFrames = 3;
// Maximum fraction of frames with an inconsistent relative pose; single misread
// boards are tolerated.
constexpr double kMaxInconsistentFraction = 0.1;

// Returns the 99.9 % quantile of the chi-square distribution (E. Wilson, M.
// Hilferty, "The Distribution of Chi-Square", 1931).
double ComputeChiSquareLimit(double degrees_of_freedom) {
  constexpr double kNormalQuantile = 3.090232;
  const double part = 2 / (9 * degrees_of_freedom);
  return degrees_of_freedom *
         std::pow(1 - part + kNormalQuantile * std::sqrt(part), 3);
}

Eigen::Vector3d ComputeBoardCenter(const Board& board) {
  Eigen::Vector3d sum(0, 0, 0);
  for (const Eigen::Vector3d& point : board.points) sum += point;
  return sum / static_cast<double>(board.points.size());
}

// Counts the frames with distinct poses of the first board.
size_t CountDiffering(
    const std::vector<const RelativeBoardPose*>& relative_poses) {
  constexpr double kMaxRotationRad = 2 * M_PI / 180,
                   kMaxRelativeDistance = 0.02;
  std::vector<const Pose*> differing;
  for (const RelativeBoardPose* relative_pose : relative_poses) {
    const Pose& pose = relative_pose->rig_from_first;
    if (std::none_of(differing.begin(), differing.end(), [&](const Pose* p) {
          return p->rotation.angularDistance(pose.rotation) < kMaxRotationRad &&
                 (p->translation - pose.translation).norm() <
                     kMaxRelativeDistance * pose.translation.norm();
        }))
      differing.push_back(&pose);
  }
  return differing.size();
}

// Test result for a pair of boards.
struct PairFinding {
  BoardPair board_pair;
  int first = 0, second = 0;  // indices
  Pose first_from_second;
  std::vector<std::string>
      inconsistent_images;  // with inconsistent relative pose
};

std::optional<PairFinding> AnalysePair(
    const std::vector<RelativeBoardPose>& relative_poses,
    const Eigen::Vector3d& center) {
  const MeanRelativePose mean = ComputeRobustMean(relative_poses);
  PairFinding finding;
  BoardPair& board_pair = finding.board_pair;
  finding.first_from_second = {mean.relative_rotation,
                               mean.center - mean.relative_rotation * center};
  std::vector<const RelativeBoardPose*> near;
  double square_sum = 0;
  for (const RelativeBoardPose& relative_pose : relative_poses) {
    const double square = SquaredMahalanobis(mean, relative_pose);
    const bool is_inconsistent = !(square <= kMaxSquaredMahalanobis);
    if (is_inconsistent)
      finding.inconsistent_images.push_back(relative_pose.image);
    else
      near.push_back(&relative_pose);
    square_sum += is_inconsistent ? 0 : square;
  }
  const double count = static_cast<double>(near.size());
  board_pair.num_frames = static_cast<int>(relative_poses.size());
  const double degrees_of_freedom =
      RelativeBoardPose::kDimensions * (count - 1) -
      (relative_poses.front().J_scale.isZero() ? 0 : 1);
  const bool is_observed = CountDiffering(near) >= kMinFrames;
  board_pair.fixed =
      is_observed &&
      static_cast<double>(finding.inconsistent_images.size()) <=
          kMaxInconsistentFraction *
              static_cast<double>(relative_poses.size()) &&
      square_sum <= std::max(ComputeChiSquareLimit(degrees_of_freedom),
                             kCovarianceMargin * degrees_of_freedom);
  if (!is_observed &&
      finding.inconsistent_images.size() * 2 < relative_poses.size())
    return std::nullopt;  // not observable: all poses are alike
  double number = 0;
  for (const RelativeBoardPose& relative_pose : relative_poses) {
    if (board_pair.fixed &&
        !(SquaredMahalanobis(mean, relative_pose) <= kMaxSquaredMahalanobis))
      continue;
    const RelativeBoardPose::Vector deviation =
        ComputeDeviation(mean, relative_pose);
    board_pair.deviation_rad += deviation.head<3>().squaredNorm();
    board_pair.deviation_m += deviation.tail<3>().squaredNorm();
    board_pair.expected_rad +=
        relative_pose.covariance.topLeftCorner<3, 3>().trace();
    board_pair.expected_m +=
        relative_pose.covariance.bottomRightCorner<3, 3>().trace();
    ++number;
  }
  for (double* square : {&board_pair.deviation_rad, &board_pair.deviation_m,
                         &board_pair.expected_rad, &board_pair.expected_m})
    *square = std::sqrt(*square / number);
  return finding;
}

std::vector<PairFinding> Findings(const std::vector<AdjustmentResult>& adjusted,
                                  const Pattern& pattern, int num_threads) {
  std::vector<std::unique_ptr<PoseEquations>> equations;
  for (const AdjustmentResult& cameras : adjusted)
    equations.push_back(
        std::make_unique<PoseEquations>(cameras, pattern, num_threads));
  std::vector<PairFinding> findings;
  const int num_boards = static_cast<int>(pattern.boards.size());
  for (int first = 0; first < num_boards; ++first)
    for (int second = first + 1; second < num_boards; ++second) {
      const Eigen::Vector3d center = ComputeBoardCenter(pattern.boards[second]);
      // Unconnected groups of cameras have separate scales, so only the group
      // with the most views of both boards is used.
      std::vector<RelativeBoardPose> largest_group;
      size_t best_group = 0;
      for (size_t g = 0; g < adjusted.size(); ++g) {
        std::vector<RelativeBoardPose> relative_poses =
            ComputeRelativePoses(adjusted[g], first, second, center,
                                 equations[g]->MaxNumRelativePoses());
        if (relative_poses.size() <= largest_group.size()) continue;
        largest_group = std::move(relative_poses);
        best_group = g;
      }
      if (largest_group.size() < kMinFrames ||
          !equations[best_group]->AddCovariances(&largest_group))
        continue;
      RemoveUndetermined(&largest_group);
      if (largest_group.size() < kMinFrames) continue;
      auto finding = AnalysePair(largest_group, center);
      if (!finding) continue;
      finding->first = first;
      finding->second = second;
      finding->board_pair.first = pattern.boards[first].id;
      finding->board_pair.second = pattern.boards[second].id;
      findings.push_back(std::move(*finding));
    }
  return findings;
}

// Whether merging would combine two boards with varying relative poses.
bool HasVaryingPoses(const PairFinding& finding,
                     const RigidTargets& rigid_targets,
                     const std::vector<PairFinding>& findings) {
  const int a = rigid_targets.frames[finding.first];
  const int b = rigid_targets.frames[finding.second];
  return std::any_of(findings.begin(), findings.end(), [&](const auto& other) {
    if (other.board_pair.fixed) return false;
    const int first = rigid_targets.frames[other.first];
    const int second = rigid_targets.frames[other.second];
    return (first == a || first == b) && (second == a || second == b);
  });
}

// Separates boards in images with inconsistent relative poses: first the board
// that occurs in most inconsistent pairs, and so on until none remain.
void ExcludeInconsistentBoards(const std::vector<PairFinding>& findings,
                               RigidTargets* rigid_targets) {
  std::map<std::string, std::vector<const PairFinding*>> far;
  for (const PairFinding& finding : findings)
    if (finding.board_pair.fixed)
      for (const std::string& image : finding.inconsistent_images)
        far[image].push_back(&finding);
  for (auto& [image, pairs] : far) {
    while (!pairs.empty()) {
      std::map<int, int> counts;
      for (const PairFinding* pair : pairs) {
        ++counts[pair->first];
        ++counts[pair->second];
      }
      int worst = pairs.front()->second;
      for (const auto& [board, count] : counts)
        if (count > counts[worst]) worst = board;
      rigid_targets->apart.insert({image, worst});
      pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                                 [worst](const PairFinding* pair) {
                                   return pair->first == worst ||
                                          pair->second == worst;
                                 }),
                  pairs.end());
    }
  }
}

// Counts the images that show each pair of boards.
std::map<std::pair<int, int>, size_t> CountCommonFrames(
    const CalibrationProblem& problem) {
  std::map<std::pair<std::string, int>, std::vector<int>> boards;
  for (size_t v = 0; v < problem.views.size(); ++v)
    boards[{problem.images[v], problem.views[v].camera}].push_back(
        problem.boards[v]);
  std::map<std::pair<int, int>, size_t> counts;
  for (const auto& [image, seen] : boards)
    for (const int a : seen)
      for (const int b : seen)
        if (a < b) ++counts[{a, b}];
  return counts;
}

}  // namespace

bool CanDetectRigidTargets(const std::vector<AdjustmentResult>& cameras) {
  std::map<std::string, std::set<int>> boards;
  for (const AdjustmentResult& camera : cameras)
    for (size_t v = 0; v < camera.problem.views.size(); ++v)
      boards[camera.problem.images[v]].insert(camera.problem.boards[v]);
  std::map<std::pair<int, int>, size_t> counts;
  for (const auto& [image, seen] : boards)
    for (const int a : seen)
      for (const int b : seen)
        if (a < b && ++counts[{a, b}] >= kMinFrames) return true;
  return false;
}

RigidTargets ProposeRigidTargets(const std::vector<Dataset>& cameras,
                                 const Pattern& pattern) {
  RigidTargets rigid_targets = SeparateTargets(pattern.boards.size());
  std::vector<RejectedImage> rejected;
  const auto counts =
      CountCommonFrames(BuildProblem(cameras, pattern, &rejected));
  for (const auto& [pair, count] : counts)
    if (count >= kMinFrames)
      UniteTargets(pair.first, pair.second, Pose(), &rigid_targets);
  return rigid_targets;
}

std::vector<BoardPair> CompareBoardPoses(
    const std::vector<AdjustmentResult>& adjusted, const Pattern& pattern,
    int num_threads, RigidTargets* rigid_targets) {
  const std::vector<PairFinding> findings =
      Findings(adjusted, pattern, num_threads);
  *rigid_targets = SeparateTargets(pattern.boards.size());
  std::vector<const PairFinding*> best;
  for (const PairFinding& finding : findings)
    if (finding.board_pair.fixed) best.push_back(&finding);
  std::stable_sort(best.begin(), best.end(), [](const auto* a, const auto* b) {
    return a->board_pair.num_frames > b->board_pair.num_frames;
  });
  for (const PairFinding* finding : best)
    if (!HasVaryingPoses(*finding, *rigid_targets, findings))
      UniteTargets(finding->first, finding->second, finding->first_from_second,
                   rigid_targets);
  ExcludeInconsistentBoards(findings, rigid_targets);
  if (rigid_targets->Groups().empty()) *rigid_targets = {};
  std::vector<BoardPair> pairs;
  for (const PairFinding& finding : findings)
    pairs.push_back(finding.board_pair);
  return pairs;
}

}  // namespace raygrid
