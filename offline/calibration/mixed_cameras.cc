#include "calibration/mixed_cameras.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "calibration/camera_adjustment.h"
#include "calibration/camera_evaluation.h"
#include "calibration/camera_initialization.h"
#include "calibration/camera_result.h"
#include "calibration/even_selection.h"
#include "calibration/image_splits.h"
#include "calibration/split_gain.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr size_t kMinSubsetImages = 4;  // minimum images per camera
constexpr size_t kMaxFeatures = 60;     // per image, for the search
// Maximum ratio of the RMS residuals of two cameras to those of one. Random
// splits, or a single lens with local distortion, reduce the residuals much
// less.
constexpr double kMaxSplitRatio = 0.8;
constexpr size_t kNumRandomSplits = 2;

using Names = ImageNames;

struct DatasetSplit {
  Dataset first, second;
};

DatasetSplit SplitDataset(const Dataset& dataset, const Names& first) {
  DatasetSplit parts;
  parts.first.image_size = parts.second.image_size = dataset.image_size;
  for (const ImageFeatures& image : dataset.images)
    (first.count(image.image) > 0 ? parts.first : parts.second)
        .images.push_back(image);
  return parts;
}

double SumSquaredResiduals(const std::vector<FeatureResidual>& residuals) {
  double sum = 0;
  for (const FeatureResidual& r : residuals) sum += r.error_px.squaredNorm();
  return sum;
}

double ComputeMeanSquare(const std::vector<FeatureResidual>& residuals) {
  return residuals.empty() ? INFINITY
                           : SumSquaredResiduals(residuals) /
                                 static_cast<double>(residuals.size());
}

double ComputePooledMeanSquare(const std::vector<FeatureResidual>& a,
                               const std::vector<FeatureResidual>& b) {
  return (SumSquaredResiduals(a) + SumSquaredResiduals(b)) /
         static_cast<double>(a.size() + b.size());
}

std::vector<std::string> CollectImageNames(const Dataset& dataset) {
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
std::vector<FeatureResidual> OptimizeAll(const Dataset& dataset,
                                         const Pattern& pattern,
                                         const CameraModel& joint,
                                         const AdjustmentOptions& options) {
  try {
    AdjustmentResult adjusted = InitializeCamera(
        dataset, pattern, options, AreaChoice::kWholeImage, &joint);
    const CameraModel& lens = adjusted.state.camera();
    OptimizeModel(pattern, lens.Name(), {GetKnotSpacingPx(lens)}, options,
                  &adjusted);
    return ComputeTrainingResiduals(pattern, adjusted, 0, options.num_threads);
  } catch (const Error&) {
    return {};
  }
}

// Returns the views of the named images, or of all other images.
AdjustmentResult SelectImages(const AdjustmentResult& joint, const Names& names,
                              bool is_first) {
  std::vector<bool> remove;
  for (const std::string& image : joint.problem.images)
    remove.push_back((names.count(image) > 0) != is_first);
  return RemoveViewsAndPoses(remove, joint);
}

// Two cameras, each optimized on its own views and initialized from the joint
// camera.
class SubsetFits {
 public:
  SubsetFits(const AdjustmentResult& joint, const Pattern& pattern,
             const Names& names, const AdjustmentOptions& options)
      : pattern_(pattern), options_(options) {
    for (const bool is_first : {true, false}) {
      AdjustmentResult subset = SelectImages(joint, names, is_first);
      if (subset.problem.views.size() < kMinSubsetImages) return;
      RefineCameras(subset.problem, options, &subset.state);
      residuals_.push_back(
          ComputeTrainingResiduals(pattern, subset, 0, options.num_threads));
      if (residuals_.back().empty()) return;
      fits_.push_back(std::move(subset));
    }
  }

  bool AreFitted() const { return fits_.size() == 2; }

  double ComputeMeanSquare() const {
    return ComputePooledMeanSquare(residuals_[0], residuals_[1]);
  }

  // Returns the images that the first camera predicts better than the second
  // one.
  Names ListImagesFittingFirst(const Dataset& dataset) const {
    std::map<std::string, double> better;
    for (int k = 0; k < 2; ++k) {
      std::map<std::string, std::vector<FeatureResidual>> residuals_by_image;
      for (const FeatureResidual& r :
           EvaluateCamera(fits_[k].state.camera(), dataset,
                          MakeEstimatedPattern(pattern_, fits_[k]),
                          options_.num_threads)
               .residuals)
        residuals_by_image[r.image].push_back(r);
      for (const ImageFeatures& image : dataset.images)
        better[image.image] +=
            (k == 0 ? -1 : 1) *
            std::min(1e6, raygrid::ComputeMeanSquare(
                              residuals_by_image[image.image]));
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
  const std::vector<std::string> names = CollectImageNames(thinned);
  AdjustmentResult only =
      SelectImages(joint, {names.begin(), names.end()}, true);
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
  constexpr double kMaxMeanSquareRatio = 0.9;
  // One linear step predicts the residual ratio of a full adjustment to within
  // 0.003.
  constexpr double kMaxPredictedRatio = 0.92;
  double best = kMaxMeanSquareRatio * ComputeMeanSquare(residuals);
  std::optional<Names> best_split;
  const Dataset training = Subsample(all);
  const AdjustmentResult thinned = SelectSubsampledViews(joint, training);
  const SplitGain gain(thinned, options.huber_px, options.num_threads);
  for (Names first : ListSplitsToTry(all, residuals)) {
    if (gain.ComputeRemainingShare(first) > kMaxPredictedRatio) continue;
    double before = ComputeMeanSquare(residuals);
    for (int round = 0; round < kMaxRounds; ++round) {
      const SubsetFits fits(thinned, pattern, first, options);
      if (!fits.AreFitted()) break;
      const double mean_square = fits.ComputeMeanSquare();
      if (mean_square < best) {
        best = mean_square;
        best_split = fits.ListImagesFittingFirst(all);
      }
      if (mean_square > kMaxMeanSquareRatio * before) break;
      before = mean_square;
      const Names again = fits.ListImagesFittingFirst(training);
      if (again == first) break;
      first = again;
    }
  }
  return best_split;
}

// Returns the mean squared residual of two cameras, each fully adjusted to its
// subset of the images. Infinite if an adjustment fails, or if residuals are
// still correlated and this is not allowed.
double ComputeSplitMeanSquare(const DatasetSplit& parts, const Pattern& pattern,
                              const CameraModel& joint,
                              const AdjustmentOptions& options,
                              bool may_share_errors) {
  std::vector<FeatureResidual> residuals[2];
  for (const int k : {0, 1}) {
    residuals[k] = OptimizeAll(k == 0 ? parts.first : parts.second, pattern,
                               joint, options);
    if (residuals[k].empty() ||
        (!may_share_errors && HasCorrelatedErrors(residuals[k])))
      return INFINITY;
  }
  return ComputePooledMeanSquare(residuals[0], residuals[1]);
}

// Returns the smallest mean squared residual over control splits into subsets
// of the same sizes, with images at equal intervals in name order. If the model
// does not fit the lens, any split reduces the residuals.
double ComputeRandomSplitMeanSquare(const Dataset& dataset, size_t num_first,
                                    const Pattern& pattern,
                                    const CameraModel& joint,
                                    const AdjustmentOptions& options) {
  double min_mean_square = INFINITY;
  const std::vector<std::string> names = CollectImageNames(dataset);
  for (size_t split = 0; split < kNumRandomSplits; ++split) {
    Names first;
    for (size_t k = 0; k < num_first; ++k)
      first.insert(
          names[(k * names.size() / num_first + split) % names.size()]);
    min_mean_square = std::min(
        min_mean_square, ComputeSplitMeanSquare(SplitDataset(dataset, first),
                                                pattern, joint, options, true));
  }
  return min_mean_square;
}

}  // namespace

std::optional<MixedCameras> DetectMixedCameras(
    const Dataset& training, const Pattern& pattern,
    const AdjustmentResult& joint, const AdjustmentOptions& options) {
  if (training.images.size() < 2 * kMinSubsetImages) return std::nullopt;
  const std::vector<FeatureResidual> residuals =
      ComputeTrainingResiduals(pattern, joint, 0, options.num_threads);
  if (!HasCorrelatedErrors(residuals)) return std::nullopt;
  // Points that are estimated separately for each subset would absorb larger
  // errors than the camera models.
  AdjustmentOptions fixed = options;
  fixed.fix_points = true;
  const auto first = FindBestSplit(training, pattern, joint, residuals, fixed);
  if (!first) return std::nullopt;
  const DatasetSplit parts = SplitDataset(training, *first);
  const CameraModel& lens = joint.state.camera();
  const std::vector<FeatureResidual> all_residuals =
      OptimizeAll(training, pattern, lens, options);
  if (!HasCorrelatedErrors(all_residuals)) return std::nullopt;
  const double bound = kMaxSplitRatio * kMaxSplitRatio;
  const double split_mean_square =
      ComputeSplitMeanSquare(parts, pattern, lens, options, false);
  if (split_mean_square > bound * ComputeMeanSquare(all_residuals) ||
      split_mean_square > bound * ComputeRandomSplitMeanSquare(
                                      training, parts.first.images.size(),
                                      pattern, lens, options))
    return std::nullopt;
  MixedCameras two = {CollectImageNames(parts.first),
                      CollectImageNames(parts.second)};
  if (two.second < two.first) std::swap(two.first, two.second);
  return two;
}

}  // namespace raygrid
