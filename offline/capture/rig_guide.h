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
  const LiveCamera* live = nullptr;  ///< for RigGuide's constructor alone
  std::shared_ptr<const CaptureGuide> guide;
  std::vector<Pose> avoided;  ///< views, camera_from_board, that nobody shows
};

/// The view to take next, before one of the cameras.
struct RigView {
  size_t camera = 0;
  GuidedView view;
};

/// Guidance for several cameras at once: each has its own guide, and between
/// them are links, their relative poses. Those links are looked at that
/// connect all cameras and are known best. A rig of one camera is guided by its
/// own guide alone.
///
/// It does not change; each instant that is kept makes another one.
class RigGuide {
 public:
  RigGuide(const std::vector<GuidedCamera>& cameras, const Pattern& pattern,
           const GuideOptions& options);

  size_t num_cameras() const { return cameras_.size(); }
  /// NULL before the camera's first frame.
  const CaptureGuide* guide(size_t camera) const {
    return cameras_[camera].guide.get();
  }

  struct Link {
    size_t first = 0, second = 0;  ///< cameras
    CameraLink link;
    std::optional<GuidedView> next;  ///< before the first; none: it is done
  };
  const std::vector<Link>& links() const { return links_; }
  /// Two cameras that no instant connects, to be shown a board at once. Nothing
  /// while one of all is not known yet.
  const std::optional<std::pair<size_t, size_t>>& to_connect() const {
    return to_connect_;
  }

  /// The view that takes away most, of the cameras' variances and the links'
  /// together. Views of cameras that are not known yet come first. Nothing
  /// while cameras are to be connected, and where no view adds enough.
  const std::optional<RigView>& next() const { return next_; }
  /// All cameras are known as well as asked for, and how they stand to each
  /// other.
  bool is_done() const { return is_done_; }
  /// How many instants are still expected: the most of any camera.
  std::optional<int> num_expected() const;

  /// Whether an instant is to be kept for what it tells of links: images by
  /// camera, NULL for those of no use.
  bool TellsLinks(const std::vector<const ImageFeatures*>& images) const;

 private:
  bool IsKnown(size_t camera) const;
  void FindLinks();
  void ChooseLinkViews();
  void ChooseNext();
  std::optional<Pose> FromCamera(size_t to, size_t from) const;
  double TotalGainOf(size_t camera, const Board& board,
                     const Pose& camera_from_board) const;
  bool TellsLink(const Link* link, size_t first, size_t second,
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
