#include "dataset/rectified_file.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <vector>

#include "dataset/error.h"
#include "dataset/image_header.h"
#include "dataset/yaml_file.h"

namespace raygrid {
namespace {

Eigen::Matrix<double, 3, 4> ParseProjection(const YAML::Node& rows,
                                            const std::string& name) {
  Eigen::Matrix<double, 3, 4> p;
  if (!rows.IsSequence() || rows.size() != 3)
    throw InputError(name + ": not 3 x 4");
  for (int row = 0; row < 3; ++row) {
    const auto numbers = rows[row].as<std::vector<double>>();
    if (numbers.size() != 4) throw InputError(name + ": not 3 x 4");
    for (int column = 0; column < 4; ++column) p(row, column) = numbers[column];
  }
  if (!p.allFinite() || !(p(0, 0) > 0) || !(p(1, 1) > 0))
    throw InputError(name + ": not a projection matrix");
  return p;
}

// Throws exceptions of yaml-cpp, and InputError without the file name.
RectifiedFile ParsePair(const YAML::Node& root) {
  if (!root.IsMap() || !root["raygrid_rectified"] ||
      root["raygrid_rectified"].as<int>() != 1)
    throw InputError("not a rectified pair (no 'raygrid_rectified: 1')");
  RectifiedFile file;
  file.names = {root["left"].as<std::string>(),
                root["right"].as<std::string>()};
  const auto size = root["image_size"].as<std::vector<int>>();
  if (size.size() != 2 || size[0] < 1 || size[1] < 1 ||
      std::max(size[0], size[1]) > kMaxHugeSidePx)
    throw InputError("image_size: expected two positive integers");
  file.size = {size[0], size[1]};
  file.p = {ParseProjection(root["P1"], "P1"),
            ParseProjection(root["P2"], "P2")};
  return file;
}

}  // namespace

RectifiedFile ParseRectifiedFile(const std::string& path,
                                 const std::string& text) {
  RequireYamlFile(path, text);
  return ReadNamingFile(path, [&] { return ParsePair(YAML::Load(text)); });
}

}  // namespace raygrid
