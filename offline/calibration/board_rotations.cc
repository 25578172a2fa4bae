#include "calibration/board_rotations.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

namespace raygrid {
namespace {

// In-plane displacements of the points of one board in an image: x and y for
// each point, 0 for points without a feature.
struct Displacements {
  std::string image;
  Eigen::VectorXd metres;
  Eigen::VectorXd is_observed;  // 0 or 1, same layout as metres
  double weight = 1;            // inverse noise variance, px^2/m^2
  int num_points() const { return static_cast<int>(is_observed.sum() / 2); }
};

// Transforms the displacements for a board that is rotated by `turn` symmetry
// steps.
Displacements Rotated(const Displacements& before, const Board& board,
                      int turn) {
  Displacements after = before;
  const Eigen::Matrix3d rotation =
      ComputeRotation(board, turn).rotation.toRotationMatrix();
  const Eigen::Matrix2d in_plane = rotation.topLeftCorner<2, 2>();
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) {
      const auto [c, r] = board.Rotated(column, row, turn);
      const int from = 2 * board.PointIndex(column, row);
      const int to = 2 * board.PointIndex(c, r);
      after.metres.segment<2>(to) = in_plane * before.metres.segment<2>(from);
      after.is_observed.segment<2>(to) = before.is_observed.segment<2>(from);
    }
  return after;
}

// Accumulates the in-plane point displacements that explain a view's residuals.
void AddView(const AdjustmentResult& adjusted, const View& view,
             int first_point, Displacements* sum, Eigen::VectorXd* weights) {
  constexpr double kMinSine = 0.15;  // minimum sine of the viewing angle
  for (const LinearizedResidual& linear : LinearizeView(adjusted.state, view)) {
    if (!linear.residual.valid) continue;
    const Eigen::Matrix2d J_plane = linear.J_point.leftCols<2>();
    const double square = J_plane.squaredNorm();
    if (!(std::abs(J_plane.determinant()) > kMinSine * square / 2)) continue;
    const Eigen::Matrix2d inverse = J_plane.inverse();
    const int at = 2 * (linear.point - first_point);
    const double weight = 2 / inverse.squaredNorm();
    sum->metres.segment<2>(at) -= weight * (inverse * linear.residual.error_px);
    weights->segment<2>(at).array() += weight;
  }
}

// Returns the displacements of a board in each image, accumulated over all
// cameras.
std::vector<Displacements> ComputeDisplacements(
    const std::vector<AdjustmentResult>& cameras, int board_index,
    const Board& board) {
  std::map<std::string, std::pair<Displacements, Eigen::VectorXd>> images;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(2 * board.num_points());
  for (const AdjustmentResult& camera : cameras) {
    const CalibrationProblem& problem = camera.problem;
    for (size_t v = 0; v < problem.views.size(); ++v) {
      if (problem.boards[v] != board_index) continue;
      auto& [sum, weights] =
          images
              .try_emplace(problem.images[v],
                           Displacements{problem.images[v], none, none, 1},
                           none)
              .first->second;
      AddView(camera, problem.views[v], problem.first_points[board_index], &sum,
              &weights);
    }
  }
  std::vector<Displacements> all;
  for (auto& [name, image] : images) {
    auto& [sum, weights] = image;
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
      if (!(weights[i] > 0)) continue;
      sum.metres[i] /= weights[i];
      sum.is_observed[i] = 1;
    }
    if (sum.num_points() == 0) continue;
    sum.weight = weights.sum() / sum.is_observed.sum();
    all.push_back(std::move(sum));
  }
  return all;
}

// Displacements of a board in several images under each symmetry rotation of
// the board, and a search for the rotations under which they are most
// consistent.
class RotationSearch {
 public:
  RotationSearch(const std::vector<Displacements>& images, const Board& board)
      : board_(board), num_rotations_(board.NumRotations()) {
    for (const Displacements& image : images) {
      rotated_displacements_.emplace_back();
      for (int turn = 0; turn < num_rotations_; ++turn)
        rotated_displacements_.back().push_back(Rotated(image, board, turn));
    }
  }

  // Searches from the current rotations and from several seeds, which are the
  // images with the most points.
  void Run() {
    constexpr size_t kStarts = 8;
    rotations_.assign(rotated_displacements_.size(), 0);
    Improve(&rotations_);
    double best = ComputeAgreement(rotations_);
    std::vector<size_t> order(rotated_displacements_.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [this](size_t a, size_t b) {
      return rotated_displacements_[a][0].num_points() >
             rotated_displacements_[b][0].num_points();
    });
    order.resize(std::min(order.size(), kStarts));
    for (const size_t first : order) {
      std::vector<int> turns;
      for (size_t i = 0; i < rotated_displacements_.size(); ++i)
        turns.push_back(FindBestRotation(
            i, KeepCommonPoints(rotated_displacements_[first][0])));
      turns[first] = 0;
      Improve(&turns);
      const double agreement = ComputeAgreement(turns);
      if (agreement <= best) continue;
      best = agreement;
      rotations_ = turns;
    }
    MakeMostFrequentRotationIdentity();
  }

  const std::vector<int>& turns() const { return rotations_; }

  // Whether the rotation in this image makes a significant difference according
  // to the other images, but cannot be determined from this image.
  bool IsRotationAmbiguous(size_t image, double min_significance) const {
    const Displacements mean = ComputeMeanOfOthers(
        SumLanes(rotations_), rotated_displacements_[image][rotations_[image]]);
    for (int turn = 0; turn < num_rotations_; ++turn)
      if (turn != rotations_[image] &&
          IsRotationSignificant(image, turn, mean) &&
          ComputeAdvantage(image, turn, mean) < min_significance)
        return true;
    return false;
  }

  // Returns the significance of an image's rotation relative to no rotation, in
  // standard deviations.
  double ComputeRotationSignificance(size_t image) const {
    return ComputeAdvantage(
        image, 0,
        ComputeMeanOfOthers(SumLanes(rotations_),
                            rotated_displacements_[image][rotations_[image]]));
  }

 private:
  using Turns = std::vector<int>;

  // Removes points that are not visible under every rotation, so that all
  // rotations of an image are compared on the same points.
  Displacements KeepCommonPoints(Displacements all) const {
    Eigen::VectorXd is_observed = all.is_observed;
    for (int turn = 1; turn < num_rotations_; ++turn)
      is_observed =
          is_observed.cwiseProduct(Rotated(all, board_, turn).is_observed);
    all.is_observed = is_observed;
    all.metres = all.metres.cwiseProduct(is_observed);
    return all;
  }

  // Weighted sum over all images with their current rotations.
  struct Sum {
    Eigen::VectorXd metres, weights, counts;
  };
  void Add(const Displacements& one, double sign, Sum* sum) const {
    sum->metres += sign * one.weight * one.metres;
    sum->weights += sign * one.weight * one.is_observed;
    sum->counts += sign * one.is_observed;
  }
  Sum SumLanes(const Turns& turns) const {
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(
        rotated_displacements_.front().front().metres.size());
    Sum sum = {none, none, none};
    for (size_t i = 0; i < rotated_displacements_.size(); ++i)
      Add(rotated_displacements_[i][turns[i]], 1, &sum);
    return sum;
  }
  Displacements ComputeMean(const Sum& sum) const {
    Displacements mean = rotated_displacements_.front().front();
    mean.is_observed = (sum.counts.array() > 0.5).cast<double>();
    mean.metres = (sum.metres.array() / sum.weights.array().max(1e-300)) *
                  mean.is_observed.array();
    return KeepCommonPoints(std::move(mean));
  }
  Displacements ComputeMeanOfOthers(Sum sum, const Displacements& but) const {
    Add(but, -1, &sum);
    return ComputeMean(sum);
  }

  // Returns the rotation of the image that is most consistent with the other
  // images.
  int FindBestRotation(size_t image, const Displacements& others) const {
    int best = 0;
    double most = -INFINITY;
    for (int turn = 0; turn < num_rotations_; ++turn) {
      const Displacements& one = rotated_displacements_[image][turn];
      const double match = 2 * one.metres.dot(others.metres) -
                           one.is_observed.dot(others.metres.cwiseAbs2());
      if (match <= most) continue;
      most = match;
      best = turn;
    }
    return best;
  }

  void Improve(Turns* turns) const {
    constexpr int kMaxRounds = 20;
    for (int round = 0; round < kMaxRounds; ++round) {
      bool has_changed = false;
      Sum sum = SumLanes(*turns);
      for (size_t i = 0; i < rotated_displacements_.size(); ++i) {
        const Displacements& before = rotated_displacements_[i][(*turns)[i]];
        const int turn = FindBestRotation(i, ComputeMeanOfOthers(sum, before));
        if (turn == (*turns)[i]) continue;
        has_changed = true;
        Add(before, -1, &sum);
        Add(rotated_displacements_[i][turn], 1, &sum);
        (*turns)[i] = turn;
      }
      if (!has_changed) return;
    }
  }

  // Returns the weighted sum of squares that is explained by the mean
  // displacement.
  double ComputeAgreement(const Turns& turns) const {
    const Displacements mean = ComputeMean(SumLanes(turns));
    double sum = 0;
    for (size_t i = 0; i < rotated_displacements_.size(); ++i) {
      const Displacements& one = rotated_displacements_[i][turns[i]];
      sum += one.weight * (2 * one.metres.dot(mean.metres) -
                           one.is_observed.dot(mean.metres.cwiseAbs2()));
    }
    return sum;
  }

  void MakeMostFrequentRotationIdentity() {
    std::vector<int> counts(num_rotations_);
    for (const int turn : rotations_) ++counts[turn];
    const int most = static_cast<int>(
        std::max_element(counts.begin(), counts.end()) - counts.begin());
    for (int& turn : rotations_)
      turn = (turn - most + num_rotations_) % num_rotations_;
  }

  // Whether a different rotation changes the board's displacements by more than
  // the uncertainty of the mean over the images, and by a relevant amount.
  bool IsRotationSignificant(size_t image, int other,
                             const Displacements& mean) const {
    constexpr double kMinDisplacementPx2 = 0.01 * 0.01, kMinVarianceRatio = 4;
    const Displacements& chosen =
        rotated_displacements_[image][rotations_[image]];
    const int turn =
        (other - rotations_[image] + num_rotations_) % num_rotations_;
    const Displacements after = Rotated(mean, board_, turn);
    const Eigen::ArrayXd seen =
        chosen.is_observed.array() * mean.is_observed.array();
    const double count = std::max(1.0, seen.sum());
    const auto square = [&](const Eigen::VectorXd& metres) {
      return chosen.weight * (metres.array() * seen).square().sum() / count;
    };
    const double variance_px2 = square(chosen.metres - mean.metres);
    const double num_images =
        static_cast<double>(rotated_displacements_.size());
    // The errors of the mean and of the rotated mean are independent: their
    // variances add up.
    return square(after.metres - mean.metres) >
           std::max(kMinDisplacementPx2,
                    kMinVarianceRatio * 2 * variance_px2 / num_images);
  }

  double ComputeAdvantage(size_t image, int other,
                          const Displacements& mean) const {
    constexpr double kMinNoisePx2 = 1e-6;  // limit of rounding errors
    const Displacements& chosen =
        rotated_displacements_[image][rotations_[image]];
    const Displacements& otherwise = rotated_displacements_[image][other];
    const auto seen = chosen.is_observed.array() * mean.is_observed.array();
    const Eigen::VectorXd left =
        ((chosen.metres - mean.metres).array() * seen).matrix();
    const double chosen_error = left.squaredNorm();
    const double other_error =
        ((otherwise.metres - mean.metres).array() *
         otherwise.is_observed.array() * mean.is_observed.array())
            .matrix()
            .squaredNorm();
    const double count = std::max(1.0, seen.sum());
    const double variance =
        std::max(chosen_error / count, kMinNoisePx2 / chosen.weight);
    // For noise x, <x, a - b> has the variance s^2 |a - b|^2, and the sums of
    // squares differ by twice that inner product.
    const double apart = std::max(other_error - chosen_error, 0.0);
    return std::sqrt(apart / variance) / 2;
  }

  const Board& board_;
  int num_rotations_;
  std::vector<std::vector<Displacements>>
      rotated_displacements_;  // by image, then rotation
  Turns rotations_;
};

}  // namespace

bool HasSymmetricBoards(const Pattern& pattern) {
  return std::any_of(
      pattern.boards.begin(), pattern.boards.end(),
      [](const Board& board) { return board.NumRotations() > 1; });
}

Dataset Rotated(const Dataset& dataset, const Pattern& pattern,
                const BoardRotations& turns) {
  if (turns.empty()) return dataset;
  Dataset rotated_dataset = dataset;
  for (ImageFeatures& image : rotated_dataset.images)
    for (Feature& feature : image.features) {
      const auto found = turns.find({image.image, feature.board});
      const Board* board = pattern.FindBoard(feature.board);
      if (found == turns.end() || !board) continue;
      std::tie(feature.column, feature.row) =
          board->Rotated(feature.column, feature.row, found->second);
    }
  return rotated_dataset;
}

BoardRotations ComposeRotations(const BoardRotations& first,
                                const BoardRotations& second,
                                const Pattern& pattern) {
  BoardRotations joined = first;
  for (const auto& [view, turn] : second) {
    int& sum = joined[view];
    sum = (sum + turn) % pattern.FindBoard(view.second)->NumRotations();
    if (sum == 0) joined.erase(view);
  }
  return joined;
}

AdjustmentResult LocalizeDatasetViews(const CameraModel& camera,
                                      const Dataset& dataset,
                                      const Pattern& pattern, int num_threads) {
  AdjustmentResult localized;
  std::vector<RejectedImage> images_with_few_views;
  localized.problem = BuildProblem({dataset}, pattern, &images_with_few_views);
  localized.state.SetCamera(camera);
  localized.state.points = localized.problem.nominal;
  std::vector<bool> remove;
  for (const std::optional<Pose>& pose :
       LocalizeViews(camera, 0, localized.problem, num_threads)) {
    remove.push_back(!pose);
    if (pose) localized.state.rig_from_pattern.push_back(*pose);
  }
  RemoveViews(remove, &localized.problem);
  return localized;
}

void AddViews(const AdjustmentResult& views, AdjustmentResult* camera) {
  CalibrationProblem& problem = camera->problem;
  std::vector<Pose>& poses = camera->state.rig_from_pattern;
  for (size_t v = 0; v < views.problem.views.size(); ++v) {
    View view = views.problem.views[v];
    const Pose pose = views.state.rig_from_pattern[view.pose];
    view.pose = static_cast<int>(poses.size());
    problem.views.push_back(std::move(view));
    problem.images.push_back(views.problem.images[v]);
    problem.boards.push_back(views.problem.boards[v]);
    poses.push_back(pose);
  }
  problem.num_poses = static_cast<int>(poses.size());
}

Pose ComputeRotation(const Board& board, int turn) {
  const Eigen::Vector3d center =
      board.square_m / 2 *
      Eigen::Vector3d(board.columns - 1, board.rows - 1, 0);
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(
      2 * M_PI * turn / board.NumRotations(), Eigen::Vector3d::UnitZ()));
  return {rotation, center - rotation * center};
}

GeometricRotations ResolveRotationsByGeometry(
    const std::vector<AdjustmentResult>& cameras, const Pattern& pattern) {
  // Errors of neighbouring points are correlated, so that random scores exceed
  // their nominal standard deviation.
  constexpr double kMinSignificance = 5;
  constexpr size_t kMinViewsPerAmbiguous = 3;
  GeometricRotations found;
  for (size_t b = 0; b < pattern.boards.size(); ++b) {
    const Board& board = pattern.boards[b];
    if (board.NumRotations() < 2) continue;
    const std::vector<Displacements> images =
        ComputeDisplacements(cameras, static_cast<int>(b), board);
    if (images.size() < 2) continue;
    RotationSearch search(images, board);
    search.Run();
    std::vector<std::pair<std::string, int>> doubtful;
    for (size_t i = 0; i < images.size(); ++i) {
      const std::pair<std::string, int> view(images[i].image, board.id);
      if (search.turns()[i] != 0 &&
          search.ComputeRotationSignificance(i) > kMinSignificance)
        found.turns[view] = search.turns()[i];
      if (search.IsRotationAmbiguous(i, kMinSignificance))
        doubtful.push_back(view);
    }
    // If many views are ambiguous, the board's displacements are below the
    // noise.
    if (kMinViewsPerAmbiguous * doubtful.size() <= images.size())
      found.doubtful.insert(found.doubtful.end(), doubtful.begin(),
                            doubtful.end());
  }
  return found;
}

}  // namespace raygrid
