#ifndef RAYGRID_EXCHANGE_YAML_NUMBERS_H
#define RAYGRID_EXCHANGE_YAML_NUMBERS_H

#include <yaml-cpp/yaml.h>

#include <array>
#include <string>
#include <vector>

#include "camera/area.h"
#include "camera/pose.h"

namespace raygrid {

/// Loads another program's YAML or JSON, which must be a mapping. Throws
/// InputError and exceptions of yaml-cpp.
YAML::Node LoadForeignMap(const std::string& path, const std::string& text);

/// Returns a finite number. Throws InputError with the name.
double FiniteNumber(const YAML::Node& node, const std::string& name);

/// Returns a list of finite numbers. Requires `count` numbers, unless count is
/// negative.
std::vector<double> FiniteNumbers(const YAML::Node& node,
                                  const std::string& name, int count = -1);

/// Returns the numbers of a value row by row: of a number, a list, a list of
/// lists, or a mapping whose 'data' is one of these, as OpenCV's matrices are.
/// Throws InputError with the name.
std::vector<double> AllNumbers(const YAML::Node& node, const std::string& name);

/// Converts a number to the length of an image side in pixels.
int SidePx(const YAML::Node& node, const std::string& name);

/// Converts a list [width, height] to an image size.
ImageSize GetListSize(const YAML::Node& node, const std::string& name);

/// Formats the shortest round-trip decimal that YAML and Python parse as a
/// float (500.0, not 500; never 1e-05).
std::string FormatReal(double number);

/// Converts a matrix [R t] or [R t; 0 0 0 1], row by row. Throws InputError
/// with the name if R is not a rotation.
Pose PoseFromMatrix(const std::vector<double>& rows, const std::string& name);

/// Converts a quaternion w, x, y, z, which is normalized, and a translation.
/// Throws InputError unless its norm is between 0.5 and 2.
Pose PoseFromQuaternion(const std::array<double, 7>& numbers);

/// Formats numbers by FormatReal(), separated by commas and spaces.
std::string RealTexts(const std::vector<double>& numbers);

/// Formats a name as a quoted string without control characters.
std::string QuotedYaml(const std::string& text);

/// Converts ASCII letters to lower case.
std::string Lowercase(std::string text);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_YAML_NUMBERS_H
