#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <optional>
#include <set>

#include "dataset/error.h"
#include "dataset/robot_poses.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

bool ParsePlainNumber(const std::string& text, double* value) {
  const char* const end = text.data() + text.size();
  const auto [next, error] = std::from_chars(text.data(), end, *value);
  return error == std::errc() && next == end && std::isfinite(*value);
}

// The forms of a name: as it is, without folder, and also without extension.
std::vector<std::string> ListNameForms(const std::string& name) {
  double time = 0;
  if (ParsePlainNumber(name, &time)) return {name, name, name};
  const std::filesystem::path path(name);
  return {name, path.filename().string(), path.stem().string()};
}

// Indices of the robot poses by a form of their label; -1: ambiguous.
std::map<std::string, int> IndexLabels(const RobotPoses& robot, size_t form) {
  std::map<std::string, int> index;
  for (size_t k = 0; k < robot.poses.size(); ++k) {
    const auto [entry, is_new] = index.try_emplace(
        ListNameForms(robot.poses[k].label)[form], static_cast<int>(k));
    if (!is_new) entry->second = -1;
  }
  return index;
}

void RequireDistinctLabels(const std::string& path, const RobotPoses& robot) {
  std::set<std::string> labels;
  for (const RobotPose& pose : robot.poses)
    if (!labels.insert(pose.label).second)
      throw InputError(fmt::format("{}: two poses of '{}'; remove one", path,
                                   Printable(pose.label)));
}

std::map<std::string, Pose> MatchByName(
    const RobotPoses& robot, const std::vector<std::string>& images) {
  constexpr size_t kForms = 3;
  std::map<std::string, Pose> matched;
  for (size_t form = 0; form < kForms && matched.empty(); ++form) {
    const std::map<std::string, int> index = IndexLabels(robot, form);
    std::map<std::string, int> num_images;
    for (const std::string& image : images)
      ++num_images[ListNameForms(image)[form]];
    for (const std::string& image : images) {
      const std::string name = ListNameForms(image)[form];
      const auto found = index.find(name);
      if (found != index.end() && found->second >= 0 && num_images[name] == 1)
        matched[image] = robot.poses[found->second].pose;
    }
  }
  return matched;
}

Pose Interpolate(const Pose& a, const Pose& b, double fraction) {
  return {a.rotation.slerp(fraction, b.rotation).normalized(),
          a.translation + fraction * (b.translation - a.translation)};
}

// Robot poses by time.
std::map<double, Pose> SortByTime(const std::string& path,
                                  const RobotPoses& robot) {
  std::map<double, Pose> sorted;
  for (const RobotPose& pose : robot.poses) {
    double time = 0;
    ParseTime(pose.label, &time);
    if (!sorted.emplace(time, pose.pose).second)
      throw InputError(fmt::format("{}: two poses at time {}; remove one", path,
                                   Printable(pose.label)));
  }
  return sorted;
}

// The pose at a time, if the nearest pose is at most max_gap away.
std::optional<Pose> PoseAt(const std::map<double, Pose>& poses, double time,
                           double max_gap) {
  const auto after = poses.lower_bound(time);
  const double gap_after =
      after == poses.end() ? INFINITY : after->first - time;
  const double gap_before =
      after == poses.begin() ? INFINITY : time - std::prev(after)->first;
  if (std::min(gap_after, gap_before) > max_gap) return std::nullopt;
  if (gap_after == 0) return after->second;
  // The neighbours of a pose may be far away if poses are sparse.
  constexpr double kWide = 2;
  if (gap_after + gap_before <= kWide * max_gap)
    return Interpolate(std::prev(after)->second, after->second,
                       gap_before / (gap_before + gap_after));
  return gap_after < gap_before ? after->second : std::prev(after)->second;
}

bool HaveTimes(const RobotPoses& robot) {
  double time = 0;
  return std::all_of(
      robot.poses.begin(), robot.poses.end(),
      [&](const RobotPose& pose) { return ParseTime(pose.label, &time); });
}

// Times of the images that have one.
std::map<std::string, double> ParseTimes(const std::vector<std::string>& images,
                                         const MatchingOptions& options) {
  std::map<std::string, double> times;
  for (const std::string& image : images) {
    double time = 0;
    const auto given = options.image_times.find(image);
    if (given != options.image_times.end())
      times[image] = given->second;
    else if (options.image_times.empty() && ParseTime(image, &time))
      times[image] = time;
  }
  return times;
}

std::map<std::string, Pose> MatchByTime(
    const std::string& path, const RobotPoses& robot,
    const std::map<std::string, double>& times, double max_gap) {
  const std::map<double, Pose> sorted = SortByTime(path, robot);
  std::map<std::string, Pose> matched;
  for (const auto& [image, time] : times)
    if (const auto pose = PoseAt(sorted, time, max_gap)) matched[image] = *pose;
  if (matched.empty() && !times.empty()) {
    double first = INFINITY, last = -INFINITY;
    for (const auto& [image, time] : times) {
      first = std::min(first, time);
      last = std::max(last, time);
    }
    throw InputError(fmt::format(
        "{}: no pose within {} s of an image: poses are from {:.3f} to {:.3f} "
        "s, images from {:.3f} to {:.3f} s; use --max-time-gap or "
        "--image-times",
        path, max_gap, sorted.begin()->first, sorted.rbegin()->first, first,
        last));
  }
  return matched;
}

std::map<std::string, Pose> MatchByOrder(const std::string& path,
                                         const RobotPoses& robot,
                                         std::vector<std::string> images) {
  if (robot.poses.size() != images.size())
    throw InputError(fmt::format(
        "{}: {} poses without names or times, but {} images; begin each line "
        "with the image's name",
        path, robot.poses.size(), images.size()));
  std::sort(images.begin(), images.end());
  std::map<std::string, Pose> matched;
  for (size_t k = 0; k < images.size(); ++k)
    matched[images[k]] = robot.poses[k].pose;
  return matched;
}

}  // namespace

bool ParseTime(const std::string& label, double* seconds) {
  double time = 0;
  if (!ParsePlainNumber(label, &time) &&
      !ParsePlainNumber(std::filesystem::path(label).stem().string(), &time))
    return false;
  constexpr double kMilliseconds = 1e11, kMicroseconds = 1e14,
                   kNanoseconds = 1e17;
  if (time >= kNanoseconds)
    time *= 1e-9;
  else if (time >= kMicroseconds)
    time *= 1e-6;
  else if (time >= kMilliseconds)
    time *= 1e-3;
  *seconds = time;
  return true;
}

MatchedRobotPoses MatchRobotPoses(const std::string& path,
                                  const RobotPoses& robot,
                                  const std::vector<std::string>& images,
                                  const MatchingOptions& options) {
  const bool are_labelled =
      std::none_of(robot.poses.begin(), robot.poses.end(),
                   [](const RobotPose& pose) { return pose.label.empty(); });
  if (!are_labelled) return {MatchByOrder(path, robot, images), "order"};
  RequireDistinctLabels(path, robot);
  MatchedRobotPoses matched = {MatchByName(robot, images), "name"};
  const std::map<std::string, double> times = ParseTimes(images, options);
  const bool use_times =
      !options.image_times.empty() || matched.by_image.size() < images.size();
  if (use_times && HaveTimes(robot) && !times.empty())
    matched = {MatchByTime(path, robot, times, options.max_time_gap_s), "time"};
  if (matched.by_image.empty())
    throw InputError(fmt::format(
        "{}: '{}' is neither the name of an image, such as '{}', nor a time "
        "that images have; use image names, or --image-times",
        path, Printable(robot.poses.front().label),
        images.empty() ? "" : Printable(images.front())));
  return matched;
}

}  // namespace raygrid
