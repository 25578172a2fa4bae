#include "calibration/transformed_images.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "calibration/camera_evaluation.h"
#include "calibration/camera_initialization.h"
#include "calibration/camera_result.h"
#include "calibration/divergence.h"
#include "calibration/even_selection.h"
#include "calibration/image_splits.h"
#include "camera/fixed_camera.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

using Kind = TransformedImages::Kind;

// Minimum number of images that are not transformed.
constexpr size_t kMinOthers = 3;

// A transformation of the pixel coordinates of a group of images.
struct PixelTransform {
  Kind kind;
  double scale = 1;  // of the group, relative to the other images

  // Returns the pixel coordinates before the transformation.
  Eigen::Vector2d UndoTransform(const Eigen::Vector2d& pixel,
                                const ImageSize& size) const {
    if (kind == Kind::kRotated)
      return {size.width - 1 - pixel.x(), size.height - 1 - pixel.y()};
    return (pixel.array() + 0.5) / scale - 0.5;
  }
};

Dataset UndoTransform(const PixelTransform& transform, const ImageNames& group,
                      Dataset dataset) {
  for (ImageFeatures& image : dataset.images)
    if (group.count(image.image) > 0)
      for (Feature& feature : image.features)
        feature.pixel =
            transform.UndoTransform(feature.pixel, dataset.image_size);
  return dataset;
}

// A camera's squared residuals by image, each limited by ErrorCapPx(), which is
// also the residual of features that cannot be projected.
std::map<std::string, double> ComputeCosts(const CameraModel& camera,
                                           const Dataset& dataset,
                                           const Pattern& pattern,
                                           int num_threads) {
  const double cap = std::pow(ErrorCapPx(dataset.image_size), 2);
  std::map<std::string, double> costs;
  for (const ImageFeatures& image : dataset.images)
    costs[image.image] = cap * static_cast<double>(image.features.size());
  for (const FeatureResidual& r :
       EvaluateCamera(camera, dataset, pattern, num_threads).residuals)
    costs[r.image] += std::min(r.error_px.squaredNorm(), cap) - cap;
  return costs;
}

// The costs of images as given, and with the transformation undone.
struct CostsByImage {
  std::map<std::string, double> original, untransformed;

  // Images that fit better with the transformation undone.
  ImageNames Transformed(double ratio = 1) const {
    return ListImagesBelowRatio(ratio, untransformed, original);
  }
  ImageNames NotTransformed(double ratio) const {
    return ListImagesBelowRatio(ratio, original, untransformed);
  }

 private:
  static ImageNames ListImagesBelowRatio(
      double ratio, const std::map<std::string, double>& costs,
      const std::map<std::string, double>& others) {
    ImageNames names;
    for (const auto& [name, cost] : costs)
      if (cost < ratio * others.at(name)) names.insert(name);
    return names;
  }
};

// Selects enough images and features for a parametric model. A constant stride
// could select the transformed images only.
Dataset SubsampleFeatures(const Dataset& all) {
  constexpr size_t kMaxSearchImages = 30, kMaxFeaturesPerImage = 40;
  const size_t count = std::min(kMaxSearchImages, all.images.size());
  Dataset subsampled = {all.image_size, {}};
  for (size_t k = 0; k < count; ++k) {
    subsampled.images.push_back(all.images[k * all.images.size() / count]);
    std::vector<Feature>& features = subsampled.images.back().features;
    features = SelectEvenly(features, kMaxFeaturesPerImage);
  }
  return subsampled;
}

std::vector<FeatureResidual> SelectImages(
    const std::vector<FeatureResidual>& residuals, const Dataset& images) {
  const std::vector<std::string> names = ListImageNames(images);
  const ImageNames selected(names.begin(), names.end());
  std::vector<FeatureResidual> residuals_of_images;
  for (const FeatureResidual& residual : residuals)
    if (selected.count(residual.image) > 0)
      residuals_of_images.push_back(residual);
  return residuals_of_images;
}

// A group of images, and the camera for which it is transformed back.
struct Hypothesis {
  PixelTransform transform;
  ImageNames group;
  double cost = INFINITY;
  bool has_correlated_errors = true;
};

// Estimates the group of transformed images and the camera alternately.
class GroupSearch {
 public:
  GroupSearch(const Dataset& images, const Pattern& pattern,
              const AdjustmentResult& joint, const AdjustmentOptions& options)
      : images_(images), pattern_(pattern), joint_(joint), options_(options) {
    options_.fix_points = true;
  }

  // The cost without any transformation; infinite if no camera fits.
  double cost() const { return ComputeCostFrom(joint_.state.camera()); }

  // The same, with the camera of a hypothesis as the initial value: it may be
  // better for reasons other than the transformation.
  double ComputeCostFrom(const Hypothesis& hypothesis) const {
    const auto adjusted =
        Fit(UndoTransform(hypothesis.transform, hypothesis.group, images_));
    return adjusted ? ComputeCostFrom(adjusted->state.camera()) : INFINITY;
  }

  // Groups of images that each transformation may have changed.
  std::vector<ImageNames> ListGroups(
      const PixelTransform& transform,
      const std::vector<ImageNames>& splits) const {
    if (transform.kind == Kind::kScaled)
      return {ListImagesWithinScale(transform.scale)};
    std::vector<ImageNames> groups = splits;
    groups.push_back(
        Compare(joint_.state.camera(), transform, images_).Transformed());
    return groups;
  }

  CostsByImage Compare(const CameraModel& camera,
                       const PixelTransform& transform,
                       const Dataset& images) const {
    const std::vector<std::string> names = ListImageNames(images);
    const Dataset untransformed =
        UndoTransform(transform, {names.begin(), names.end()}, images);
    return {
        ComputeCosts(camera, images, pattern_, options_.num_threads),
        ComputeCosts(camera, untransformed, pattern_, options_.num_threads)};
  }

  // Classifies all images with the camera of a hypothesis. The smaller group is
  // described, since which one was transformed is unknown.
  TransformedImages Describe(const Hypothesis& hypothesis,
                             const Dataset& all) const {
    constexpr double kMaxTransformedCostRatio = 0.7;
    TransformedImages found = {hypothesis.transform.kind,
                               hypothesis.transform.scale,
                               {},
                               all.images.size()};
    const auto adjusted =
        Fit(UndoTransform(hypothesis.transform, hypothesis.group, images_));
    if (!adjusted) return found;
    const CostsByImage costs =
        Compare(adjusted->state.camera(), hypothesis.transform, all);
    ImageNames group = costs.Transformed(kMaxTransformedCostRatio);
    const ImageNames others = costs.NotTransformed(kMaxTransformedCostRatio);
    if (others.size() < group.size()) {
      group = others;
      found.scale = 1 / found.scale;
    }
    found.images.assign(group.begin(), group.end());
    return found;
  }

  // Searches from an initial group, as long as the cost decreases from that
  // without any transformation.
  Hypothesis Search(const PixelTransform& transform, ImageNames group,
                    double cost) const {
    constexpr int kMaxRounds = 5;
    constexpr double kWorthAnotherRound = 0.98;
    Hypothesis best = {transform, {}, cost};
    for (int round = 0; round < kMaxRounds; ++round) {
      if (group.empty() || group.size() + kMinOthers > images_.images.size())
        break;
      const Dataset untransformed = UndoTransform(transform, group, images_);
      const auto adjusted = Fit(untransformed);
      if (!adjusted) break;
      Hypothesis now = Evaluate(*adjusted, untransformed);
      const bool is_better = now.cost < kWorthAnotherRound * best.cost;
      if (now.cost < best.cost) {
        best.cost = now.cost;
        best.has_correlated_errors = now.has_correlated_errors;
        best.group = group;
      }
      ImageNames again =
          Compare(adjusted->state.camera(), transform, images_).Transformed();
      // The first group may contain small targets of the other images.
      const bool may_recover = round == 0 && transform.kind == Kind::kScaled;
      if (again == group || !(is_better || may_recover)) break;
      group = std::move(again);
    }
    return best;
  }

 private:
  std::optional<AdjustmentResult> Fit(const Dataset& dataset) const {
    return Fit(dataset, joint_.state.camera());
  }

  double ComputeCostFrom(const CameraModel& start) const {
    const auto adjusted = Fit(images_, start);
    return adjusted ? Evaluate(*adjusted, images_).cost : INFINITY;
  }

  std::optional<AdjustmentResult> Fit(const Dataset& dataset,
                                      const CameraModel& start) const {
    try {
      if (IsFixed(start))
        return InitializeKnownCamera(start, dataset, pattern_,
                                     AreaChoice::kWholeImage,
                                     options_.num_threads);
      return InitializeCamera(dataset, pattern_, options_,
                              AreaChoice::kWholeImage, &start);
    } catch (const Error&) {
      return std::nullopt;
    }
  }

  Hypothesis Evaluate(const AdjustmentResult& adjusted,
                      const Dataset& dataset) const {
    Hypothesis hypothesis;
    hypothesis.cost = 0;
    for (const auto& [image, cost] : ComputeCosts(
             adjusted.state.camera(), dataset, pattern_, options_.num_threads))
      hypothesis.cost += cost;
    hypothesis.has_correlated_errors = HasCorrelatedErrors(
        ComputeTrainingResiduals(pattern_, adjusted, 0, options_.num_threads));
    return hypothesis;
  }

  // Images whose features all lie within a scaled image.
  ImageNames ListImagesWithinScale(double scale) const {
    ImageNames group;
    for (const ImageFeatures& image : images_.images)
      if (std::all_of(
              image.features.begin(), image.features.end(),
              [&](const Feature& feature) {
                return feature.pixel.x() < scale * images_.image_size.width &&
                       feature.pixel.y() < scale * images_.image_size.height;
              }))
        group.insert(image.image);
    return group;
  }

  const Dataset& images_;
  const Pattern& pattern_;
  const AdjustmentResult& joint_;
  AdjustmentOptions options_;
};

const std::vector<PixelTransform>& Transforms() {
  static const std::vector<PixelTransform> transforms = {
      {Kind::kRotated},     {Kind::kScaled, 0.25},    {Kind::kScaled, 1.0 / 3},
      {Kind::kScaled, 0.5}, {Kind::kScaled, 2.0 / 3}, {Kind::kScaled, 0.75}};
  return transforms;
}

// Smaller errors than these do not bias the camera much.
bool MayBeScaled(double cost, const Dataset& images) {
  constexpr double kMinPart = 1.0 / 6400;  // of the image width
  return cost > std::pow(kMinPart * images.image_size.width, 2) *
                    static_cast<double>(images.num_features());
}

// A group of random images reduces the cost, too, if the principal point varies
// between images, and motion with a rolling shutter reduces it to 0.6.
bool ExplainsImages(const Hypothesis& hypothesis, double cost) {
  constexpr double kMaxExplainedCostRatio = 0.4,
                   kMaxFullyExplainedCostRatio = 0.1;
  return hypothesis.cost < (hypothesis.has_correlated_errors
                                ? kMaxFullyExplainedCostRatio
                                : kMaxExplainedCostRatio) *
                               cost;
}

}  // namespace

std::optional<TransformedImages> DetectTransformedImages(
    const Dataset& training, const Pattern& pattern,
    const AdjustmentResult& joint, const AdjustmentOptions& options) {
  if (training.images.size() <= kMinOthers) return std::nullopt;
  const std::vector<FeatureResidual> residuals =
      ComputeTrainingResiduals(pattern, joint, 0, options.num_threads);
  // Images of another scale may have been rejected.
  if (!HasCorrelatedErrors(residuals) && joint.rejected_images.empty())
    return std::nullopt;
  const Dataset images = SubsampleFeatures(training);
  const GroupSearch search(images, pattern, joint, options);
  const double cost = search.cost();
  if (!std::isfinite(cost)) return std::nullopt;
  const std::vector<ImageNames> splits =
      ListSplitsToTry(images, SelectImages(residuals, images));
  Hypothesis best;
  for (const PixelTransform& transform : Transforms()) {
    if (transform.kind == Kind::kScaled && !MayBeScaled(cost, images)) continue;
    for (const ImageNames& group : search.ListGroups(transform, splits)) {
      Hypothesis found = search.Search(transform, group, cost);
      if (found.cost < best.cost) best = std::move(found);
    }
  }
  if (!ExplainsImages(best, cost) ||
      !ExplainsImages(best, search.ComputeCostFrom(best)))
    return std::nullopt;
  TransformedImages found = search.Describe(best, training);
  if (found.images.empty()) return std::nullopt;
  return found;
}

}  // namespace raygrid
