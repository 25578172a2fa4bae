#include "exchange/dso_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <sstream>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/nearest_grid.h"
#include "exchange/opencv_model_list.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kDsoFov[] = "FOV";

const std::vector<ExternalModel>& GetDsoModels() {
  static const std::vector<ExternalModel> external_models = {
      MakeOpenCvModel("Pinhole", 0), MakeOpenCvModel("RadTan", 4),
      MakeOpenCvFisheyeModel("EquiDistant"),
      MakeOpenCvFisheyeModel("KannalaBrandt")};
  return external_models;
}

// Splits the first two non-empty lines into words.
std::array<std::vector<std::string>, 2> FirstLines(const std::string& text) {
  std::array<std::vector<std::string>, 2> found;
  std::istringstream lines(text);
  size_t next = 0;
  for (std::string line; next < 2 && std::getline(lines, line);) {
    std::istringstream words(line);
    for (std::string word; words >> word;) found[next].push_back(word);
    if (!found[next].empty()) ++next;
  }
  return found;
}

bool IsDso(const std::string& text) {
  constexpr size_t kMaxBytes = 1000;
  if (text.size() > kMaxBytes) return false;
  const auto lines = FirstLines(text);
  const std::vector<std::string>&lens = lines[0], &size = lines[1];
  const auto is_number = [](const std::string& word) {
    return word.find_first_not_of("0123456789.+-eE") == std::string::npos;
  };
  if (lens.empty() || size.size() != 2 ||
      !std::all_of(lens.begin() + 1, lens.end(), is_number) ||
      !std::all_of(size.begin(), size.end(), [](const std::string& word) {
        return word.find_first_not_of("0123456789") == std::string::npos;
      }))
    return false;
  if (is_number(lens[0])) return lens.size() == 5 || lens.size() == 8;
  return lens[0] == kDsoFov ||
         std::any_of(GetDsoModels().begin(), GetDsoModels().end(),
                     [&](const ExternalModel& external_model) {
                       return external_model.name == lens[0];
                     });
}

// Reads the FOV model of F. Devernay and O. Faugeras, whose distorted radius is
// an angle.
ConvertedCamera ReadFov(const ImageSize& size,
                        const std::vector<double>& values,
                        std::vector<std::string>* warnings) {
  const double omega = values[4];
  if (!(omega > 0 && omega < M_PI))
    throw InputError(
        fmt::format("{}: {:g} is not a valid field of view", kDsoFov, omega));
  return FitNearestGrid(
      size,
      [&](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector3d> {
        const Eigen::Vector2d xy((pixel.x() - values[2]) / values[0],
                                 (pixel.y() - values[3]) / values[1]);
        const double bent = xy.norm();
        if (bent * omega >= M_PI / 2) return std::nullopt;
        const double straight =
            bent > 0 ? std::tan(bent * omega) / (2 * std::tan(omega / 2)) / bent
                     : 1;
        return Eigen::Vector3d(xy.x() * straight, xy.y() * straight, 1);
      },
      "the FOV model has no equivalent", warnings);
}

ExchangeContents ReadDso(const ReadRequest& request) {
  if (FindInvalidUtf8(request.text) != std::string::npos)
    throw InputError("not UTF-8 text");
  auto [lens, sides] = FirstLines(request.text);
  if (lens.empty() || sides.size() != 2)
    throw InputError(
        "the first two lines must be the intrinsics and the image size");
  std::string model = lens.size() == 5   ? kDsoFov
                      : lens.size() == 8 ? "RadTan"
                                         : "";
  if (std::isalpha(static_cast<unsigned char>(lens[0][0]))) {
    model = lens[0];
    lens.erase(lens.begin());
  }
  std::vector<double> values;
  for (const std::string& word : lens)
    values.push_back(FiniteNumber(YAML::Node(word), Printable(word)));
  const ImageSize size = {SidePx(YAML::Node(sides[0]), "width"),
                          SidePx(YAML::Node(sides[1]), "height")};
  if (values.size() < 4)
    throw InputError(
        fmt::format("expected at least 4 intrinsics, found {}", values.size()));
  // Intrinsics relative to the image size; the first pixel's corner is at 0.
  if (values[2] < 1 && values[3] < 1)
    values = [&, parts = values]() mutable {
      parts[0] *= size.width;
      parts[1] *= size.height;
      parts[2] = parts[2] * size.width - 0.5;
      parts[3] = parts[3] * size.height - 0.5;
      return parts;
    }();
  if (!(values[0] > 0 && values[1] > 0))
    throw InputError("focal lengths must be positive");
  ExchangeContents contents;
  ConvertedCamera& read = contents.cameras.emplace_back().lens;
  if (model == kDsoFov && values.size() == 5 && values[4] != 0) {
    read = ReadFov(size, values, &contents.warnings);
    return contents;
  }
  const std::string name = model == kDsoFov ? "Pinhole" : model;
  for (const ExternalModel& external_model : GetDsoModels())
    if (external_model.name == name) read.external_model = &external_model;
  if (!read.external_model)
    throw InputError(fmt::format("'{}' is not a DSO model", model));
  if (name == "Pinhole") TrimCoefficients(4, &values);
  read.size = size;
  read.values = values;
  return contents;
}

// Writes four lines; DSO reads no more. It undistorts to the same size and
// crops to the area without borders.
std::string WriteDso(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const bool is_pinhole = camera.lens.external_model->name == "Pinhole";
  std::string text = camera.lens.external_model->name;
  for (const double value : camera.lens.values) text += " " + FormatReal(value);
  const std::string size =
      fmt::format("{} {}\n", camera.lens.size.width, camera.lens.size.height);
  text += fmt::format("{}\n{}{}\n{}", is_pinhole ? " 0.0" : "", size,
                      is_pinhole ? "none" : "crop", size);
  if (camera.fit)
    text += fmt::format("# nearest {}: {}\n", camera.lens.external_model->name,
                        FormatModelFit(*camera.fit));
  return text;
}

}  // namespace

Format MakeDsoFormat() {
  Format format;
  format.name = "dso";
  format.holds =
      "camera.txt of DSO, LSD-SLAM and the TUM monocular dataset; FOV "
      "converted to central-generic";
  format.external_models = GetDsoModels();
  format.ending = ".txt";
  format.discards_rig_poses = true;
  format.recognizes = IsDso;
  format.read = ReadDso;
  format.write = WriteDso;
  return format;
}

}  // namespace raygrid
