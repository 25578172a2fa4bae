#include "capture/capture_guide.h"

#include <algorithm>
#include <cmath>

#include "camera/thin_prism_fisheye.h"
#include "capture/view_hint.h"
#include "evaluation/min_images.h"
#include "initialization/localization.h"

namespace raygrid {
namespace {

// Minimum angle between tilts that count as distinct before a first
// calibration.
constexpr double kMinTiltDifferenceRad = 0.25;

std::shared_ptr<const CameraModel> AssumedCamera(const ImageSize& size) {
  constexpr double kHalfWidthRad = 0.57;
  const double f_px = size.width / 2.0 / kHalfWidthRad;
  return std::make_shared<ThinPrismFisheye>(
      size, WholeImage(size),
      ThinPrismFisheye::ParameterArray{f_px, f_px, (size.width - 1) / 2.0,
                                       (size.height - 1) / 2.0});
}

double AngleBetween(const LocatedBoard& a, const LocatedBoard& b) {
  // The normal relative to the line of sight, because translation must not
  // count as tilt.
  const auto normal = [](const LocatedBoard& located) -> Eigen::Vector3d {
    const Pose& pose = located.camera_from_board;
    return Eigen::Quaterniond::FromTwoVectors(
               pose * ComputeBoardCenter(*located.board),
               Eigen::Vector3d::UnitZ()) *
           (pose.rotation * Eigen::Vector3d::UnitZ());
  };
  const Eigen::Vector3d first = normal(a), second = normal(b);
  return std::atan2(first.cross(second).norm(), first.dot(second));
}

}  // namespace

std::vector<PointPixelMatch> MakeMatches(const Board& board,
                                         const ImageFeatures& image) {
  std::vector<PointPixelMatch> matches;
  for (const Feature& feature : image.features)
    if (feature.board == board.id)
      matches.push_back(
          {board.points[board.PointIndex(feature.column, feature.row)],
           feature.pixel});
  return matches;
}

FeaturePositions CollectFeaturePositions(const ImageFeatures& image) {
  FeaturePositions places;
  for (const Feature& feature : image.features)
    places[{feature.board, feature.row, feature.column}] = feature.pixel;
  return places;
}

std::optional<double> DistancePx(const FeaturePositions& a,
                                 const FeaturePositions& b) {
  double sum = 0;
  int count = 0;
  for (const auto& [feature, pixel] : a) {
    const auto other = b.find(feature);
    if (other == b.end()) continue;
    sum += (pixel - other->second).squaredNorm();
    ++count;
  }
  return count > 0 ? std::optional(std::sqrt(sum / count)) : std::nullopt;
}

CaptureGuide::CaptureGuide(const LiveCamera& live, const Pattern& pattern,
                           const GuideOptions& options)
    : pattern_(std::make_shared<Pattern>(pattern)),
      options_(options),
      num_images_(static_cast<int>(live.images().images.size())),
      assumed_(AssumedCamera(live.images().image_size)) {
  for (const ImageFeatures& image : live.images().images)
    kept_views_.push_back(CollectFeaturePositions(image));
  if (live.adjusted()) information_ = CameraInformation::Of(*live.adjusted());
  if (information_)
    ChooseNext();
  else
    ChooseFirst(live);
}

const CameraModel& CaptureGuide::camera() const {
  return information_ ? information_->camera() : *assumed_;
}

std::vector<LocatedBoard> CaptureGuide::Locate(
    const ImageFeatures& image) const {
  std::vector<LocatedBoard> located;
  for (const Board& board : pattern_->boards)
    if (const auto pose = Localize(camera(), MakeMatches(board, image)))
      located.push_back({&board, *pose});
  return located;
}

void CaptureGuide::ChooseFirst(const LiveCamera& live) {
  for (const ImageFeatures& image : live.images().images)
    for (const LocatedBoard& located : Locate(image))
      first_views_.push_back(located);
  const Board& board = pattern_->boards.front();
  const ImageSize size = live.images().image_size;
  // Selects the first initial view whose tilt differs from those of kept
  // images.
  for (int index = 0; index < 2 * kNumFirstViews; ++index) {
    const auto pose = ComputePose(FirstView(index, size), board, *assumed_);
    if (!pose) continue;
    next_ = GuidedView{&board, *pose, 1};
    const auto is_other = [&](const LocatedBoard& before) {
      return AngleBetween({&board, *pose}, before) > kMinTiltDifferenceRad;
    };
    if (std::all_of(first_views_.begin(), first_views_.end(), is_other)) return;
  }
}

// Returns the best view that differs from kept images.
std::optional<NextView> CaptureGuide::FindBestNewView(
    const Board& board) const {
  std::vector<Pose> avoided = options_.avoided;
  constexpr int kTries = 4;
  for (int k = 0; k < kTries; ++k) {
    const auto view = FindBestNextView(*information_, board, avoided);
    if (!view ||
        !IsDuplicateView(SimulateImageFeatures(board, view->camera_from_board)))
      return view;
    avoided.push_back(view->camera_from_board);
  }
  return std::nullopt;
}

// Simulates the features of a board that the camera would observe at a pose.
ImageFeatures CaptureGuide::SimulateImageFeatures(
    const Board& board, const Pose& camera_from_board) const {
  ImageFeatures image;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if (const auto pixel = camera().Project(
              camera_from_board * board.points[board.PointIndex(column, row)]))
        image.features.push_back({board.id, column, row, *pixel});
  return image;
}

void CaptureGuide::ChooseNext() {
  for (const Board& board : pattern_->boards)
    if (const auto view = FindBestNewView(board))
      if (!next_ || view->gain > next_->gain)
        next_ = GuidedView{&board, view->camera_from_board, view->gain};
  const bool is_known = options_.target_px > 0 &&
                        information_->Percentile95Px() <= options_.target_px;
  is_done_ =
      !is_floor() && (is_known || !next_ || next_->gain < options_.min_gain);
  if (is_done_) next_.reset();
}

bool CaptureGuide::is_floor() const { return num_images_ < kMinReliableImages; }

bool CaptureGuide::IsDuplicateView(const ImageFeatures& image) const {
  constexpr double kMaxRelativeShift = 0.01;
  const ImageSize& size = camera().image_size();
  const FeaturePositions places = CollectFeaturePositions(image);
  return std::any_of(
      kept_views_.begin(), kept_views_.end(), [&](const auto& kept) {
        const auto distance_px = DistancePx(places, kept);
        return distance_px &&
               *distance_px <
                   kMaxRelativeShift * std::max(size.width, size.height);
      });
}

double CaptureGuide::ComputeGain(const ImageFeatures& image) const {
  if (IsDuplicateView(image)) return 0;
  const std::vector<LocatedBoard> located = Locate(image);
  if (!information_) {
    const auto is_other = [&](const LocatedBoard& board) {
      return std::all_of(first_views_.begin(), first_views_.end(),
                         [&](const LocatedBoard& before) {
                           return AngleBetween(board, before) >
                                  kMinTiltDifferenceRad;
                         });
    };
    return std::any_of(located.begin(), located.end(), is_other) ? 1 : 0;
  }
  double left = 1;  // remaining fraction of the variance
  for (const LocatedBoard& board : located) {
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector2d> pixels;
    for (const PointPixelMatch& match : MakeMatches(*board.board, image)) {
      points.push_back(match.point);
      pixels.push_back(match.pixel);
    }
    left *=
        1 - information_->ComputeGain(points, pixels, board.camera_from_board);
  }
  return 1 - left;
}

bool CaptureGuide::ShouldKeep(double gain, bool is_next_view) const {
  if (!information_) return gain > 0.5;
  const double wanted =
      next_ && !is_next_view ? options_.min_gain_ratio * next_->gain : 0;
  // Before the smoothness prior is determined, any image with a positive gain
  // is kept.
  const double least = is_floor() ? 0 : options_.min_gain;
  return gain > 0 && gain >= std::max(least, wanted);
}

bool CaptureGuide::IsNextView(const ImageFeatures& image) const {
  if (!next_) return false;
  const std::vector<LocatedBoard> located = Locate(image);
  return std::any_of(located.begin(), located.end(), [&](const auto& seen) {
    return seen.board->id == next_->board->id &&
           HasReachedView(camera(), *seen.board, seen.camera_from_board,
                          next_->camera_from_board);
  });
}

std::optional<int> CaptureGuide::num_expected() const {
  if (is_done_) return 0;
  // Initially, standard deviations decrease faster than predicted.
  constexpr int kMinImages = 6;
  const int num_missing = std::max(1, kMinReliableImages - num_images_);
  if (!information_ || !next_ || num_images_ < kMinImages) return std::nullopt;
  // After n images, the mean variance decreases as n^(-n gain): fast at first,
  // finally as 1 / n.
  const double n = num_images_, power = n * next_->gain;
  if (!(power > 0)) return std::nullopt;
  // Capture ends when gains fall below min_gain or the target uncertainty is
  // reached.
  double most = std::min(1.0, power) / options_.min_gain;
  if (options_.target_px > 0) {
    const double ratio = information_->Percentile95Px() / options_.target_px;
    most = std::min(most, n * std::pow(std::max(1.0, ratio), 2 / power));
  }
  constexpr double kMaxImages = 999;
  return std::max(
      num_missing,
      static_cast<int>(std::ceil(std::clamp(most - n, 1.0, kMaxImages))));
}

}  // namespace raygrid
