#ifndef RAYGRID_CAPTURE_CAPTURE_GUIDE_H
#define RAYGRID_CAPTURE_CAPTURE_GUIDE_H

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "capture/camera_knowledge.h"
#include "capture/live_camera.h"
#include "capture/next_view.h"
#include "dataset/dataset.h"

namespace raygrid {

struct GuideOptions {
  /// 95 % of the places are to be known so well; 0: until nothing adds.
  double target_px = 0;
  double least_gain = 0.02;  ///< a view that takes less away is none to take
  /// An image is kept if its gain is at least this part of the next view's:
  /// near enough to that view, and no second one of a view just taken.
  double part_of_next = 0.5;
  /// Views, camera_from_board, that nobody could show.
  std::vector<Pose> avoided = {};
  /// Nobody could show a board to two cameras of a rig at once. Each camera's
  /// own views go on.
  bool leaves_connecting = false;
};

/// The features of one board in an image, with their points in its frame.
std::vector<PointOnPixel> MatchesOf(const Board& board,
                                    const ImageFeatures& image);

/// Features' places by board, row and column.
using FeaturePlaces = std::map<std::tuple<int, int, int>, Eigen::Vector2d>;
FeaturePlaces PlacesOf(const ImageFeatures& image);
/// How far the features that both have lie apart, RMS; nothing if both have
/// none.
std::optional<double> DistancePx(const FeaturePlaces& a,
                                 const FeaturePlaces& b);

/// A board of the pattern, as an image shows it.
struct LocatedBoard {
  const Board* board = nullptr;  ///< of the guide's pattern
  Pose camera_from_board;
};

/// The view to take next.
struct GuidedView {
  const Board* board = nullptr;  ///< of the guide's pattern
  Pose camera_from_board;
  double gain = 0;  ///< part of the mean variance that it takes away
};

/// Guidance by the images so far: how well the camera is known, and what to
/// show it next. It does not change; each image that is kept makes another one.
///
/// Before a camera is known, an assumed one stands for it: equidistant, 65
/// degrees wide.
class CaptureGuide {
 public:
  CaptureGuide(const LiveCamera& live, const Pattern& pattern,
               const GuideOptions& options);

  /// The camera so far, or the assumed one.
  const CameraModel& camera() const;
  /// NULL while nothing is known.
  const CameraKnowledge* knowledge() const {
    return knowledge_ ? &*knowledge_ : nullptr;
  }
  int num_images() const { return num_images_; }

  /// The boards that the camera sees.
  std::vector<LocatedBoard> Locate(const ImageFeatures& image) const;
  /// The part of the mean variance that an image would take away. While nothing
  /// is known: 1 for a board tilted otherwise than all before, else 0. Always 0
  /// for a view that was kept, whose features moved by less than 1 % of the
  /// image's longer side since: it tells of noise alone.
  double GainOf(const ImageFeatures& image) const;
  /// An image with this gain is to be kept. One that shows the next view is, as
  /// soon as it adds anything: nobody can do better than follow.
  bool IsWorthKeeping(double gain, bool is_next_view) const;
  /// Whether an image shows the next view, as nearly as a hint would say.
  bool IsNextView(const ImageFeatures& image) const;

  /// Nothing where no view adds enough.
  const std::optional<GuidedView>& next() const { return next_; }
  /// Never before there are enough images for a calibration.
  bool is_done() const { return is_done_; }
  /// Whether deviations are no more than the least that they may be: so few
  /// images do not determine how stiff the camera's grid should be.
  bool is_floor() const;
  /// How many images are still expected, if they add what the next one does, in
  /// proportion; nothing while that cannot be told.
  std::optional<int> num_expected() const;

 private:
  bool IsSameView(const ImageFeatures& image) const;
  std::optional<NextView> BestNewView(const Board& board) const;
  ImageFeatures ImageOf(const Board& board,
                        const Pose& camera_from_board) const;
  void ChooseFirst(const LiveCamera& live);
  void ChooseNext();

  std::shared_ptr<const Pattern> pattern_;
  GuideOptions options_;
  int num_images_ = 0;
  std::vector<FeaturePlaces> kept_;
  std::shared_ptr<const CameraModel> assumed_;
  std::optional<CameraKnowledge> knowledge_;
  std::vector<LocatedBoard> first_views_;  // while nothing is known
  std::optional<GuidedView> next_;
  bool is_done_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_GUIDE_H
