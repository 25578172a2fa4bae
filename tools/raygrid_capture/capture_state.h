/// The state of a live capture, as shown to users and programs.
#ifndef RAYGRID_CAPTURE_CAPTURE_STATE_H
#define RAYGRID_CAPTURE_CAPTURE_STATE_H

#include <Eigen/Core>
#include <string>
#include <vector>

namespace raygrid {

/// Predicted uncertainty at a pixel.
struct PositionState {
  Eigen::Vector2d pixel;
  double stddev_px = 0;
};

/// A view to fill with the board. Lines are in image pixels, possibly outside
/// the image.
struct ViewState {
  std::vector<Eigen::Vector2d> outline;  ///< closed outline of the board
  std::vector<Eigen::Vector2d> top;      ///< its edge adjacent to the first row
};

/// Summary of a camera of a rig.
struct CameraState {
  std::string name;
  std::string word = "absent";  ///< status of its newest image
  double stddev_px = 0;         ///< 95th percentile; 0: unknown
};

/// Uncertainty of the relative pose of two cameras: RMS of predicting a board's
/// points in the second camera from its pose in the first.
struct LinkState {
  std::string first, second;
  double stddev_px = 0;
};

/// The state after a frame; for a rig, of the camera whose view is to be
/// captured next.
struct CaptureState {
  int width = 0, height = 0;         ///< image size, pixels
  std::string camera;                ///< name in a rig; else empty
  std::vector<CameraState> cameras;  ///< cameras of a rig; else empty
  std::vector<LinkState> links;

  /// Assessment of the newest image: kept, absent, few, moving, blurred, dark,
  /// bright, known, busy, paused, locking, refocused, cropped.
  std::string word = "absent";
  std::string hint;  ///< sentence: what to do next
  bool is_done = false, is_paused = false;

  std::vector<Eigen::Vector2d> features;  ///< in the newest image, pixels
  std::vector<ViewState> next;            ///< view to capture, if any
  /// From the board's centre to its requested position; both or none.
  std::vector<Eigen::Vector2d> arrow;

  std::vector<PositionState> places;  ///< empty before a calibration
  /// 95th percentile over the image; 0 before a calibration.
  double stddev_px = 0;
  /// Whether there are too few frames, so that stddev_px is a lower bound.
  bool stddev_is_floor = false;
  double target_px = 0;  ///< requested uncertainty; 0: none

  std::vector<std::string> kept;  ///< names of the frames, oldest first
  int num_expected = -1;          ///< remaining frames; -1: unknown

  double sharpness_px = 0;  ///< width of the features' edges; 0: unknown
  double brightness = 0;    ///< brightness of the board's white, 0 to 1; 0:
                            ///< unknown
  double frames_per_second = 0;
  std::vector<std::string> warnings;  ///< such as controls that are not locked
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_STATE_H
