#ifndef RAYGRID_EXCHANGE_YAML_NUMBERS_H
#define RAYGRID_EXCHANGE_YAML_NUMBERS_H

#include <yaml-cpp/yaml.h>

#include <array>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/pose.h"

namespace raygrid {

/// The map that another program's YAML or JSON is. Throws InputError, and what
/// yaml-cpp throws.
YAML::Node LoadForeignMap(const std::string& path, const std::string& text);

/// A finite number of a file. Throws InputError, naming it.
double FiniteNumber(const YAML::Node& node, const std::string& name);

/// A list of finite numbers; of so many, if a count is given.
std::vector<double> FiniteNumbers(const YAML::Node& node,
                                  const std::string& name, int count = -1);

/// The numbers of a value row by row: of a number, a list, a list of lists, or
/// a map whose 'data' is one of these, as matrices of OpenCV are. Throws
/// InputError, naming it.
std::vector<double> AllNumbers(const YAML::Node& node, const std::string& name);

/// An image's side in pixels.
int SidePx(const YAML::Node& node, const std::string& name);

/// A list of width and height.
ImageSize GetListSize(const YAML::Node& node, const std::string& name);

/// A number in as many digits as it needs, never without a point: Python takes
/// 500 for another type than 500.0, and 1e-05 for a text.
std::string RealText(double number);

/// A pose of a matrix [R t], or [R t; 0 0 0 1], row by row. Throws InputError,
/// naming it, if R is no rotation.
Pose PoseFromMatrix(const std::vector<double>& rows, const std::string& name);

/// A pose of a quaternion w, x, y, z and a translation. The quaternion may be
/// of about any length but 0. Throws InputError.
Pose PoseFromQuaternion(const std::array<double, 7>& numbers);

/// RealText() of numbers, with commas and spaces between.
std::string RealTexts(const std::vector<double>& numbers);

/// A name as a text in quotes, without control characters.
std::string QuotedYaml(const std::string& text);

/// Small letters of the alphabet.
std::string Lowercase(std::string text);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_YAML_NUMBERS_H
