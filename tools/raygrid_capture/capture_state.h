/// The state of a live capture, as people and programs see it.
#ifndef RAYGRID_CAPTURE_CAPTURE_STATE_H
#define RAYGRID_CAPTURE_CAPTURE_STATE_H

#include <Eigen/Core>
#include <string>
#include <vector>

namespace raygrid {

/// A place of the image, and how well it is known.
struct PlaceShown {
  Eigen::Vector2d pixel;
  double deviation_px = 0;
};

/// A view to fill with the board. Lines lie in pixels of the image, and may
/// leave it.
struct ViewShown {
  std::vector<Eigen::Vector2d> outline;  ///< of the board, closed
  std::vector<Eigen::Vector2d> top;      ///< its side behind the first row
};

/// A camera of a rig in short.
struct CameraShown {
  std::string name;
  std::string word = "absent";  ///< on its newest frame
  double deviation_px = 0;      ///< 95 % of its places have less; 0: not known
};

/// How well it is known how two cameras stand to each other: a board seen by
/// the first is predicted so well in the second, RMS.
struct LinkShown {
  std::string first, second;
  double deviation_px = 0;
};

/// The state after a frame; of a rig, as the camera sees it whose view is to be
/// taken next.
struct CaptureState {
  int width = 0, height = 0;         ///< of the image, pixels
  std::string camera;                ///< of a rig; else empty
  std::vector<CameraShown> cameras;  ///< of a rig; else empty
  std::vector<LinkShown> links;

  /// One word on the newest frame: kept, absent, few, moving, blurred, dark,
  /// bright, known, busy, paused, locking, refocused, cropped.
  std::string word = "absent";
  std::string hint;  ///< a sentence: what to do next
  bool is_done = false, is_paused = false;

  std::vector<Eigen::Vector2d> features;  ///< of the newest frame, pixels
  std::vector<ViewShown> next;            ///< the view to take, if there is one
  /// From the board's middle to where it is wanted; both or none.
  std::vector<Eigen::Vector2d> arrow;

  std::vector<PlaceShown> places;  ///< empty while nothing is known
  /// 95 % of the places have less; 0 while nothing is known.
  double deviation_px = 0;
  /// So few frames do not tell more than the least that it may be.
  bool deviation_is_floor = false;
  double target_px = 0;  ///< 0: none is asked for

  std::vector<std::string> kept;  ///< names of the frames, oldest first
  int num_expected = -1;          ///< frames still to keep; -1: not known

  double sharpness_px = 0;  ///< width of the features' edges; 0: not known
  double brightness = 0;    ///< of the board's white, 0 to 1; 0: not known
  double frames_per_second = 0;
  std::vector<std::string> warnings;  ///< such as a control that is not locked
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_CAPTURE_STATE_H
