/// session.json: the frames that a live capture kept, and how the camera stood.
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

/// A frame in the session's folder "frames". What the camera did not tell is
/// not there.
struct SessionFrame {
  std::string image;              ///< name of the file
  std::optional<double> seconds;  ///< from the first one, or the first resumed
  std::optional<double> lens_position;  ///< dioptres
  std::optional<double> exposure_us, analogue_gain, zoom;
  std::optional<double> sensor_temperature_c;
  std::optional<int> orientation;
  std::optional<int> focus_steps;  ///< of lenses whose position has no unit
  std::optional<std::array<int, 4>> crop;  ///< x, y, width, height
  std::optional<double> edge_spread_px, white;
  std::optional<double> variance_taken;  ///< part that the frame took away
};

/// The frames of one camera.
struct Session {
  std::string camera;  ///< its name in a rig; empty: the only one
  ImageSize image_size;
  std::vector<SessionFrame> frames;  ///< in the order in which they were kept
  std::vector<std::string> locked, not_locked;  ///< the camera's settings
};

constexpr char kSessionFile[] = "session.json";
constexpr char kSessionFrames[] = "frames";
constexpr char kSessionPattern[] = "pattern.yaml";

/// Whether a folder is a session's.
bool IsSession(const std::string& folder);
/// FOLDER/frames/IMAGE, or FOLDER/frames/CAMERA/IMAGE of a rig.
std::string SessionFramePath(const std::string& folder,
                             const std::string& camera,
                             const std::string& image);

/// The cameras of a rig, or the only one. Frames of one name were taken at one
/// instant.
std::string FormatSession(const std::vector<Session>& cameras);
/// Reads FOLDER/session.json. Throws InputError.
std::vector<Session> ReadSession(const std::string& folder);

/// How the camera stood in all frames; nothing of what differs between them or
/// was not told.
Capture CaptureOf(const Session& session);

/// When the frames were taken, as far as that was told. Frames that were added
/// later, whose clock began anew, are far from those before.
ImageTimes CollectTimes(const Session& session);

/// How a camera stands otherwise than it was calibrated, each in half a
/// sentence: lens position, crop, zoom, orientation, and a temperature that is
/// more than 20 K away. What one of them does not tell is not compared.
std::vector<std::string> ListDifferences(const Capture& calibrated,
                                         const Capture& now);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_SESSION_FILE_H
