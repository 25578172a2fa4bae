#include "hand_eye/hand_eye_diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/error.h"

namespace raygrid {
namespace {

constexpr double kToDegrees = 180 / M_PI;

// The differences in the better half of the poses, as a length.
double ComputeMisfit(const RobustStart& start, double lever_m) {
  return start.translation_m + lever_m * start.rotation_rad;
}

constexpr double kMaxMisfitRatio = 0.3;  // ratio of misfits

// The misfit of changed robot poses.
template <typename Change>
double ComputeMisfitWithChange(std::vector<HandEyeObservation> observations,
                               Mounting mounting, const Change& change) {
  change(&observations);
  const auto start = FindRobustStart(observations, mounting);
  return start ? ComputeMisfit(*start, MedianDistance(observations)) : INFINITY;
}

void InvertRobot(std::vector<HandEyeObservation>* observations) {
  for (HandEyeObservation& observation : *observations)
    observation.base_from_gripper = observation.base_from_gripper.Inverse();
}

// Changes w x y z that was read as x y z w.
void ReorderQuaternions(std::vector<HandEyeObservation>* observations) {
  for (HandEyeObservation& observation : *observations) {
    Eigen::Quaterniond& q = observation.base_from_gripper.rotation;
    q = Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w());
  }
}

// Moves the robot poses by one row.
void ShiftRobot(int direction, std::vector<HandEyeObservation>* observations) {
  std::vector<HandEyeObservation>& rows = *observations;
  if (direction > 0)
    for (size_t i = rows.size(); --i > 0;)
      rows[i].base_from_gripper = rows[i - 1].base_from_gripper;
  else
    for (size_t i = 0; i + 1 < rows.size(); ++i)
      rows[i].base_from_gripper = rows[i + 1].base_from_gripper;
  rows.erase(direction > 0 ? rows.begin() : rows.end() - 1);
}

double PathLength(const std::vector<Eigen::Vector3d>& points) {
  double length = 0;
  for (size_t i = 1; i < points.size(); ++i)
    length += (points[i] - points[i - 1]).norm();
  return length;
}

}  // namespace

std::string FormatAxis(const Eigen::Vector3d& axis) {
  // The sign of an axis is arbitrary: its largest component is positive.
  int largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  const double sign = axis[largest] < 0 ? -1 : 1;
  const auto shown = [&](int k) {  // without negative zeros
    return std::round(100 * sign * axis[k]) / 100 + 0.0;
  };
  return fmt::format("[{:.2f}, {:.2f}, {:.2f}]", shown(0), shown(1), shown(2));
}

void RequireRotations(const RotationSpread& rotations, Mounting mounting) {
  const HandEyeNames names = GetFrameNames(mounting);
  if (rotations.Rms(0) < kMinRotationRad)
    throw Error(
        ExitCode::kInitializationFailed,
        fmt::format("the gripper does not rotate (RMS {:.2g}°), so the "
                    "translation of {} is not determined; add poses with "
                    "rotations of 20° or more about two axes",
                    rotations.Rms(0) * kToDegrees, names.camera_from_mount));
  if (rotations.Rms(1) < kMinRotationRad)
    throw Error(
        ExitCode::kInitializationFailed,
        fmt::format("the gripper rotates about one axis only, {} in the frame "
                    "of the {}, so the camera's position along it is not "
                    "determined; add poses tilted by 20° or more about "
                    "another axis",
                    FormatAxis(rotations.axes.col(0)), names.mount));
}

void RequireSameUnit(const std::vector<HandEyeObservation>& observations,
                     Mounting mounting) {
  constexpr double kOtherUnit = 30;
  std::vector<Eigen::Vector3d> camera, robot;
  for (const HandEyeObservation& observation : observations) {
    camera.push_back(mounting == Mounting::kEyeInHand
                         ? observation.camera_from_target.Inverse().translation
                         : observation.camera_from_target.translation);
    robot.push_back(observation.base_from_gripper.translation);
  }
  const double camera_m = PathLength(camera), robot_m = PathLength(robot);
  // A robot that hardly moves its flange, or a target near its axis, has such
  // paths, too, but would not fit in another unit.
  const auto fits_with_unit = [&](double factor) {
    const auto misfit = [&](double scale) {
      return ComputeMisfitWithChange(
          observations, mounting, [scale](auto* rows) {
            for (HandEyeObservation& row : *rows)
              row.base_from_gripper.translation *= scale;
          });
    };
    return !(misfit(factor) > kMaxMisfitRatio * misfit(1));
  };
  if (robot_m > kOtherUnit * camera_m && fits_with_unit(1e-3))
    throw InputError(fmt::format(
        "the robot's path is {:.0f} times as long as the camera's ({:.4g} "
        "against {:.4g} m); if it is in millimetres, use --robot-unit mm",
        robot_m / camera_m, robot_m, camera_m));
  if (camera_m > kOtherUnit * robot_m && robot_m > 0 && fits_with_unit(1e3))
    throw InputError(fmt::format(
        "the camera's path is {:.0f} times as long as the robot's ({:.4g} "
        "against {:.4g} m); if the robot's is in metres, use --robot-unit m, "
        "else check the length of the target's squares",
        camera_m / robot_m, camera_m, robot_m));
}

void RequireFit(const std::vector<HandEyeObservation>& observations,
                Mounting mounting, const RobustStart& start) {
  constexpr double kMaxRotationRad = 3 * M_PI / 180, kMaxTranslation = 0.05;
  const double lever_m = MedianDistance(observations);
  const double misfit = ComputeMisfit(start, lever_m);
  const double inverted =
      ComputeMisfitWithChange(observations, mounting, InvertRobot);
  const bool fits = start.rotation_rad < kMaxRotationRad &&
                    start.translation_m < kMaxTranslation * lever_m;
  if (fits && inverted > kMaxMisfitRatio * misfit) return;

  std::string remedy =
      "check that robot poses, images and target belong together";
  double min_misfit = kMaxMisfitRatio * misfit;
  const auto consider = [&](double other, const std::string& explanation) {
    if (other >= min_misfit) return;
    min_misfit = other;
    remedy = explanation;
  };
  const bool in_hand = mounting == Mounting::kEyeInHand;
  consider(inverted,
           fmt::format("they fit if they are inverted: change "
                       "--robot-convention, or use {} if the camera is {}",
                       in_hand ? "--eye-to-hand" : "--eye-in-hand",
                       in_hand ? "fixed to the base" : "on the gripper"));
  // The poses were inverted at reading with the other convention.
  const auto invert_reordered = [](auto* rows) {
    InvertRobot(rows);
    ReorderQuaternions(rows);
    InvertRobot(rows);
  };
  consider(
      std::min(
          ComputeMisfitWithChange(observations, mounting, ReorderQuaternions),
          ComputeMisfitWithChange(observations, mounting, invert_reordered)),
      "they fit if quaternions are in the order w x y z; reorder them");
  for (const int direction : {1, -1})
    consider(ComputeMisfitWithChange(
                 observations, mounting,
                 [&](auto* rows) { ShiftRobot(direction, rows); }),
             fmt::format("they fit if each image has the robot pose of the {} "
                         "one; align the rows",
                         direction > 0 ? "previous" : "next"));
  throw Error(
      ExitCode::kInitializationFailed,
      fmt::format("no hand-eye transformation fits the robot poses: half of "
                  "them differ by {:.3g} mm and {:.3g}° or more; {}",
                  1000 * start.translation_m, start.rotation_rad * kToDegrees,
                  remedy));
}

}  // namespace raygrid
