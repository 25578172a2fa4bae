#include "calibration/mixed_cameras.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "calibration/camera_adjustment.h"
#include "calibration/camera_evaluation.h"
#include "calibration/camera_initialization.h"
#include "calibration/even_selection.h"
#include "calibration/split_gain.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr size_t kMinPartImages = 4;  // minimum images per camera
constexpr size_t kMaxFeatures = 60;   // per image, for the search
// Maximum ratio of the RMS residuals of two cameras to those of one. Random
// splits, or a single lens with local distortion, reduce the residuals much
// less.
constexpr double kMuchBetter = 0.8;
constexpr size_t kNumChanceSplits = 2;

std::vector<FeatureResidual> ResidualsOf(const Pattern& pattern,
                                         const AdjustmentResult& adjusted,
                                         int num_threads) {
  std::vector<FeatureResidual> list;
  const auto& views = adjusted.problem.views;
  const std::vector<Residual> residuals =
      ComputeResiduals(adjusted.state, views, num_threads);
  size_t index = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    for (const Observation& observation : views[v].observations) {
      const Residual& residual = residuals[index++];
      if (!residual.valid) continue;
      const Feature feature = adjusted.problem.GetFeature(
          pattern, static_cast<int>(v), observation);
      list.push_back({adjusted.problem.images[v], feature.board, feature.column,
                      feature.row, observation.pixel, residual.error_px});
    }
  }
  return list;
}

bool HasCorrelatedErrors(const std::vector<FeatureResidual>& residuals) {
  return !residuals.empty() &&
         HasCorrelatedErrors(ComputeNeighborCorrelation(residuals).value_or(0),
                             ComputeErrorMetrics(residuals));
}

// Removes the digits from a name.
std::string Stem(const std::string& name) {
  std::string stem;
  for (const char c : name)
    if (!std::isdigit(static_cast<unsigned char>(c))) stem += c;
  return stem;
}

using Names = std::set<std::string>;

std::optional<Names> FirstOfTwoStems(const Dataset& dataset) {
  std::map<std::string, Names> by_stem;
  for (const ImageFeatures& image : dataset.images)
    by_stem[Stem(image.image)].insert(image.image);
  if (by_stem.size() != 2) return std::nullopt;
  return by_stem.begin()->second;
}

// Splits the images by the sign of their residual fields, relative to the mean
// field, along each of the first principal directions of variation.
std::vector<Names> SplitsByResiduals(
    const std::vector<FeatureResidual>& residuals, const ImageSize& size) {
  constexpr int kNumSplits = 3;
  constexpr int kCells = 3;
  constexpr int kNumValues = 2 * kCells * kCells;
  std::map<std::string, std::pair<Eigen::VectorXd, Eigen::VectorXd>> fields;
  for (const FeatureResidual& r : residuals) {
    auto& [sum, count] =
        fields
            .try_emplace(r.image, Eigen::VectorXd::Zero(kNumValues),
                         Eigen::VectorXd::Zero(kNumValues))
            .first->second;
    const auto cell = [](double x, int width) {
      return std::clamp(static_cast<int>(kCells * x / width), 0, kCells - 1);
    };
    const int k = 2 * (cell(r.pixel.y(), size.height) * kCells +
                       cell(r.pixel.x(), size.width));
    sum.segment<2>(k) += r.error_px;
    count.segment<2>(k).array() += 1;
  }
  Eigen::MatrixXd rows(fields.size(), kNumValues);
  int row = 0;
  for (const auto& [image, field] : fields)
    rows.row(row++) =
        (field.first.array() / field.second.array().max(1)).matrix();
  const Eigen::RowVectorXd mean = rows.colwise().mean();
  rows.rowwise() -= mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(rows.transpose() *
                                                              rows);
  std::vector<Names> splits(kNumSplits);
  for (int k = 0; k < kNumSplits; ++k) {
    const Eigen::VectorXd along =
        rows * solver.eigenvectors().col(kNumValues - 1 - k);
    row = 0;
    for (const auto& [image, field] : fields)
      if (along[row++] > 0) splits[k].insert(image);
  }
  return splits;
}

// Returns the first half of the sorted images, for files of two cameras in one
// folder.
Names FirstHalf(const Dataset& dataset) {
  Names all;
  for (const ImageFeatures& image : dataset.images) all.insert(image.image);
  return {all.begin(), std::next(all.begin(), all.size() / 2)};
}

std::vector<Names> ListSplitsToTry(
    const Dataset& dataset, const std::vector<FeatureResidual>& residuals) {
  if (const auto stems = FirstOfTwoStems(dataset)) return {*stems};
  std::vector<Names> splits = SplitsByResiduals(residuals, dataset.image_size);
  splits.push_back(FirstHalf(dataset));
  return splits;
}

struct TwoParts {
  Dataset first, second;
};

TwoParts SplitBy(const Dataset& dataset, const Names& first) {
  TwoParts parts;
  parts.first.image_size = parts.second.image_size = dataset.image_size;
  for (const ImageFeatures& image : dataset.images)
    (first.count(image.image) > 0 ? parts.first : parts.second)
        .images.push_back(image);
  return parts;
}

double SquareSum(const std::vector<FeatureResidual>& residuals) {
  double sum = 0;
  for (const FeatureResidual& r : residuals) sum += r.error_px.squaredNorm();
  return sum;
}

double MeanSquare(const std::vector<FeatureResidual>& residuals) {
  return residuals.empty()
             ? INFINITY
             : SquareSum(residuals) / static_cast<double>(residuals.size());
}

double MeanSquareOfBoth(const std::vector<FeatureResidual>& a,
                        const std::vector<FeatureResidual>& b) {
  return (SquareSum(a) + SquareSum(b)) /
         static_cast<double>(a.size() + b.size());
}

std::vector<std::string> NamesOf(const Dataset& dataset) {
  std::vector<std::string> names;
  for (const ImageFeatures& image : dataset.images)
    names.push_back(image.image);
  return names;
}

// Returns the knot spacing of an initial camera that is a grid; 0 for other
// models.
double GetKnotSpacingPx(const CameraModel& lens) {
  const BSplineSurface* grid = lens.DirectionGrid();
  return grid ? std::max(grid->cell_width(), grid->cell_height()) : 0;
}

// Returns the residuals of a separate camera with board deformation,
// initialized from the joint camera; empty if the adjustment fails.
std::vector<FeatureResidual> OptimizeFully(const Dataset& dataset,
                                           const Pattern& pattern,
                                           const CameraModel& joint,
                                           const AdjustmentOptions& options) {
  try {
    AdjustmentResult adjusted = InitializeCamera(
        dataset, pattern, options, AreaChoice::kWholeImage, &joint);
    const CameraModel& lens = adjusted.state.camera();
    OptimizeModel(pattern, lens.Name(), {GetKnotSpacingPx(lens)}, options,
                  &adjusted);
    return ResidualsOf(pattern, adjusted, options.num_threads);
  } catch (const Error&) {
    return {};
  }
}

// Returns the views of the named images, or of all other images.
AdjustmentResult PartOf(const AdjustmentResult& joint, const Names& names,
                        bool is_first) {
  AdjustmentResult part = joint;
  std::vector<bool> remove;
  std::vector<Pose> kept;
  for (size_t v = 0; v < joint.problem.views.size(); ++v) {
    remove.push_back((names.count(joint.problem.images[v]) > 0) != is_first);
    // Each view has a separate pose, in the order of the views.
    if (!remove.back()) kept.push_back(joint.state.rig_from_pattern[v]);
  }
  RemoveViews(remove, &part.problem);
  part.state.rig_from_pattern = std::move(kept);
  return part;
}

// Two cameras, each optimized on its own views and initialized from the joint
// camera.
class TwoFits {
 public:
  TwoFits(const AdjustmentResult& joint, const Pattern& pattern,
          const Names& names, const AdjustmentOptions& options)
      : pattern_(pattern), options_(options) {
    for (const bool is_first : {true, false}) {
      AdjustmentResult part = PartOf(joint, names, is_first);
      if (part.problem.views.size() < kMinPartImages) return;
      RefineCameras(part.problem, options, &part.state);
      residuals_.push_back(ResidualsOf(pattern, part, options.num_threads));
      if (residuals_.back().empty()) return;
      fits_.push_back(std::move(part));
    }
  }

  bool AreFitted() const { return fits_.size() == 2; }

  double MeanSquare() const {
    return MeanSquareOfBoth(residuals_[0], residuals_[1]);
  }

  // Returns the images that the first camera predicts better than the second
  // one.
  Names PreferringFirst(const Dataset& dataset) const {
    std::map<std::string, double> better;
    for (int k = 0; k < 2; ++k) {
      std::map<std::string, std::vector<FeatureResidual>> by_image;
      for (const FeatureResidual& r :
           EvaluateCamera(fits_[k].state.camera(), dataset,
                          MakeEstimatedPattern(pattern_, fits_[k]),
                          options_.num_threads)
               .residuals)
        by_image[r.image].push_back(r);
      for (const ImageFeatures& image : dataset.images)
        better[image.image] +=
            (k == 0 ? -1 : 1) *
            std::min(1e6, raygrid::MeanSquare(by_image[image.image]));
    }
    Names first;
    for (const auto& [image, value] : better)
      if (value > 0) first.insert(image);
    return first;
  }

 private:
  const Pattern& pattern_;
  const AdjustmentOptions& options_;
  std::vector<AdjustmentResult> fits_;
  std::vector<std::vector<FeatureResidual>> residuals_;
};

// Selects a subset of the features that suffices for the roughly twelve
// parameters of each of two cameras.
Dataset Subsample(const Dataset& all) {
  constexpr size_t kMaxImages = 40;
  Dataset thinned = all;
  thinned.images = SelectEvenly(all.images, kMaxImages);
  for (ImageFeatures& image : thinned.images)
    image.features = SelectEvenly(image.features, kMaxFeatures);
  return thinned;
}

// Selects the views of a subsampled dataset.
AdjustmentResult SelectSubsampledViews(const AdjustmentResult& joint,
                                       const Dataset& thinned) {
  const std::vector<std::string> names = NamesOf(thinned);
  AdjustmentResult only = PartOf(joint, {names.begin(), names.end()}, true);
  for (View& view : only.problem.views)
    view.observations = SelectEvenly(view.observations, kMaxFeatures);
  return only;
}

// Returns the split of all images whose two cameras fit a subset of the images
// best, if it justifies a full adjustment.
std::optional<Names> FindBestSplit(
    const Dataset& all, const Pattern& pattern, const AdjustmentResult& joint,
    const std::vector<FeatureResidual>& residuals,
    const AdjustmentOptions& options) {
  constexpr int kMaxRounds = 4;
  constexpr double kWorthAnotherLook = 0.9;
  // One linear step predicts the residual ratio of a full adjustment to within
  // 0.003.
  constexpr double kWorthAdjusting = 0.92;
  double best = kWorthAnotherLook * MeanSquare(residuals);
  std::optional<Names> best_split;
  const Dataset training = Subsample(all);
  const AdjustmentResult thinned = SelectSubsampledViews(joint, training);
  const SplitGain gain(thinned, options.huber_px, options.num_threads);
  for (Names first : ListSplitsToTry(all, residuals)) {
    if (gain.ComputeRemainingShare(first) > kWorthAdjusting) continue;
    double before = MeanSquare(residuals);
    for (int round = 0; round < kMaxRounds; ++round) {
      const TwoFits fits(thinned, pattern, first, options);
      if (!fits.AreFitted()) break;
      const double mean_square = fits.MeanSquare();
      if (mean_square < best) {
        best = mean_square;
        best_split = fits.PreferringFirst(all);
      }
      if (mean_square > kWorthAnotherLook * before) break;
      before = mean_square;
      const Names again = fits.PreferringFirst(training);
      if (again == first) break;
      first = again;
    }
  }
  return best_split;
}

// Returns the mean squared residual of two cameras, each fully adjusted to its
// subset of the images. Infinite if an adjustment fails, or if residuals are
// still correlated and this is not allowed.
double MeanSquareOfParts(const TwoParts& parts, const Pattern& pattern,
                         const CameraModel& joint,
                         const AdjustmentOptions& options, bool may_err_alike) {
  std::vector<FeatureResidual> residuals[2];
  for (const int k : {0, 1}) {
    residuals[k] = OptimizeFully(k == 0 ? parts.first : parts.second, pattern,
                                 joint, options);
    if (residuals[k].empty() ||
        (!may_err_alike && HasCorrelatedErrors(residuals[k])))
      return INFINITY;
  }
  return MeanSquareOfBoth(residuals[0], residuals[1]);
}

// Returns the smallest mean squared residual over control splits into subsets
// of the same sizes, with images at equal intervals in name order. If the model
// does not fit the lens, any split reduces the residuals.
double MeanSquareByChance(const Dataset& dataset, size_t num_first,
                          const Pattern& pattern, const CameraModel& joint,
                          const AdjustmentOptions& options) {
  double least = INFINITY;
  const std::vector<std::string> names = NamesOf(dataset);
  for (size_t split = 0; split < kNumChanceSplits; ++split) {
    Names first;
    for (size_t k = 0; k < num_first; ++k)
      first.insert(
          names[(k * names.size() / num_first + split) % names.size()]);
    least = std::min(least, MeanSquareOfParts(SplitBy(dataset, first), pattern,
                                              joint, options, true));
  }
  return least;
}

}  // namespace

std::optional<MixedCameras> DetectMixedCameras(
    const Dataset& training, const Pattern& pattern,
    const AdjustmentResult& joint, const AdjustmentOptions& options) {
  if (training.images.size() < 2 * kMinPartImages) return std::nullopt;
  const std::vector<FeatureResidual> residuals =
      ResidualsOf(pattern, joint, options.num_threads);
  if (!HasCorrelatedErrors(residuals)) return std::nullopt;
  // Points that are estimated separately for each subset would absorb larger
  // errors than the camera models.
  AdjustmentOptions fixed = options;
  fixed.fix_points = true;
  const auto first = FindBestSplit(training, pattern, joint, residuals, fixed);
  if (!first) return std::nullopt;
  const TwoParts parts = SplitBy(training, *first);
  const CameraModel& lens = joint.state.camera();
  const std::vector<FeatureResidual> of_all =
      OptimizeFully(training, pattern, lens, options);
  if (!HasCorrelatedErrors(of_all)) return std::nullopt;
  const double bound = kMuchBetter * kMuchBetter;
  const double of_two = MeanSquareOfParts(parts, pattern, lens, options, false);
  if (of_two > bound * MeanSquare(of_all) ||
      of_two > bound * MeanSquareByChance(training, parts.first.images.size(),
                                          pattern, lens, options))
    return std::nullopt;
  MixedCameras two = {NamesOf(parts.first), NamesOf(parts.second)};
  if (two.second < two.first) std::swap(two.first, two.second);
  return two;
}

}  // namespace raygrid
