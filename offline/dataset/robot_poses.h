#ifndef RAYGRID_HAND_EYE_ROBOT_POSES_H
#define RAYGRID_HAND_EYE_ROBOT_POSES_H

#include <map>
#include <string>
#include <vector>

#include "camera/pose.h"

namespace raygrid {

/// A pose that a robot reported.
struct RobotPose {
  std::string label;  ///< image name or time; empty: none
  Pose pose;
};

struct RobotPoses {
  std::vector<RobotPose> poses;
  int num_normalized = 0;  ///< rotations that were up to 1 % off a unit length
};

/// Options that interpret the numbers of a file.
struct RobotPoseOptions {
  double unit_m = 1;
  bool is_inverted = false;  ///< gripper_from_base instead of base_from_gripper
};

/// Parses robot poses, as base_from_gripper in metres. The file is one of
/// - CSV with a header: image, name or time; x, y, z; qx, qy, qz, qw, in any
///   order and with prefixes, such as pose.position.x of ROS
/// - lines of numbers, optionally after an image name or time, separated by
///   spaces or commas: tx ty tz qx qy qz qw (TUM), or a 3 x 4 or 4 x 4 matrix
///   row by row
/// - an image name or time in a line, followed by lines of 4 numbers (4 x 4)
/// path is used in errors. Throws InputError, also for rotations that are more
/// than 1 % off a unit length.
RobotPoses ParseRobotPoses(const std::string& path, const std::string& text,
                           const RobotPoseOptions& options);

/// Returns a time in seconds of a label or an image name, which may have an
/// extension: integers of 12 digits or more are milli-, micro- or nanoseconds.
/// Returns false if it is not a time.
bool ParseTime(const std::string& label, double* seconds);

/// How images are matched with robot poses.
struct MatchingOptions {
  double max_time_gap_s = 0.02;
  /// Times of images by name; empty: image names are times.
  std::map<std::string, double> image_times;
};

/// base_from_gripper of each image that has one.
struct MatchedRobotPoses {
  std::map<std::string, Pose> by_image;
  std::string rule;  ///< "name", "time" or "order"
};

/// Matches by name, with or without folder and extension, else by time, between
/// two poses by interpolation, else, without labels, by order. Throws
/// InputError if nothing matches, if labels repeat, or by order if the numbers
/// differ.
MatchedRobotPoses MatchRobotPoses(const std::string& path,
                                  const RobotPoses& robot,
                                  const std::vector<std::string>& images,
                                  const MatchingOptions& options);

}  // namespace raygrid

#endif  // RAYGRID_HAND_EYE_ROBOT_POSES_H
