#include "calibration/body_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "adjustment/dense_equations.h"
#include "adjustment/large_equations.h"
#include "calibration/camera_result.h"
#include "calibration/evenly_chosen.h"
#include "evaluation/residual_statistics.h"

namespace raygrid {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Fewer instants tell nothing.
constexpr size_t kMinInstants = 3;
constexpr int kDimensions = 6;
// Covariances are no more than roughly known: a grid that is too coarse for its
// lens adds to them.
constexpr double kRoughly = 2;
// 99.9 % of chi-square with six degrees of freedom.
constexpr double kFarSquare = kRoughly * 22.458;
// An instant may show something else: a misread board. So many do not.
constexpr double kMaxApartPart = 0.1;

// 99.9 % of chi-square (E. Wilson, M. Hilferty, "The Distribution of
// Chi-Square", 1931).
double ChiSquareLimit(double degrees) {
  constexpr double kNormalQuantile = 3.090232;
  const double part = 2 / (9 * degrees);
  return degrees * std::pow(1 - part + kNormalQuantile * std::sqrt(part), 3);
}

// Which pose a board has at each instant, by image and board.
std::map<std::string, std::map<int, int>> PosesByImage(
    const CalibrationProblem& problem) {
  std::map<std::string, std::map<int, int>> poses;
  for (size_t v = 0; v < problem.views.size(); ++v)
    poses[problem.images[v]][problem.boards[v]] = problem.views[v].pose;
  return poses;
}

// The equations of an adjustment, which tell how well poses are known: besides
// noise, the camera and the points may be off, and all their priors may hold.
class PoseEquations {
 public:
  PoseEquations(const Adjusted& adjusted, const Pattern& pattern,
                int num_threads)
      : layout_(adjusted.state, {false, !HavePointsMoved(adjusted)}),
        variance_(
            std::pow(std::max(adjusted.summary.noise_px, kLeastNoisePx), 2)),
        correlation_(0),
        is_dense_(NumDenseUnknowns(layout_) <= kMaxDense) {
    const AdjustmentState& state = adjusted.state;
    const PriorEquations prior(adjusted.prior, state, layout_);
    std::vector<ViewJacobian> jacobians =
        WeightedJacobians(state, adjusted.problem.views, kHuberPx, num_threads);
    if (is_dense_)
      equations_ = std::make_unique<DenseEquations>(layout_, jacobians, prior,
                                                    num_threads);
    else
      equations_ = std::make_unique<LargeEquations>(
          layout_, std::move(jacobians), prior, state.points, kTolerance,
          num_threads, std::make_shared<LargeEquations::Memory>());
    for (int c = 0; c < static_cast<int>(state.cameras.size()); ++c)
      correlation_ = std::max(
          correlation_, NeighborCorrelation(TrainingResiduals(pattern, adjusted,
                                                              c, num_threads))
                            .value_or(0));
    num_features_.resize(adjusted.problem.num_poses);
    for (const View& view : adjusted.problem.views)
      num_features_[view.pose] += static_cast<double>(view.observations.size());
  }

  // How many relations of two poses can be afforded.
  size_t NumAffordable() const { return is_dense_ ? 60 : 16; }

  // The covariances of what changes by two poses' updates as their derivatives
  // say. Errors that neighbours still share are no smaller for the number of
  // features: those of n count as if each was n / 3 times as large.
  template <typename Relations>
  bool AddCovariances(Relations* relations) const {
    const auto count = static_cast<Eigen::Index>(relations->size());
    Eigen::MatrixXd right =
        Eigen::MatrixXd::Zero(layout_.num_all(), kDimensions * count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto& relation = (*relations)[i];
      auto columns = right.middleCols<kDimensions>(kDimensions * i);
      columns.middleRows<kDimensions>(layout_.Pose(relation.first_pose)) =
          relation.by_first.transpose();
      columns.middleRows<kDimensions>(layout_.Pose(relation.second_pose)) =
          relation.by_second.transpose();
    }
    Eigen::MatrixXd solution;
    if (!equations_->SolveFor(0, right, &solution)) return false;
    for (Eigen::Index i = 0; i < count; ++i) {
      auto& relation = (*relations)[i];
      const Matrix6 inverse =
          right.middleCols<kDimensions>(kDimensions * i).transpose() *
          solution.middleCols<kDimensions>(kDimensions * i);
      const double features = std::min(num_features_[relation.first_pose],
                                       num_features_[relation.second_pose]);
      relation.covariance = variance_ * (1 + features / 3 * correlation_) *
                            (inverse + inverse.transpose()) / 2;
      relation.information =
          relation.covariance.ldlt().solve(Matrix6::Identity());
    }
    return true;
  }

 private:
  static constexpr double kHuberPx = 1, kTolerance = 1e-2;
  // No camera follows its lens better, even if features are exact.
  static constexpr double kLeastNoisePx = 0.01;
  static constexpr int kMaxDense = 2500;

  ParameterLayout layout_;
  double variance_, correlation_;
  bool is_dense_;
  std::unique_ptr<NormalEquations> equations_;
  std::vector<double> num_features_;  // of each pose
};

Eigen::Vector3d MiddleOf(const Board& board) {
  Eigen::Vector3d sum(0, 0, 0);
  for (const Eigen::Vector3d& point : board.points) sum += point;
  return sum / static_cast<double>(board.points.size());
}

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// The second board in the frame of the first, at one instant.
struct Relation {
  std::string image;
  int first_pose = 0, second_pose = 0;
  Pose rig_from_first;
  Eigen::Quaterniond turn;
  Eigen::Vector3d middle;              // of the second board
  Vector6 by_scale = Vector6::Zero();  // of the second board, if it is free
  // Of turn and middle, by UpdatedPose()'s updates.
  Matrix6 by_first = Matrix6::Zero(), by_second = Matrix6::Zero();
  Matrix6 covariance = Matrix6::Zero(), information = Matrix6::Zero();
};

Relation RelationOf(const std::string& image, int first_pose, int second_pose,
                    const AdjustmentState& state, const Eigen::Vector3d& middle,
                    bool scale_is_free) {
  const Pose& first = state.rig_from_pattern[first_pose];
  const Pose& second = state.rig_from_pattern[second_pose];
  Relation relation;
  relation.image = image;
  relation.first_pose = first_pose;
  relation.second_pose = second_pose;
  relation.rig_from_first = first;
  const Eigen::Matrix3d back = first.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d turned = second.rotation * middle;
  const Eigen::Vector3d in_rig = turned + second.translation;
  const Eigen::Vector3d apart = in_rig - first.translation;
  relation.turn = first.rotation.conjugate() * second.rotation;
  relation.middle = back * apart;
  if (scale_is_free) relation.by_scale.tail<3>() = back * in_rig;
  relation.by_first.topLeftCorner<3, 3>() = -back;
  relation.by_first.bottomLeftCorner<3, 3>() = back * CrossMatrix(apart);
  relation.by_first.bottomRightCorner<3, 3>() = -back;
  relation.by_second.topLeftCorner<3, 3>() = back;
  relation.by_second.bottomLeftCorner<3, 3>() = -back * CrossMatrix(turned);
  relation.by_second.bottomRightCorner<3, 3>() = back;
  return relation;
}

// The second board's place on the average; how much larger than the second's
// own scale that of the first is.
struct MeanRelation {
  Eigen::Quaterniond turn;
  Eigen::Vector3d middle;
  double scale = 0;
};

Vector6 DeviationFrom(const MeanRelation& mean, const Relation& relation) {
  Eigen::Quaterniond turn = relation.turn * mean.turn.conjugate();
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const Eigen::AngleAxisd angle_axis(turn);
  Vector6 deviation;
  deviation << angle_axis.angle() * angle_axis.axis(),
      relation.middle - mean.middle;
  return deviation + mean.scale * relation.by_scale;
}

double SquareOf(const MeanRelation& mean, const Relation& relation) {
  const Vector6 deviation = DeviationFrom(mean, relation);
  return deviation.dot(relation.information * deviation);
}

// The relation of one instant that most others agree with.
MeanRelation MostAgreed(const std::vector<Relation>& relations) {
  constexpr size_t kMaxCandidates = 100;
  const size_t step = relations.size() / kMaxCandidates + 1;
  MeanRelation best;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < relations.size(); i += step) {
    const MeanRelation candidate = {relations[i].turn, relations[i].middle, 0};
    std::vector<double> squares;
    for (const Relation& relation : relations)
      squares.push_back(SquareOf(candidate, relation));
    const double median = Quantile(squares, 0.5);
    if (!(median < least)) continue;
    least = median;
    best = candidate;
  }
  return best;
}

// The mean by the relations' information; those that are far off count less.
MeanRelation RobustMean(const std::vector<Relation>& relations) {
  constexpr int kRounds = 20;
  MeanRelation mean = MostAgreed(relations);
  const bool has_scale = !relations.front().by_scale.isZero();
  const int size = has_scale ? kDimensions + 1 : kDimensions;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(size);
    for (const Relation& relation : relations) {
      const Vector6 deviation = DeviationFrom(mean, relation);
      const double square = deviation.dot(relation.information * deviation);
      const double weight = std::min(1.0, kFarSquare / square);
      Eigen::MatrixXd by(kDimensions, size);
      by.leftCols<kDimensions>() = -Matrix6::Identity();
      if (has_scale) by.col(kDimensions) = relation.by_scale;
      h += weight * by.transpose() * relation.information * by;
      g += weight * by.transpose() * relation.information * deviation;
    }
    const Eigen::VectorXd step = -h.ldlt().solve(g);
    mean.turn = (RotationFromVector(step.head<3>()) * mean.turn).normalized();
    mean.middle += step.segment<3>(3);
    if (has_scale) mean.scale += step[kDimensions];
  }
  return mean;
}

// How many instants show the first board in places that differ.
size_t NumDifferent(const std::vector<const Relation*>& relations) {
  constexpr double kAlikeRad = 2 * M_PI / 180, kAlikePart = 0.02;
  std::vector<const Pose*> different;
  for (const Relation* relation : relations) {
    const Pose& pose = relation->rig_from_first;
    if (std::none_of(different.begin(), different.end(), [&](const Pose* p) {
          return p->rotation.angularDistance(pose.rotation) < kAlikeRad &&
                 (p->translation - pose.translation).norm() <
                     kAlikePart * pose.translation.norm();
        }))
      different.push_back(&pose);
  }
  return different.size();
}

// Relations that hardly tell how the boards are turned leave: one row of a
// board leaves its turn around the row open, and a start may be anywhere.
void RemoveVague(std::vector<Relation>* relations) {
  constexpr double kVagueRad = 5 * M_PI / 180;
  relations->erase(
      std::remove_if(relations->begin(), relations->end(),
                     [](const Relation& relation) {
                       const double square =
                           relation.covariance.topLeftCorner<3, 3>().trace();
                       return !(square <= kVagueRad * kVagueRad) ||
                              relation.covariance.llt().info() !=
                                  Eigen::Success;
                     }),
      relations->end());
}

// The outcome for a pair of boards.
struct PairFinding {
  BoardPair told;
  int first = 0, second = 0;  // indices
  Pose first_from_second;
  std::vector<std::string> far_images;  // which show them elsewhere
};

std::optional<PairFinding> FindingOf(const std::vector<Relation>& relations,
                                     const Eigen::Vector3d& middle) {
  const MeanRelation mean = RobustMean(relations);
  PairFinding finding;
  BoardPair& told = finding.told;
  finding.first_from_second = {mean.turn, mean.middle - mean.turn * middle};
  std::vector<const Relation*> near;
  double square_sum = 0;
  for (const Relation& relation : relations) {
    const double square = SquareOf(mean, relation);
    const bool is_far = !(square <= kFarSquare);
    if (is_far)
      finding.far_images.push_back(relation.image);
    else
      near.push_back(&relation);
    square_sum += is_far ? 0 : square;
  }
  const double count = static_cast<double>(near.size());
  told.num_instants = static_cast<int>(relations.size());
  const double degrees =
      kDimensions * (count - 1) - (relations.front().by_scale.isZero() ? 0 : 1);
  const bool is_told = NumDifferent(near) >= kMinInstants;
  told.fixed =
      is_told &&
      static_cast<double>(finding.far_images.size()) <=
          kMaxApartPart * static_cast<double>(relations.size()) &&
      square_sum <= std::max(ChiSquareLimit(degrees), kRoughly * degrees);
  if (!is_told && finding.far_images.size() * 2 < relations.size())
    return std::nullopt;  // always in one view
  double number = 0;
  for (const Relation& relation : relations) {
    if (told.fixed && !(SquareOf(mean, relation) <= kFarSquare)) continue;
    const Vector6 deviation = DeviationFrom(mean, relation);
    told.deviation_rad += deviation.head<3>().squaredNorm();
    told.deviation_m += deviation.tail<3>().squaredNorm();
    told.expected_rad += relation.covariance.topLeftCorner<3, 3>().trace();
    told.expected_m += relation.covariance.bottomRightCorner<3, 3>().trace();
    ++number;
  }
  for (double* square : {&told.deviation_rad, &told.deviation_m,
                         &told.expected_rad, &told.expected_m})
    *square = std::sqrt(*square / number);
  return finding;
}

// The relations of two boards in an adjustment, without covariances; evenly
// chosen where they are too many.
std::vector<Relation> RelationsOf(const Adjusted& adjusted, int first,
                                  int second, const Eigen::Vector3d& middle,
                                  size_t max_count) {
  const bool scale_is_free =
      HavePointsMoved(adjusted) && adjusted.state.cameras.size() == 1;
  std::vector<Relation> relations;
  for (const auto& [image, poses] : PosesByImage(adjusted.problem)) {
    const auto a = poses.find(first), b = poses.find(second);
    if (a != poses.end() && b != poses.end())
      relations.push_back(RelationOf(image, a->second, b->second,
                                     adjusted.state, middle, scale_is_free));
  }
  return EvenlyChosen(relations, max_count);
}

std::vector<PairFinding> Findings(const std::vector<Adjusted>& adjusted,
                                  const Pattern& pattern, int num_threads) {
  std::vector<std::unique_ptr<PoseEquations>> equations;
  for (const Adjusted& cameras : adjusted)
    equations.push_back(
        std::make_unique<PoseEquations>(cameras, pattern, num_threads));
  std::vector<PairFinding> findings;
  const int num_boards = static_cast<int>(pattern.boards.size());
  for (int first = 0; first < num_boards; ++first)
    for (int second = first + 1; second < num_boards; ++second) {
      const Eigen::Vector3d middle = MiddleOf(pattern.boards[second]);
      // Groups of cameras that nothing connects have scales of their own: the
      // one that sees most of two boards tells.
      std::vector<Relation> most;
      size_t teller = 0;
      for (size_t g = 0; g < adjusted.size(); ++g) {
        std::vector<Relation> relations = RelationsOf(
            adjusted[g], first, second, middle, equations[g]->NumAffordable());
        if (relations.size() <= most.size()) continue;
        most = std::move(relations);
        teller = g;
      }
      if (most.size() < kMinInstants ||
          !equations[teller]->AddCovariances(&most))
        continue;
      RemoveVague(&most);
      if (most.size() < kMinInstants) continue;
      auto finding = FindingOf(most, middle);
      if (!finding) continue;
      finding->first = first;
      finding->second = second;
      finding->told.first = pattern.boards[first].id;
      finding->told.second = pattern.boards[second].id;
      findings.push_back(std::move(*finding));
    }
  return findings;
}

// Every board in a body of its own.
Bodies NoBodies(size_t num_boards) {
  Bodies bodies;
  for (size_t b = 0; b < num_boards; ++b)
    bodies.frames.push_back(static_cast<int>(b));
  bodies.frame_from_board.resize(num_boards);
  return bodies;
}

// The bodies of two boards become one.
void Unite(const PairFinding& finding, Bodies* bodies) {
  const int kept = bodies->frames[finding.first];
  const int joined = bodies->frames[finding.second];
  if (kept == joined) return;
  const Pose kept_from_joined =
      bodies->frame_from_board[finding.first] * finding.first_from_second *
      bodies->frame_from_board[finding.second].Inverse();
  for (size_t b = 0; b < bodies->frames.size(); ++b) {
    if (bodies->frames[b] != joined) continue;
    bodies->frames[b] = kept;
    bodies->frame_from_board[b] =
        kept_from_joined * bodies->frame_from_board[b];
  }
}

// Whether two boards that move against each other would be in one body.
bool WouldBreak(const PairFinding& finding, const Bodies& bodies,
                const std::vector<PairFinding>& findings) {
  const int a = bodies.frames[finding.first];
  const int b = bodies.frames[finding.second];
  return std::any_of(findings.begin(), findings.end(), [&](const auto& other) {
    if (other.told.fixed) return false;
    const int first = bodies.frames[other.first];
    const int second = bodies.frames[other.second];
    return (first == a || first == b) && (second == a || second == b);
  });
}

// Images in which a pair of one body is elsewhere: the board that is in most of
// such pairs stands apart, then the next.
void SetApart(const std::vector<PairFinding>& findings, Bodies* bodies) {
  std::map<std::string, std::vector<const PairFinding*>> far;
  for (const PairFinding& finding : findings)
    if (finding.told.fixed)
      for (const std::string& image : finding.far_images)
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
      bodies->apart.insert({image, worst});
      pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                                 [worst](const PairFinding* pair) {
                                   return pair->first == worst ||
                                          pair->second == worst;
                                 }),
                  pairs.end());
    }
  }
}

// How many images of a camera show each two of some boards.
std::map<std::pair<int, int>, size_t> CountTogether(
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

bool MayTellBodies(const std::vector<Adjusted>& cameras) {
  std::map<std::string, std::set<int>> boards;
  for (const Adjusted& camera : cameras)
    for (size_t v = 0; v < camera.problem.views.size(); ++v)
      boards[camera.problem.images[v]].insert(camera.problem.boards[v]);
  std::map<std::pair<int, int>, size_t> counts;
  for (const auto& [image, seen] : boards)
    for (const int a : seen)
      for (const int b : seen)
        if (a < b && ++counts[{a, b}] >= kMinInstants) return true;
  return false;
}

Bodies PossibleBodies(const std::vector<Dataset>& cameras,
                      const Pattern& pattern) {
  Bodies bodies = NoBodies(pattern.boards.size());
  std::vector<RejectedImage> rejected;
  const auto counts = CountTogether(BuildProblem(cameras, pattern, &rejected));
  for (const auto& [pair, count] : counts) {
    PairFinding finding;
    finding.first = pair.first;
    finding.second = pair.second;
    if (count >= kMinInstants) Unite(finding, &bodies);
  }
  return bodies;
}

std::vector<BoardPair> CompareBoards(const std::vector<Adjusted>& adjusted,
                                     const Pattern& pattern, int num_threads,
                                     Bodies* bodies) {
  const std::vector<PairFinding> findings =
      Findings(adjusted, pattern, num_threads);
  *bodies = NoBodies(pattern.boards.size());
  std::vector<const PairFinding*> best;
  for (const PairFinding& finding : findings)
    if (finding.told.fixed) best.push_back(&finding);
  std::stable_sort(best.begin(), best.end(), [](const auto* a, const auto* b) {
    return a->told.num_instants > b->told.num_instants;
  });
  for (const PairFinding* finding : best)
    if (!WouldBreak(*finding, *bodies, findings)) Unite(*finding, bodies);
  SetApart(findings, bodies);
  if (bodies->Groups().empty()) *bodies = {};
  std::vector<BoardPair> pairs;
  for (const PairFinding& finding : findings) pairs.push_back(finding.told);
  return pairs;
}

}  // namespace raygrid
