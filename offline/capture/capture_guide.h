#ifndef RAYGRID_CAPTURE_CAPTURE_GUIDE_H
#define RAYGRID_CAPTURE_CAPTURE_GUIDE_H

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "capture/camera_information.h"
#include "capture/live_camera.h"
#include "capture/next_view.h"
#include "dataset/dataset.h"

namespace raygrid {

struct GuideOptions {
  /// Required 95 % quantile of the predicted uncertainty. 0: capture continues
  /// until no view has enough gain.
  double target_px = 0;
  double min_gain = 0.02;  ///< minimum gain of a view
  /// An image is kept if its gain is at least this fraction of the gain of the
  /// recommended view. Images near that view are thus kept, and repetitions of
  /// earlier views are not.
  double min_gain_ratio = 0.5;
  /// Views (camera_from_board) that the operator could not take.
  std::vector<Pose> avoided = {};
  /// If no board can be observed by two cameras at once: skips connecting views
  /// and continues with views of single cameras.
  bool skip_connecting_views = false;
};

/// Pairs the features of one board in an image with their points in the board
/// frame.
std::vector<PointPixelMatch> MakeMatches(const Board& board,
                                         const ImageFeatures& image);

/// Feature positions by board, row and column.
using FeaturePositions = std::map<std::tuple<int, int, int>, Eigen::Vector2d>;
FeaturePositions CollectFeaturePositions(const ImageFeatures& image);
/// Returns the RMS distance of the common features; nullopt without common
/// features.
std::optional<double> DistancePx(const FeaturePositions& a,
                                 const FeaturePositions& b);

/// A board of the pattern, and its pose in an image.
struct LocatedBoard {
  const Board* board = nullptr;  ///< in the guide's pattern
  Pose camera_from_board;
};

/// The recommended next view.
struct GuidedView {
  const Board* board = nullptr;  ///< in the guide's pattern
  Pose camera_from_board;
  double gain = 0;  ///< relative reduction of the mean variance
};

/// Capture guidance from the images so far: the camera's uncertainty, and the
/// recommended next view. Immutable; a new one is made for each kept image.
///
/// Before a first calibration, an equidistant camera of 65 degrees is assumed.
class CaptureGuide {
 public:
  CaptureGuide(const LiveCamera& live, const Pattern& pattern,
               const GuideOptions& options);

  /// Returns the current estimate of the camera, or the assumed camera.
  const CameraModel& camera() const;
  /// Returns NULL before a first calibration.
  const CameraInformation* information() const {
    return information_ ? &*information_ : nullptr;
  }
  int num_images() const { return num_images_; }

  /// Estimates the poses of the boards in an image.
  std::vector<LocatedBoard> Locate(const ImageFeatures& image) const;
  /// Computes the fraction by which an image would reduce the mean variance.
  /// Before a first calibration: 1 for a board with a new tilt, otherwise 0.
  /// Always 0 for a near-duplicate of a kept view (features moved by less than
  /// 1 % of the longer image side), which would only reduce the noise.
  double ComputeGain(const ImageFeatures& image) const;
  /// Returns whether to keep an image with this gain. An image of the
  /// recommended view is kept with any gain, since the operator cannot improve
  /// it.
  bool ShouldKeep(double gain, bool is_next_view) const;
  /// Returns whether an image shows the recommended view within tolerance.
  bool IsNextView(const ImageFeatures& image) const;

  /// Returns nullopt if no view has enough gain.
  const std::optional<GuidedView>& next() const { return next_; }
  /// Returns false before there are enough images for a calibration.
  bool is_done() const { return is_done_; }
  /// Returns whether the uncertainty is at its lower bound, because there are
  /// too few images to estimate the smoothness of the grid.
  bool is_floor() const;
  /// Returns the expected number of further images, assuming proportional
  /// gains; nullopt if it cannot be estimated.
  std::optional<int> num_expected() const;

 private:
  bool IsDuplicateView(const ImageFeatures& image) const;
  std::optional<NextView> FindBestNewView(const Board& board) const;
  ImageFeatures SimulateImageFeatures(const Board& board,
                                      const Pose& camera_from_board) const;
  void ChooseFirst(const LiveCamera& live);
  void ChooseNext();

  std::shared_ptr<const Pattern> pattern_;
  GuideOptions options_;
  int num_images_ = 0;
  std::vector<FeaturePositions> kept_views_;
  std::shared_ptr<const CameraModel> assumed_;
  std::optional<CameraInformation> information_;
  std::vector<LocatedBoard> first_views_;  // candidates before calibration
  std::optional<GuidedView> next_;
  bool is_done_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_GUIDE_H
