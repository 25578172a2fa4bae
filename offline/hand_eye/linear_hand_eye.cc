#include "hand_eye/linear_hand_eye.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace raygrid {
namespace {

// Poses that determine a solution, with one to spare.
constexpr int kSubsetSize = 4;

// Twice the vector part of a quaternion with positive real part: the rotation
// vector for small angles.
Eigen::Vector3d DoubledVectorPart(const Eigen::Quaterniond& rotation) {
  return (rotation.w() < 0 ? -2.0 : 2.0) * rotation.vec();
}

// Rotations near 180 degrees have two opposite axes.
bool HasUniqueAxis(const Eigen::Quaterniond& rotation) {
  constexpr double kMinRealPart = 0.05;
  return std::abs(rotation.w()) > kMinRealPart;
}

Eigen::Quaterniond FindNearestRotation(const Eigen::Matrix3d& sum) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, 1);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0)
    signs.z() = -1;
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * signs.asDiagonal() *
                                            svd.matrixV().transpose()));
}

// Calls body(i, j) for the pairs of a subset; for large subsets, of each with
// some others only.
template <typename Body>
void ForEachPair(const std::vector<int>& subset, const Body& body) {
  constexpr size_t kMaxPairsPerPose = 60;
  const size_t n = subset.size();
  const size_t stride = n / kMaxPairsPerPose + 1;
  for (size_t i = 0; i < n; ++i)
    for (size_t j = i + 1; j < n; j += stride) body(subset[i], subset[j]);
}

// The rotation of camera_from_mount, by the relative rotations.
std::optional<Eigen::Quaterniond> SolveMountRotation(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  int num_pairs = 0;
  ForEachPair(subset, [&](int i, int j) {
    const Eigen::Quaterniond camera =
        observations[i].camera_from_target.rotation *
        observations[j].camera_from_target.rotation.conjugate();
    const Eigen::Quaterniond mount =
        MountFromAnchor(mounting, observations[i].base_from_gripper).rotation *
        MountFromAnchor(mounting, observations[j].base_from_gripper)
            .rotation.conjugate();
    if (!HasUniqueAxis(camera) || !HasUniqueAxis(mount)) return;
    sum += DoubledVectorPart(camera) * DoubledVectorPart(mount).transpose();
    ++num_pairs;
  });
  if (num_pairs == 0) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum / num_pairs);
  if (svd.singularValues()[1] < kMinRotationRad * kMinRotationRad)
    return std::nullopt;
  return FindNearestRotation(sum);
}

// The rotation of anchor_from_target for that of camera_from_mount.
Eigen::Quaterniond MeanAnchorRotation(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset, const Eigen::Quaterniond& mount) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const int i : subset) {
    const Eigen::Quaterniond camera_from_anchor =
        mount *
        MountFromAnchor(mounting, observations[i].base_from_gripper).rotation;
    sum += (camera_from_anchor.conjugate() *
            observations[i].camera_from_target.rotation)
               .toRotationMatrix();
  }
  return FindNearestRotation(sum);
}

// The translations for the rotation of camera_from_mount.
void SolveTranslations(const std::vector<HandEyeObservation>& observations,
                       Mounting mounting, const std::vector<int>& subset,
                       HandEye* hand_eye) {
  Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6d b = Vector6d::Zero();
  for (const int i : subset) {
    const Pose mount_from_anchor =
        MountFromAnchor(mounting, observations[i].base_from_gripper);
    Eigen::Matrix<double, 3, 6> J;
    J << Eigen::Matrix3d::Identity(),
        (hand_eye->camera_from_mount.rotation * mount_from_anchor.rotation)
            .toRotationMatrix();
    H += J.transpose() * J;
    b += J.transpose() *
         (observations[i].camera_from_target.translation -
          hand_eye->camera_from_mount.rotation * mount_from_anchor.translation);
  }
  const Vector6d translations = H.ldlt().solve(b);
  hand_eye->camera_from_mount.translation = translations.head<3>();
  hand_eye->anchor_from_target.translation = translations.tail<3>();
}

// Returns the indices of the `count` smallest values, in ascending order of
// the indices.
std::vector<int> FindSmallest(const std::vector<double>& values, size_t count) {
  std::vector<int> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return values[a] < values[b]; });
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

double SumOver(const std::vector<double>& values,
               const std::vector<int>& subset) {
  double sum = 0;
  for (const int i : subset) sum += values[i];
  return sum;
}

// Random subsets, the same on any machine.
class SubsetGenerator {
 public:
  explicit SubsetGenerator(int count) : order_(count) {
    std::iota(order_.begin(), order_.end(), 0);
  }
  std::vector<int> Next(int size) {
    for (int k = 0; k < size; ++k)
      std::swap(order_[k],
                order_[k + static_cast<int>(Random() % (order_.size() - k))]);
    return {order_.begin(), order_.begin() + size};
  }

 private:
  uint64_t Random() {  // xorshift64*, Vigna 2016
    state_ ^= state_ >> 12;
    state_ ^= state_ << 25;
    state_ ^= state_ >> 27;
    return (state_ * 0x2545F4914F6CDD1DULL) >> 33;
  }
  std::vector<int> order_;
  uint64_t state_ = 0x9E3779B97F4A7C15ULL;
};

// A linear solution and the sum of its differences over the better half.
struct TrimmedSolution {
  HandEye hand_eye;
  std::vector<int> subset;
  double sum = INFINITY;
};

// Solves again for the observations that agree best, until they do not change.
TrimmedSolution RunConcentrationSteps(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    double lever_m, size_t half, const HandEye& start, int num_rounds) {
  TrimmedSolution best;
  HandEye hand_eye = start;
  for (int round = 0;; ++round) {
    const std::vector<double> differences =
        MeasureDifferences(hand_eye, observations, mounting, lever_m);
    std::vector<int> subset = FindSmallest(differences, half);
    const double sum = SumOver(differences, subset);
    const bool is_better = sum < best.sum;
    if (is_better) best = {hand_eye, std::move(subset), sum};
    if (!is_better || round == num_rounds) return best;
    const auto next = SolveLinearHandEye(observations, mounting, best.subset);
    if (!next) return best;
    hand_eye = *next;
  }
}

// Concentrates few rounds from many subsets, and further from the best.
TrimmedSolution FindTrimmedSolution(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    double lever_m, size_t half) {
  constexpr int kNumSubsets = 300, kNumRefinedSubsets = 10;
  constexpr int kInitialConcentrationSteps = 2, kRounds = 30;
  const int count = static_cast<int>(observations.size());
  SubsetGenerator generator(count);
  std::vector<TrimmedSolution> finalists;
  for (int k = 0; k < kNumSubsets; ++k) {
    const auto start = SolveLinearHandEye(
        observations, mounting, generator.Next(std::min(kSubsetSize, count)));
    if (!start) continue;
    finalists.push_back(RunConcentrationSteps(observations, mounting, lever_m,
                                              half, *start,
                                              kInitialConcentrationSteps));
    std::stable_sort(finalists.begin(), finalists.end(),
                     [](const TrimmedSolution& a, const TrimmedSolution& b) {
                       return a.sum < b.sum;
                     });
    if (finalists.size() > kNumRefinedSubsets) finalists.pop_back();
  }
  TrimmedSolution best;
  for (const TrimmedSolution& finalist : finalists) {
    TrimmedSolution solution = RunConcentrationSteps(
        observations, mounting, lever_m, half, finalist.hand_eye, kRounds);
    if (solution.sum < best.sum) best = std::move(solution);
  }
  return best;
}

}  // namespace

double RotationSpread::Rms(int axis) const {
  return std::sqrt(std::max(mean_squares[axis], 0.0));
}

RotationSpread MeasureRotations(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  int num_pairs = 0;
  ForEachPair(subset, [&](int i, int j) {
    const Eigen::Vector3d vector = DoubledVectorPart(
        MountFromAnchor(mounting, observations[i].base_from_gripper).rotation *
        MountFromAnchor(mounting, observations[j].base_from_gripper)
            .rotation.conjugate());
    sum += vector * vector.transpose();
    ++num_pairs;
  });
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
      sum / std::max(num_pairs, 1));
  return {solver.eigenvalues().reverse(),
          solver.eigenvectors().rowwise().reverse()};
}

std::optional<HandEye> SolveLinearHandEye(
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    const std::vector<int>& subset) {
  const auto rotation = SolveMountRotation(observations, mounting, subset);
  if (!rotation) return std::nullopt;
  HandEye hand_eye;
  hand_eye.camera_from_mount.rotation = *rotation;
  hand_eye.anchor_from_target.rotation =
      MeanAnchorRotation(observations, mounting, subset, *rotation);
  SolveTranslations(observations, mounting, subset, &hand_eye);
  return hand_eye;
}

std::vector<double> MeasureDifferences(
    const HandEye& hand_eye,
    const std::vector<HandEyeObservation>& observations, Mounting mounting,
    double lever_m) {
  std::vector<double> differences;
  for (const HandEyeObservation& observation : observations) {
    const Vector6d difference = PoseDifference(
        PredictTargetPose(hand_eye, mounting, observation.base_from_gripper),
        observation.camera_from_target);
    differences.push_back(difference.tail<3>().norm() +
                          lever_m * difference.head<3>().norm());
  }
  return differences;
}

std::optional<RobustStart> FindRobustStart(
    const std::vector<HandEyeObservation>& observations, Mounting mounting) {
  const size_t count = observations.size();
  const size_t half =
      std::max(count / 2 + 1, std::min<size_t>(count, kSubsetSize));
  const double lever_m = MedianDistance(observations);
  const TrimmedSolution solution =
      FindTrimmedSolution(observations, mounting, lever_m, half);
  if (solution.subset.empty()) return std::nullopt;
  RobustStart start = {solution.hand_eye, solution.subset, 0, 0};
  for (const int i : solution.subset) {
    const Vector6d difference =
        PoseDifference(PredictTargetPose(solution.hand_eye, mounting,
                                         observations[i].base_from_gripper),
                       observations[i].camera_from_target);
    start.rotation_rad =
        std::max(start.rotation_rad, difference.head<3>().norm());
    start.translation_m =
        std::max(start.translation_m, difference.tail<3>().norm());
  }
  return start;
}

double MedianDistance(const std::vector<HandEyeObservation>& observations) {
  std::vector<double> distances;
  for (const HandEyeObservation& observation : observations)
    distances.push_back(observation.camera_from_target.translation.norm());
  const auto middle = distances.begin() + distances.size() / 2;
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

}  // namespace raygrid
