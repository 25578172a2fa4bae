#ifndef RAYGRID_CAPTURE_RIG_GUIDE_H
#define RAYGRID_CAPTURE_RIG_GUIDE_H

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "capture/camera_link.h"
#include "capture/capture_guide.h"

namespace raygrid {

/// A camera of a rig, or the only one. Pointers are NULL before its first
/// frame.
struct GuidedCamera {
  const LiveCamera* live = nullptr;  ///< only for RigGuide's constructor
  std::shared_ptr<const CaptureGuide> guide;
  std::vector<Pose> avoided;  ///< views (camera_from_board) that the operator
                              ///< could not take
};

/// The recommended next view, and its camera.
struct RigView {
  size_t camera = 0;
  GuidedView view;
};

/// Capture guidance for a rig: one guide per camera, and links, which are
/// relative poses between cameras. Considers the spanning tree of the most
/// certain links. A single camera is guided by its own guide only.
///
/// Immutable; a new one is made for each kept frame.
class RigGuide {
 public:
  RigGuide(const std::vector<GuidedCamera>& cameras, const Pattern& pattern,
           const GuideOptions& options);

  size_t num_cameras() const { return cameras_.size(); }
  /// Returns NULL before the camera's first frame.
  const CaptureGuide* guide(size_t camera) const {
    return cameras_[camera].guide.get();
  }

  struct Link {
    size_t first = 0, second = 0;  ///< camera indices
    CameraLink link;
    std::optional<GuidedView> next;  ///< first camera's view; nullopt: done
  };
  const std::vector<Link>& links() const { return links_; }
  /// Returns two cameras that need to observe a board at once, since they have
  /// no common frame; nullopt while a camera is not calibrated.
  const std::optional<std::pair<size_t, size_t>>& to_connect() const {
    return to_connect_;
  }

  /// Returns the view with the largest reduction of the variances of cameras
  /// and links together. Views of uncalibrated cameras come first. Returns
  /// nullopt while two cameras need to be connected, and if no view has enough
  /// gain.
  const std::optional<RigView>& next() const { return next_; }
  /// Returns whether all cameras and their relative poses have the required
  /// uncertainty.
  bool is_done() const { return is_done_; }
  /// Returns the expected number of further frames: maximum over the cameras.
  std::optional<int> num_expected() const;

  /// Returns whether to keep a frame for its information on links. images by
  /// camera; NULL for unusable images.
  bool IsInformativeForLinks(
      const std::vector<const ImageFeatures*>& images) const;

 private:
  bool IsCalibrated(size_t camera) const;
  void UpdateLinks();
  void ChooseLinkViews();
  void ChooseNext();
  std::optional<Pose> ComputeRelativePose(size_t to, size_t from) const;
  double ComputeTotalGain(size_t camera, const Board& board,
                          const Pose& camera_from_board) const;
  bool IsInformativeForLink(
      const Link* link, size_t first, size_t second,
      const std::vector<const ImageFeatures*>& images) const;

  std::vector<GuidedCamera> cameras_;
  std::shared_ptr<const Pattern> pattern_;
  GuideOptions options_;
  std::vector<Link> links_;
  std::optional<std::pair<size_t, size_t>> to_connect_;
  std::optional<RigView> next_;
  bool is_done_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_RIG_GUIDE_H
