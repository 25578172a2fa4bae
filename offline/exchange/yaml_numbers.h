#ifndef RAYGRID_EXCHANGE_YAML_NUMBERS_H
#define RAYGRID_EXCHANGE_YAML_NUMBERS_H

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "camera/area.h"

namespace raygrid {

/// A finite number of a file. Throws InputError, naming it.
double FiniteNumber(const YAML::Node& node, const std::string& name);

/// A list of finite numbers; of so many, if a count is given.
std::vector<double> FiniteNumbers(const YAML::Node& node,
                                  const std::string& name, int count = -1);

/// An image's side in pixels.
int SidePx(const YAML::Node& node, const std::string& name);

/// A list of width and height.
ImageSize SizeOfList(const YAML::Node& node, const std::string& name);

/// A number in as many digits as it needs, never without a point or exponent:
/// some programs take 500 for another type than 500.0.
std::string RealText(double number);

/// RealText() of numbers, with commas and spaces between.
std::string RealTexts(const std::vector<double>& numbers);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_YAML_NUMBERS_H
