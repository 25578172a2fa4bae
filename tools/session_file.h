/// session.json: kept frames of a live capture, and their capture settings.
#ifndef RAYGRID_TOOLS_SESSION_FILE_H
#define RAYGRID_TOOLS_SESSION_FILE_H

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/capture.h"
#include "dataset/image_times.h"

namespace raygrid {

/// A frame in the session's folder "frames". Values that the camera did not
/// provide are nullopt.
struct SessionFrame {
  std::string image;              ///< file name
  std::optional<double> seconds;  ///< since the first frame, or the first after
                                  ///< resuming
  std::optional<double> lens_position;  ///< dioptres
  std::optional<double> exposure_us, analogue_gain, zoom;
  std::optional<double> sensor_temperature_c;
  std::optional<int> orientation;
  std::optional<int> focus_steps;          ///< focus without a unit
  std::optional<std::array<int, 4>> crop;  ///< x, y, width, height
  std::optional<double> edge_spread_px, white;
  std::optional<double> variance_reduction;  ///< relative reduction
};

/// The frames of one camera.
struct Session {
  std::string camera;  ///< name in a rig; empty: single camera
  ImageSize image_size;
  std::vector<SessionFrame> frames;             ///< in the order of capture
  std::vector<std::string> locked, not_locked;  ///< camera settings
};

constexpr char kSessionFile[] = "session.json";
constexpr char kSessionFrames[] = "frames";
constexpr char kSessionPattern[] = "pattern.yaml";

/// Returns whether a folder contains a session.
bool IsSession(const std::string& folder);
/// Returns FOLDER/frames/IMAGE, or FOLDER/frames/CAMERA/IMAGE for a rig.
std::string SessionFramePath(const std::string& folder,
                             const std::string& camera,
                             const std::string& image);

/// Formats a session of a rig's cameras, or of a single one. Frames of equal
/// name are synchronized.
std::string FormatSession(const std::vector<Session>& cameras);
/// Reads FOLDER/session.json. Throws InputError.
std::vector<Session> ReadSession(const std::string& folder);

/// Returns the capture settings common to all frames, without those that differ
/// or were not provided.
Capture GetCaptureSettings(const Session& session);

/// Returns the capture times of frames, if provided. Frames of a resumed
/// capture, whose clock starts again, are placed far from earlier frames.
ImageTimes CollectTimes(const Session& session);

/// Describes how capture settings differ from the calibrated ones, each in a
/// phrase: lens position, crop, zoom, orientation, and a temperature difference
/// above 20 K. Values missing in either one are not compared.
std::vector<std::string> ListDifferences(const Capture& calibrated,
                                         const Capture& now);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_SESSION_FILE_H
