#include "calibration/image_transforms.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <utility>

#include "calibration/board_turns.h"
#include "calibration/camera_equations.h"
#include "calibration/camera_evaluation.h"
#include "calibration/camera_result.h"
#include "calibration/divergence.h"
#include "calibration/evenly_chosen.h"
#include "calibration/starting_lens.h"
#include "dataset/error.h"

namespace raygrid {
namespace {

// The others tell a lens without the images in question.
constexpr size_t kLeastOthers = 4;
// The part of the squares that is left once a transform is undone: of an image
// at most, of all that have it, of these where they are too few to matter among
// all, and of all images. Where a lens has what its model does not follow,
// chance leaves more.
constexpr double kClearlyLess = 0.8, kMuchLess = 0.5, kFarLess = 0.15,
                 kLessOfAll = 0.7;
// How much less the squares of an image are, in units of the others' variance.
constexpr double kSurely = 25;
// The mean square of images beside that of those that a lens was adjusted to.
constexpr double kMostBesideOthers = 4;

using Costs = std::vector<double>;  // mean squares, by image

double MeanOf(const Costs& costs) {
  double sum = 0;
  for (const double cost : costs) sum += cost;
  return sum / static_cast<double>(std::max<size_t>(1, costs.size()));
}

template <typename Predicate>
Dataset Select(const Dataset& dataset, const Predicate& is_kept) {
  Dataset selected = {dataset.image_size, {}};
  for (const ImageFeatures& image : dataset.images)
    if (is_kept(image)) selected.images.push_back(image);
  return selected;
}

// A part of the features that determines the dozen parameters of a lens.
Dataset Thinned(Dataset dataset) {
  constexpr size_t kMaxImages = 100, kMaxFeatures = 60;
  dataset = Select(dataset, [](const ImageFeatures& image) {
    return image.features.size() >= kMinViewFeatures;
  });
  dataset.images = EvenlyChosen(dataset.images, kMaxImages);
  for (ImageFeatures& image : dataset.images)
    image.features = EvenlyChosen(image.features, kMaxFeatures);
  return dataset;
}

// The transforms that keep the size of images.
std::vector<ImageTransform> Orientations(const ImageSize& size) {
  std::vector<ImageTransform> orientations;
  const int step = size.width == size.height ? 1 : 2;
  for (const bool is_mirrored : {false, true})
    for (int turns = is_mirrored ? 0 : step; turns < 4; turns += step)
      orientations.push_back({is_mirrored, turns, 1});
  return orientations;
}

bool IsItsOwnInverse(const ImageTransform& transform) {
  return transform.scale == 1 &&
         (transform.is_mirrored || transform.quarter_turns == 2);
}

// How large an image may be in proportion to the image size, as far as its
// features say.
double ReachOf(const ImageFeatures& image, const ImageSize& size) {
  double reach = 0;
  for (const Feature& feature : image.features)
    reach = std::max({reach, (feature.pixel.x() + 0.5) / size.width,
                      (feature.pixel.y() + 0.5) / size.height});
  return reach;
}

std::vector<CameraEquations> EquationsByImage(
    const CameraModel& lens, const Dataset& dataset, const Pattern& pattern,
    const AdjustmentOptions& options) {
  const Eigen::Index size = lens.NumParameters();
  std::map<std::string, CameraEquations> by_image;
  for (const CameraEquations& view : EquationsByView(
           LocalizedViews(lens, dataset, pattern, options.num_threads),
           options.huber_px, options.num_threads)) {
    CameraEquations& image =
        by_image
            .try_emplace(
                view.image,
                CameraEquations{view.image, Eigen::MatrixXd::Zero(size, size),
                                Eigen::VectorXd::Zero(size)})
            .first->second;
    image.hessian += view.hessian;
    image.gradient += view.gradient;
    image.squares += view.squares;
    image.count += view.count;
  }
  // Features without a residual have a large one.
  const double cap = std::pow(ErrorCapPx(dataset.image_size), 2);
  std::vector<CameraEquations> equations;
  for (const ImageFeatures& image : dataset.images) {
    const auto found = by_image.find(image.image);
    equations.push_back(found != by_image.end()
                            ? found->second
                            : CameraEquations{image.image,
                                              Eigen::MatrixXd::Zero(size, size),
                                              Eigen::VectorXd::Zero(size)});
    const int count = static_cast<int>(image.features.size());
    equations.back().squares +=
        cap * std::max(0, count - equations.back().count);
    equations.back().count = count;
  }
  return equations;
}

// The images as they are and with a transform undone, each as equations of one
// camera, and the images whose transform is undone with the least squares.
class Assignment {
 public:
  Assignment(std::vector<CameraEquations> as_is,
             std::vector<CameraEquations> undone)
      : as_is_(std::move(as_is)), undone_(std::move(undone)) {}

  size_t count() const { return as_is_.size(); }

  // From a few images each, since most of a camera's change is one direction.
  void Run(bool may_exchange) {
    constexpr int kNumStarts = 60, kStartImages = 3;
    std::mt19937 random_bits;  // of a fixed seed
    Try(std::vector<bool>(count()), may_exchange);
    for (int start = 0; start < kNumStarts; ++start) {
      std::vector<bool> is_undone(count()), is_used(count());
      for (int k = 0; k < kStartImages; ++k) {
        const size_t i = random_bits() % count();
        is_used[i] = true;
        is_undone[i] = random_bits() % 2 == 0;
      }
      is_undone = Preferred(ChangeOf(is_undone, &is_used));
      Try(is_undone, may_exchange);
    }
  }

  // The camera's change, and how it prefers each image.
  const Eigen::VectorXd& change() const { return change_; }
  const std::vector<bool>& is_undone() const { return is_undone_; }

  // An image's squares by the camera of the other images.
  struct Prediction {
    double as_is = 0, undone = 0;
  };
  Prediction Predict(size_t image) const {
    std::vector<bool> is_used(count(), true);
    is_used[image] = false;
    const Eigen::VectorXd change = ChangeOf(is_undone_, &is_used);
    return {as_is_[image].At(change), undone_[image].At(change)};
  }

  // The mean square by all images, each the way that is assigned.
  double MeanSquare() const {
    double sum = 0, num = 0;
    for (size_t i = 0; i < count(); ++i) {
      sum += Of(i, is_undone_).At(change_);
      num += as_is_[i].count;
    }
    return sum / num;
  }
  // The part of the squares of all images as they are that is left.
  double LeftPart() const {
    const std::vector<bool> none(count());
    const Eigen::VectorXd change = ChangeOf(none, nullptr);
    double sum = 0;
    for (const CameraEquations& image : as_is_) sum += image.At(change);
    return least_ / sum;
  }
  int NumFeatures(size_t image) const { return as_is_[image].count; }

 private:
  const CameraEquations& Of(size_t i,
                            const std::vector<bool>& is_undone) const {
    return is_undone[i] ? undone_[i] : as_is_[i];
  }

  Eigen::VectorXd ChangeOf(const std::vector<bool>& is_undone,
                           const std::vector<bool>* is_used) const {
    // Directions that images determine far less than others stay.
    constexpr double kRidge = 1e-4;
    const Eigen::Index size = as_is_.front().gradient.size();
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    for (size_t i = 0; i < count(); ++i) {
      if (is_used && !(*is_used)[i]) continue;
      hessian += Of(i, is_undone).hessian;
      gradient += Of(i, is_undone).gradient;
    }
    return LeastSquaresChange(hessian, gradient, kRidge);
  }

  std::vector<bool> Preferred(const Eigen::VectorXd& change) const {
    std::vector<bool> is_undone;
    for (size_t i = 0; i < count(); ++i)
      is_undone.push_back(undone_[i].At(change) < as_is_[i].At(change));
    return is_undone;
  }

  void Try(std::vector<bool> is_undone, bool may_exchange) {
    constexpr int kMaxRounds = 20;
    Eigen::VectorXd change;
    for (int round = 0; round < kMaxRounds; ++round) {
      change = ChangeOf(is_undone, nullptr);
      std::vector<bool> preferred = Preferred(change);
      const auto num = std::count(preferred.begin(), preferred.end(), true);
      // The fewer are the transformed ones.
      if (2 * static_cast<size_t>(num) > count()) {
        if (!may_exchange) return;
        preferred.flip();
      }
      if (preferred == is_undone) break;
      is_undone = std::move(preferred);
    }
    double squares = 0;
    for (size_t i = 0; i < count(); ++i) squares += Of(i, is_undone).At(change);
    if (squares >= least_) return;
    least_ = squares;
    change_ = std::move(change);
    is_undone_ = std::move(is_undone);
  }

  std::vector<CameraEquations> as_is_, undone_;
  double least_ = INFINITY;
  Eigen::VectorXd change_;
  std::vector<bool> is_undone_;
};

// Looks for transforms among a part of the images.
class TransformSearch {
 public:
  TransformSearch(const Dataset& dataset, const Pattern& pattern,
                  const AdjustmentOptions& options)
      : data_(Thinned(dataset)), pattern_(pattern), options_(options) {
    options_.fix_points = true;
  }

  std::optional<TransformedImages> FindScaled(const CameraModel* joint) const;
  std::optional<TransformedImages> FindTurned(const CameraModel& joint) const;

 private:
  struct Found {
    TransformedImages images;
    double mean_square = INFINITY;  // over all images
  };

  std::unique_ptr<CameraModel> LensOf(const Dataset& dataset,
                                      const CameraModel* known) const;
  Costs CostsOf(const CameraModel& lens, const Dataset& dataset) const;
  Dataset Undone(const ImageTransform& transform) const;
  std::optional<Found> FindTurned(const ImageTransform& transform,
                                  const CameraModel& joint) const;

  Dataset data_;
  const Pattern& pattern_;
  AdjustmentOptions options_;
};

std::unique_ptr<CameraModel> TransformSearch::LensOf(
    const Dataset& dataset, const CameraModel* known) const {
  try {
    return AdjustStartingLens(dataset, pattern_, options_,
                              AreaChoice::kWholeImage, known)
        .state.camera()
        .Clone();
  } catch (const Error&) {
    return nullptr;
  }
}

Costs TransformSearch::CostsOf(const CameraModel& lens,
                               const Dataset& dataset) const {
  const double cap = std::pow(ErrorCapPx(dataset.image_size), 2);
  std::map<std::string, double> less;  // than the cap, of each image's sum
  for (const FeatureResidual& r :
       EvaluateCamera(lens, dataset, pattern_, options_.num_threads).residuals)
    less[r.image] += cap - std::min(r.error_px.squaredNorm(), cap);
  Costs costs;
  for (const ImageFeatures& image : dataset.images)
    costs.push_back(cap - less[image.image] /
                              static_cast<double>(image.features.size()));
  return costs;
}

Dataset TransformSearch::Undone(const ImageTransform& transform) const {
  Dataset undone = data_;
  for (ImageFeatures& image : undone.images)
    for (Feature& feature : image.features)
      feature.pixel = transform.Undo(feature.pixel, data_.image_size);
  return undone;
}

// By linear steps of the camera. An image counts if the camera of the others
// predicts it much better once its transform is undone.
std::optional<TransformSearch::Found> TransformSearch::FindTurned(
    const ImageTransform& transform, const CameraModel& joint) const {
  constexpr int kMaxRounds = 3;
  const std::unique_ptr<CameraModel> lens = joint.Clone();
  const Dataset undone = Undone(transform);
  std::optional<Assignment> assignment;
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<bool> before =
        assignment ? assignment->is_undone() : std::vector<bool>();
    assignment.emplace(EquationsByImage(*lens, data_, pattern_, options_),
                       EquationsByImage(*lens, undone, pattern_, options_));
    assignment->Run(IsItsOwnInverse(transform));
    if (assignment->change().size() == 0) return std::nullopt;
    if (assignment->is_undone() == before) break;
    lens->SetParameters(lens->Parameters() + assignment->change());
  }
  Found found = {{transform, {}}, assignment->MeanSquare()};
  double own_as_is = 0, own_undone = 0, num_own = 0;
  for (size_t i = 0; i < assignment->count(); ++i) {
    if (!assignment->is_undone()[i]) continue;
    const auto [as_is, by_undone] = assignment->Predict(i);
    if (by_undone > kClearlyLess * as_is ||
        as_is - by_undone < kSurely * found.mean_square / 2)
      continue;
    found.images.images.push_back(data_.images[i].image);
    own_as_is += as_is;
    own_undone += by_undone;
    num_own += assignment->NumFeatures(i);
  }
  if (found.images.images.empty() || own_undone > kMuchLess * own_as_is ||
      own_undone > kMostBesideOthers * found.mean_square * num_own ||
      (own_undone > kFarLess * own_as_is &&
       assignment->LeftPart() > kLessOfAll))
    return std::nullopt;
  return found;
}

std::optional<TransformedImages> TransformSearch::FindTurned(
    const CameraModel& joint) const {
  constexpr int kMaxParameters = 250;
  if (data_.images.size() <= kLeastOthers ||
      joint.NumParameters() > kMaxParameters)
    return std::nullopt;
  std::optional<Found> best;
  for (const ImageTransform& transform : Orientations(data_.image_size)) {
    auto found = FindTurned(transform, joint);
    if (found && (!best || found->mean_square < best->mean_square))
      best = std::move(found);
  }
  if (!best) return std::nullopt;
  return best->images;
}

// Features of smaller images lie in the upper left part; a lens of images that
// surely are no smaller ones predicts all others.
std::optional<TransformedImages> TransformSearch::FindScaled(
    const CameraModel* joint) const {
  constexpr double kScales[] = {0.8, 0.75, 2.0 / 3, 0.625,   0.6,
                                0.5, 0.4,  0.375,   1.0 / 3, 0.25};
  constexpr double kLargest = 0.8;
  const auto reaches_far = [this](const ImageFeatures& image) {
    return ReachOf(image, data_.image_size) > kLargest;
  };
  const Dataset large = Select(data_, reaches_far);
  if (large.images.size() < kLeastOthers ||
      large.images.size() == data_.images.size())
    return std::nullopt;
  const auto lens = LensOf(large, joint);
  if (!lens) return std::nullopt;
  const double most = kMostBesideOthers * MeanOf(CostsOf(*lens, large));
  const Costs as_is = CostsOf(*lens, data_);
  if (*std::max_element(as_is.begin(), as_is.end()) <= most)
    return std::nullopt;
  double least = INFINITY;
  std::optional<TransformedImages> best;
  for (const double scale : kScales) {
    const ImageTransform transform = {false, 0, scale};
    const Costs scaled = CostsOf(*lens, Undone(transform));
    TransformedImages found = {transform, {}};
    double cost = 0;
    for (size_t i = 0; i < scaled.size(); ++i) {
      const bool is_scaled =
          ReachOf(data_.images[i], data_.image_size) <= scale &&
          as_is[i] > most && scaled[i] < kFarLess * as_is[i];
      if (is_scaled) found.images.push_back(data_.images[i].image);
      cost += is_scaled ? scaled[i] : as_is[i];
    }
    if (found.images.empty() || cost >= least) continue;
    least = cost;
    best = std::move(found);
  }
  return best;
}

}  // namespace

Eigen::Vector2d ImageTransform::Undo(const Eigen::Vector2d& pixel,
                                     const ImageSize& size) const {
  const Eigen::Vector2d corner(-0.5, -0.5);
  const Eigen::Vector2d centre =
      Eigen::Vector2d(size.width - 1, size.height - 1) / 2;
  Eigen::Vector2d offset = (pixel - corner) / scale + corner - centre;
  for (int turn = 0; turn < quarter_turns; ++turn)
    offset = Eigen::Vector2d(offset.y(), -offset.x());
  if (is_mirrored) offset.x() = -offset.x();
  return centre + offset;
}

std::string ImageTransform::Text() const {
  if (scale != 1) return fmt::format("scaled by {:.3g}", scale);
  if (!is_mirrored)
    return quarter_turns == 2
               ? "rotated by 180°"
               : fmt::format("rotated by 90° {}clockwise",
                             quarter_turns == 1 ? "" : "counter-");
  if (quarter_turns % 2 == 1) return "mirrored at a diagonal";
  return quarter_turns == 0 ? "mirrored left to right"
                            : "mirrored top to bottom";
}

std::vector<TransformedImages> FindTransformedImages(
    const Dataset& dataset, const Pattern& pattern, const Adjusted* joint,
    const AdjustmentOptions& options) {
  std::vector<TransformedImages> found;
  const auto scaled = TransformSearch(dataset, pattern, options)
                          .FindScaled(joint ? &joint->state.camera() : nullptr);
  if (scaled) return {*scaled};
  if (!joint) return {};
  const auto turned = TransformSearch(dataset, pattern, options)
                          .FindTurned(joint->state.camera());
  if (turned) return {*turned};
  return {};
}

Dataset WithoutTransformed(const Dataset& dataset,
                           const std::vector<TransformedImages>& transformed) {
  std::set<std::string> names;
  for (const TransformedImages& group : transformed)
    if (group.is_left_out)
      names.insert(group.images.begin(), group.images.end());
  return Select(dataset, [&](const ImageFeatures& image) {
    return names.count(image.image) == 0;
  });
}

std::vector<RejectedImage> AsRejected(
    const std::vector<TransformedImages>& transformed) {
  std::vector<RejectedImage> rejected;
  for (const TransformedImages& group : transformed)
    for (const std::string& image : group.images)
      if (group.is_left_out)
        rejected.push_back(
            {image, group.transform.Text() + " relative to the others"});
  return rejected;
}

void WarnOfTransformedImages(const std::vector<TransformedImages>& transformed,
                             size_t num_images, Verdict* verdict) {
  constexpr double kFewPart = 0.4;
  for (const TransformedImages& group : transformed) {
    const std::string which = fmt::format(
        "{} of {} images ({}{})", group.images.size(), num_images,
        group.images.front(), group.images.size() > 1 ? ", ..." : "");
    const bool is_scaled = group.transform.scale != 1;
    const bool may_be_right =
        !is_scaled && static_cast<double>(group.images.size()) >
                          kFewPart * static_cast<double>(num_images);
    const std::string reason = fmt::format(
        "{} are {} relative to the others{}{}: calibrate with images of one {}",
        which, group.transform.Text(), is_scaled ? "" : " (EXIF orientation?)",
        !group.is_left_out ? ", and the camera is wrong by it"
        : may_be_right ? ", and were left out, though the others may be wrong"
                       : ", and were left out",
        is_scaled ? "size" : "orientation");
    const bool is_open = may_be_right || !group.is_left_out;
    if (is_open && verdict->word != "fail") verdict->failure = reason;
    verdict->word = is_open || verdict->word == "fail" ? "fail" : "warn";
    verdict->reasons.insert(verdict->reasons.begin(), reason);
  }
}

}  // namespace raygrid
