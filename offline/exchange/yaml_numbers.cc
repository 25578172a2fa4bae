#include "exchange/yaml_numbers.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"

namespace raygrid {

YAML::Node LoadForeignMap(const std::string& path, const std::string& text) {
  RequireYamlFile(path, text, LastLine::kMayBeUnterminated);
  const YAML::Node root = YAML::Load(text);
  if (!root.IsMap()) throw InputError("contains no camera: expected a mapping");
  return root;
}

double FiniteNumber(const YAML::Node& node, const std::string& name) {
  double number = NAN;
  if (!node.IsDefined() || !node.IsScalar() ||
      !YAML::convert<double>::decode(node, number) || !std::isfinite(number))
    throw InputError(fmt::format("{}: expected a finite number", name));
  return number;
}

std::vector<double> FiniteNumbers(const YAML::Node& node,
                                  const std::string& name, int count) {
  if (!node.IsDefined() || !node.IsSequence() ||
      (count >= 0 && static_cast<int>(node.size()) != count))
    throw InputError(
        count < 0
            ? fmt::format("{}: expected a list of numbers", name)
            : fmt::format("{}: expected a list of {} numbers", name, count));
  std::vector<double> numbers;
  for (const YAML::Node& number : node)
    numbers.push_back(FiniteNumber(number, name));
  return numbers;
}

std::vector<double> AllNumbers(const YAML::Node& node,
                               const std::string& name) {
  if (!node.IsDefined()) throw InputError(fmt::format("'{}' is missing", name));
  const YAML::Node data = node.IsMap() ? node["data"] : node;
  if (data.IsDefined() && data.IsScalar()) return {FiniteNumber(data, name)};
  if (!data.IsDefined() || !data.IsSequence() || data.size() == 0 ||
      !data[0].IsSequence())
    return FiniteNumbers(data, name);
  std::vector<double> all;
  for (const YAML::Node& row : data)
    for (const double number : FiniteNumbers(row, name)) all.push_back(number);
  return all;
}

int SidePx(const YAML::Node& node, const std::string& name) {
  const double side = FiniteNumber(node, name);
  if (!(side >= 1 && side <= 1e6) || side != std::floor(side))
    throw InputError(fmt::format("{}: invalid image size", name));
  return static_cast<int>(side);
}

ImageSize GetListSize(const YAML::Node& node, const std::string& name) {
  const YAML::Node sides = node.IsMap() ? node["data"] : node;
  if (!sides.IsDefined() || !sides.IsSequence() || sides.size() != 2)
    throw InputError(fmt::format("{}: expected width and height", name));
  return {SidePx(sides[0], name), SidePx(sides[1], name)};
}

std::string FormatReal(double number) {
  std::string text = fmt::format("{}", number);
  if (text.find('.') == std::string::npos)
    text.insert(std::min(text.find('e'), text.size()), ".0");
  return text;
}

Pose PoseFromMatrix(const std::vector<double>& rows, const std::string& name) {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      rotation(row, column) = rows[4 * row + column];
    translation[row] = rows[4 * row + 3];
  }
  if (!((rotation * rotation.transpose() - Eigen::Matrix3d::Identity())
            .cwiseAbs()
            .maxCoeff() < 1e-3) ||
      !(rotation.determinant() > 0))
    throw InputError(fmt::format("{}: not a rotation matrix", name));
  return {Eigen::Quaterniond(rotation).normalized(), translation};
}

Pose PoseFromQuaternion(const std::array<double, 7>& numbers) {
  const Eigen::Quaterniond rotation(numbers[0], numbers[1], numbers[2],
                                    numbers[3]);
  if (!(rotation.norm() > 0.5) || !(rotation.norm() < 2))
    throw InputError("not a unit quaternion");
  Pose pose;
  // Unit quaternions are not normalized again, so that they are written as they
  // were read.
  pose.rotation =
      std::abs(rotation.norm() - 1) < 1e-12 ? rotation : rotation.normalized();
  pose.translation = {numbers[4], numbers[5], numbers[6]};
  return pose;
}

std::string RealTexts(const std::vector<double>& numbers) {
  std::string texts;
  for (const double number : numbers)
    texts += (texts.empty() ? "" : ", ") + FormatReal(number);
  return texts;
}

std::string QuotedYaml(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : Printable(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string Lowercase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

}  // namespace raygrid
