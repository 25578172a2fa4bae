#include "exchange/ocamcalib_format.h"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/nearest_grid.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kDirect[] = "polynomial coefficients for the DIRECT mapping";

// The numbers of a file, without its comments. The blocks follow each other in
// one order, and lists begin with their lengths.
class OcamNumbers {
 public:
  explicit OcamNumbers(const std::string& text) {
    if (FindNoUtf8(text) != std::string::npos)
      throw InputError("not a text file");
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
      throw InputError(fmt::format("ends before its {}", what));
    return numbers_[at_++];
  }

  std::vector<double> NextList(const char* what) {
    constexpr double kMost = 100;
    const double count = Next(what);
    if (!(count >= 1 && count <= kMost) || count != std::floor(count))
      throw InputError(
          fmt::format("{}: {:g} is no count of numbers", what, count));
    std::vector<double> list;
    while (list.size() < count) list.push_back(Next(what));
    return list;
  }

 private:
  std::vector<double> numbers_;
  size_t at_ = 0;
};

int OcamSidePx(OcamNumbers* numbers, const char* what) {
  return SidePx(YAML::Node(RealText(numbers->Next(what))), what);
}

// Rows are x there and columns y, and what is seen lies at negative z.
ExchangeContents ReadOcamCalib(const ReadRequest& request) {
  OcamNumbers numbers(request.text);
  const std::vector<double> direct = numbers.NextList("polynomial");
  numbers.NextList("inverse polynomial");
  const double row = numbers.Next("center"), column = numbers.Next("center");
  const double c = numbers.Next("affine parameters"),
               d = numbers.Next("affine parameters"),
               e = numbers.Next("affine parameters");
  ImageSize size;
  size.height = OcamSidePx(&numbers, "image size");
  size.width = OcamSidePx(&numbers, "image size");
  const double determinant = c - d * e;
  if (!(std::abs(determinant) > 1e-3 && std::abs(determinant) < 1e3))
    throw InputError("affine parameters: no stretch of an image");
  ExchangeContents contents;
  contents.cameras.emplace_back().lens = NearestGrid(
      size,
      [&](const Eigen::Vector2d& pixel) {
        const double x = pixel.y() - row, y = pixel.x() - column;
        const double down = (x - d * y) / determinant,
                     right = (c * y - e * x) / determinant;
        const double radius = std::hypot(down, right);
        double z = 0;
        for (size_t k = direct.size(); k-- > 0;) z = z * radius + direct[k];
        return Eigen::Vector3d(right, down, -z);
      },
      "its lens is a polynomial of the radius, which no lens of raygrid is",
      &contents.remarks);
  return contents;
}

}  // namespace

Format OcamCalibFormat() {
  Format format;
  format.name = "ocamcalib";
  format.holds = "calib_results.txt of OCamCalib, as the nearest grid";
  format.forms = {NearestGridForm()};
  format.recognizes = [](const std::string& text) {
    return text.find(kDirect) != std::string::npos;
  };
  format.read = ReadOcamCalib;
  format.write = nullptr;
  return format;
}

}  // namespace raygrid
