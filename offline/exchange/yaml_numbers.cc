#include "exchange/yaml_numbers.h"

#include <fmt/format.h>

#include <cmath>

#include "dataset/error.h"

namespace raygrid {

double FiniteNumber(const YAML::Node& node, const std::string& name) {
  double number = NAN;
  if (!node.IsDefined() || !node.IsScalar() ||
      !YAML::convert<double>::decode(node, number) || !std::isfinite(number))
    throw InputError(fmt::format("{}: no finite number", name));
  return number;
}

std::vector<double> FiniteNumbers(const YAML::Node& node,
                                  const std::string& name, int count) {
  if (!node.IsDefined() || !node.IsSequence() ||
      (count >= 0 && static_cast<int>(node.size()) != count))
    throw InputError(
        count < 0 ? fmt::format("{}: no list of numbers", name)
                  : fmt::format("{}: no list of {} numbers", name, count));
  std::vector<double> numbers;
  for (const YAML::Node& number : node)
    numbers.push_back(FiniteNumber(number, name));
  return numbers;
}

int SidePx(const YAML::Node& node, const std::string& name) {
  const double side = FiniteNumber(node, name);
  if (!(side >= 1 && side <= 1e6) || side != std::floor(side))
    throw InputError(fmt::format("{}: no size of an image", name));
  return static_cast<int>(side);
}

ImageSize SizeOfList(const YAML::Node& node, const std::string& name) {
  if (!node.IsSequence() || node.size() != 2)
    throw InputError(fmt::format("{}: not width and height", name));
  return {SidePx(node[0], name), SidePx(node[1], name)};
}

std::string RealText(double number) {
  const std::string text = fmt::format("{}", number);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

std::string RealTexts(const std::vector<double>& numbers) {
  std::string texts;
  for (const double number : numbers)
    texts += (texts.empty() ? "" : ", ") + RealText(number);
  return texts;
}

}  // namespace raygrid
