#include "exchange/mrcal_corners_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/token_lines.h"
#include "exchange/count_text.h"

namespace raygrid {
namespace {

constexpr char kNoValue[] = "-";

// ---- The columns -----------------------------------------------------------

// Returns the column names of a vnlog: the words of the first line that begins
// with a single '#'. Empty if other lines precede it.
std::vector<std::string> ReadLegend(const std::string& text) {
  constexpr size_t kHeadBytes = 1 << 16;
  std::istringstream lines(text.substr(0, kHeadBytes));
  for (std::string line; std::getline(lines, line) && line[0] == '#';) {
    if (line.compare(0, 2, "##") == 0 || line.compare(0, 2, "#!") == 0)
      continue;
    std::istringstream words(line.substr(1));
    std::vector<std::string> legend;
    for (std::string word; words >> word;) legend.push_back(word);
    if (!legend.empty()) return legend;
  }
  return {};
}

struct CornerColumns {
  size_t count = 3;
  bool has_level = false, has_weight = false;
};

bool IsMrcalCorners(const std::string& text) {
  const std::vector<std::string> legend = ReadLegend(text);
  return legend.size() >= 3 && legend[0] == "filename" && legend[1] == "x" &&
         legend[2] == "y";
}

CornerColumns ParseColumns(const std::string& text) {
  const std::vector<std::string> legend = ReadLegend(text);
  if (!IsMrcalCorners(text) || legend.size() > 4)
    throw InputError(
        "its columns must be '# filename x y', optionally followed by 'level' "
        "or 'weight'");
  CornerColumns columns;
  columns.count = legend.size();
  if (columns.count == 3) return columns;
  columns.has_level = legend[3] == "level";
  columns.has_weight = legend[3] == "weight";
  if (!columns.has_level && !columns.has_weight)
    throw InputError(
        fmt::format("unknown column '{}', expected 'level' or 'weight'",
                    Printable(legend[3])));
  return columns;
}

// ---- The corners -----------------------------------------------------------

// All corners of an image in the order of the file; corners without a value
// were rejected.
struct CornerRows {
  std::string image;
  std::vector<std::optional<Eigen::Vector2d>> corners;
};

struct CornerCounts {
  size_t num_images_without_board = 0, rejected = 0, num_blurred = 0;
};

// Whether mrcal uses a detected corner.
bool IsOccupied(const TokenLines& line, const CornerColumns& columns,
                CornerCounts* counts) {
  if (columns.count < 4) return true;
  if (line.Text(3) == kNoValue) return false;
  const double value = line.Get<double>(3);
  if (columns.has_level && value > 0) ++counts->num_blurred;
  return columns.has_level ? value >= 0 : value > 0;
}

std::optional<Eigen::Vector2d> ParseCorner(const TokenLines& line,
                                           const CornerColumns& columns,
                                           CornerCounts* counts) {
  if (line.Text(1) == kNoValue && line.Text(2) == kNoValue) return std::nullopt;
  const Eigen::Vector2d pixel(line.Get<double>(1), line.Get<double>(2));
  if (!IsOccupied(line, columns, counts)) return std::nullopt;
  return pixel;
}

// Throws for a wrong number of columns. mrgingham omits the last column for
// images without a detected target.
void RequireColumns(const TokenLines& line, const CornerColumns& columns) {
  const bool is_short = line.size() == 3 && line.Text(1) == kNoValue;
  if (line.size() != columns.count && !is_short)
    line.ThrowError(fmt::format("has {} fields, but the legend has {}",
                                line.size(), columns.count));
}

std::vector<CornerRows> ReadCornerRows(const ReadRequest& request,
                                       const CornerColumns& columns,
                                       CornerCounts* counts) {
  TokenLines line(request.path, request.text, "corners in mrcal's format");
  std::vector<CornerRows> images;
  std::set<std::string> names;
  while (line.NextNonEmpty()) {
    RequireColumns(line, columns);
    const std::string& name = line.Text(0);
    if (images.empty() || images.back().image != name) {
      if (!names.insert(name).second)
        line.ThrowError(fmt::format("the rows of image '{}' are not contiguous",
                                    Printable(name)));
      images.push_back({name, {}});
    }
    images.back().corners.push_back(ParseCorner(line, columns, counts));
  }
  return images;
}

// ---- The board -------------------------------------------------------------

// Returns the sum of the norms of second differences along rows of the given
// number of columns, in pixels. Large values indicate a wrong number of
// columns, because rows then wrap.
double ComputeSagitta(const CornerRows& image, int columns) {
  double sagitta = 0;
  for (size_t k = 0; k + 2 < image.corners.size(); ++k) {
    if (static_cast<int>(k) % columns + 2 >= columns) continue;
    const auto &a = image.corners[k], &b = image.corners[k + 1],
               &c = image.corners[k + 2];
    if (a && b && c) sagitta += (*a - 2 * *b + *c).norm();
  }
  return sagitta;
}

// Throws if columns and rows are exchanged, which the number of corners cannot
// reveal.
void RequireBoardOrientation(const std::vector<CornerRows>& images,
                             const ImageSize& board) {
  if (std::min(board.width, board.height) < 3 || board.width == board.height)
    return;
  double configuration = 0, turned = 0;
  for (const CornerRows& image : images) {
    configuration +=
        ComputeSagitta(image, board.width) / (board.width - 2) / board.height;
    turned +=
        ComputeSagitta(image, board.height) / (board.height - 2) / board.width;
  }
  if (configuration > 3 * turned)
    throw InputError(fmt::format(
        "the corners match --board-size {}x{} (columns first), not {}x{}",
        board.height, board.width, board.width, board.height));
}

ImageFeatures MakeImageFeatures(const CornerRows& image,
                                const ImageSize& board) {
  const size_t expected = static_cast<size_t>(board.width) * board.height;
  if (image.corners.size() != expected)
    throw InputError(fmt::format(
        "image '{}' has {}, but --board-size {}x{} implies {}",
        Printable(image.image), CountText(image.corners.size(), "corner"),
        board.width, board.height, expected));
  ImageFeatures features = {image.image, {}};
  for (size_t k = 0; k < expected; ++k)
    if (image.corners[k])
      features.features.push_back({0, static_cast<int>(k) % board.width,
                                   static_cast<int>(k) / board.width,
                                   *image.corners[k]});
  return features;
}

void AddCornerWarnings(const CornerCounts& counts, ExchangeContents* contents) {
  const auto add = [&](size_t count, const char* noun, const char* what) {
    if (count > 0)
      contents->warnings.push_back(
          fmt::format("{}: {}", what, CountText(count, noun)));
  };
  add(counts.num_images_without_board, "image", "without a board");
  add(counts.rejected, "corner", "rejected by the program and omitted");
  add(counts.num_blurred, "corner",
      "found at reduced resolution and weighted equally");
}

ExchangeContents ReadMrcalCorners(const ReadRequest& request) {
  const CornerColumns columns = ParseColumns(request.text);
  if (!request.board)
    throw InputError(
        "missing board size; specify it in corners with --board-size "
        "COLUMNSxROWS, such as --board-size 10x10");
  CornerCounts counts;
  const std::vector<CornerRows> images =
      ReadCornerRows(request, columns, &counts);
  ExchangeContents contents;
  for (const CornerRows& image : images) {
    if (image.corners.size() == 1 && !image.corners[0]) {
      ++counts.num_images_without_board;
      continue;
    }
    ImageFeatures features = MakeImageFeatures(image, *request.board);
    counts.rejected += image.corners.size() - features.features.size();
    if (!features.features.empty())
      contents.corners.push_back(std::move(features));
  }
  RequireBoardOrientation(images, *request.board);
  AddCornerWarnings(counts, &contents);
  return contents;
}

}  // namespace

Format MakeMrcalCornersFormat() {
  Format format;
  format.name = "mrcal-corners";
  format.holds =
      "corners.vnl of mrcal and mrgingham: corners of a board, imported with "
      "--board-size COLUMNSxROWS";
  format.requires_board_size = true;
  format.recognizes = IsMrcalCorners;
  format.read = ReadMrcalCorners;
  format.write = nullptr;
  return format;
}

}  // namespace raygrid
