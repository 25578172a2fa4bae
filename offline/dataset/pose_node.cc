#include "dataset/pose_node.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/error.h"

namespace raygrid {
namespace {

double ParsePoseNumber(const std::string& key, const YAML::Node& map,
                       const char* name) {
  const double value = map[name].as<double>();
  if (!std::isfinite(value))
    throw InputError(fmt::format("{}: {} is not finite", key, name));
  return value;
}

}  // namespace

Pose ParsePose(const std::string& key, const YAML::Node& node) {
  const YAML::Node q = node["rotation"], t = node["translation"];
  const auto number = [&](const YAML::Node& map, const char* name) {
    return ParsePoseNumber(key, map, name);
  };
  const Eigen::Quaterniond rotation(number(q, "w"), number(q, "x"),
                                    number(q, "y"), number(q, "z"));
  if (std::abs(rotation.norm() - 1) > 1e-3)
    throw InputError(key + ": rotation is not a unit quaternion");
  return {rotation.normalized(),
          {number(t, "x"), number(t, "y"), number(t, "z")}};
}

std::string FormatPose(const Pose& pose, const std::string& indentation) {
  Eigen::Quaterniond q = pose.rotation;
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Vector3d& t = pose.translation;
  return fmt::format(
      "{0}rotation: {{w: {1:.12f}, x: {2:.12f}, y: {3:.12f}, z: {4:.12f}}}\n"
      "{0}translation: {{x: {5:.9f}, y: {6:.9f}, z: {7:.9f}}}\n",
      indentation, q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z());
}

}  // namespace raygrid
