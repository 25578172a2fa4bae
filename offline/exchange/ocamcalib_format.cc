#include "exchange/ocamcalib_format.h"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/nearest_grid.h"
#include "exchange/ocam_camera.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kDirect[] = "polynomial coefficients for the DIRECT mapping";

// Reads the numbers of a file and skips comments. The order of the blocks is
// fixed, and lists are preceded by their lengths.
class OcamReader {
 public:
  explicit OcamReader(const std::string& text) {
    if (FindInvalidUtf8(text) != std::string::npos)
      throw InputError("not UTF-8 text");
    RequireSmallTree("", text, " \t\n");
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line.substr(0, line.find('#')));
      for (std::string word; words >> word;)
        numbers_.push_back(FiniteNumber(YAML::Node(word), word));
    }
  }

  double Next(const char* what) {
    if (at_ == numbers_.size())
      throw InputError(fmt::format("truncated before {}", what));
    return numbers_[at_++];
  }

  std::vector<double> NextList(const char* what) {
    constexpr double kMost = 100;
    const double count = Next(what);
    if (!(count >= 1 && count <= kMost) || count != std::floor(count))
      throw InputError(
          fmt::format("{}: {:g} is not a valid count", what, count));
    std::vector<double> list;
    while (list.size() < count) list.push_back(Next(what));
    return list;
  }

 private:
  std::vector<double> numbers_;
  size_t at_ = 0;
};

int OcamSidePx(OcamReader* numbers, const char* what) {
  return SidePx(YAML::Node(FormatReal(numbers->Next(what))), what);
}

// In OCamCalib, x is the row and y the column, and the view direction is -z.
ExchangeContents ReadOcamCalib(const ReadRequest& request) {
  OcamReader numbers(request.text);
  const std::vector<double> direct = numbers.NextList("polynomial");
  numbers.NextList("inverse polynomial");
  const double row = numbers.Next("center"), column = numbers.Next("center");
  const double c = numbers.Next("affine parameters"),
               d = numbers.Next("affine parameters"),
               e = numbers.Next("affine parameters");
  ImageSize size;
  size.height = OcamSidePx(&numbers, "image size");
  size.width = OcamSidePx(&numbers, "image size");
  const OcamNumbers lens = {direct, row, column, c, d, e};
  const double determinant = c - d * e;
  if (!(std::abs(determinant) > 1e-3 && std::abs(determinant) < 1e3))
    throw InputError(
        "affine parameters: the matrix is singular or out of range");
  ExchangeContents contents;
  contents.cameras.emplace_back().lens = FitNearestGrid(
      size, [&](const Eigen::Vector2d& pixel) { return lens.Direction(pixel); },
      "the radial polynomial has no equivalent model", &contents.warnings);
  return contents;
}

// Formats a list, preceded by its length.
std::string CountedReals(const std::vector<double>& numbers) {
  std::string text = fmt::format("{}", numbers.size());
  for (const double number : numbers) text += " " + FormatReal(number);
  return text;
}

// Parsers expect a comment line before each block, and reject text after the
// last block.
std::string WriteOcamCalib(const WriteRequest& request) {
  const OutputCamera& written = request.cameras.front();
  const auto& camera = dynamic_cast<const OcamCamera&>(*written.lens.grid);
  const OcamNumbers& n = camera.numbers();
  std::string text;
  const auto add = [&](const std::string& comment, const std::string& numbers) {
    text += fmt::format("#{}\n\n{}\n\n", comment, numbers);
  };
  add(std::string(kDirect) + " function (cam2world)",
      CountedReals(n.polynomial));
  add("polynomial coefficients for the inverse mapping function (world2cam)",
      CountedReals(InverseOcamPolynomial(camera)));
  add("center: row and column, 0-based",
      fmt::format("{} {}", FormatReal(n.row), FormatReal(n.column)));
  add("affine parameters c, d, e",
      fmt::format("{} {} {}", FormatReal(n.c), FormatReal(n.d),
                  FormatReal(n.e)));
  add("image size: height and width",
      fmt::format("{} {}", written.lens.size.height, written.lens.size.width));
  if (written.fit)
    text +=
        fmt::format("#fitted polynomial: {}\n", FormatModelFit(*written.fit));
  return text;
}

const std::vector<ExternalModel>& GetOcamModels() {
  static const std::vector<ExternalModel> external_models = [] {
    ExternalModel external_model = {"polynomial", models::kCentralGeneric, {}};
    external_model.fit_grid = FitOcamCamera;
    return std::vector<ExternalModel>{external_model};
  }();
  return external_models;
}

}  // namespace

Format MakeOcamCalibFormat() {
  Format format;
  format.name = "ocamcalib";
  format.holds =
      "calib_results.txt of OCamCalib; its polynomial is converted by fitting";
  format.ending = ".txt";
  format.discards_rig_poses = true;
  format.external_models = GetOcamModels();
  format.recognizes = [](const std::string& text) {
    return text.find(kDirect) != std::string::npos;
  };
  format.read = ReadOcamCalib;
  format.write = WriteOcamCalib;
  return format;
}

}  // namespace raygrid
