#include "exchange/puzzlepaint_dataset_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/count_text.h"
#include "exchange/puzzlepaint_files.h"

namespace raygrid {
namespace {

// ---- Reading ---------------------------------------------------------------

// Position of a feature: board, column and row.
struct LatticePosition {
  int board = 0;
  Eigen::Vector2i place;
};

std::map<int32_t, LatticePosition> ListFeaturePositions(
    const PuzzlepaintDataset& dataset) {
  std::map<int32_t, LatticePosition> places;
  for (size_t k = 0; k < dataset.geometries.size(); ++k)
    for (const auto& [id, place] : dataset.geometries[k].places)
      places[id] = {static_cast<int>(k), place};
  return places;
}

// The file does not describe the board's appearance, so the board is imported
// as a point set.
Board MakeBoard(const PuzzlepaintGeometry& geometry, int id) {
  Board board;
  board.id = id;
  board.kind = "points";
  Eigen::Vector2i size = {0, 0};
  for (const auto& [feature, place] : geometry.places)
    size = size.cwiseMax(place + Eigen::Vector2i(1, 1));
  board.columns = size.x();
  board.rows = size.y();
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      board.points.push_back(geometry.PointAt({column, row}));
  return board;
}

FeatureTable ReadPuzzlepaintDataset(const std::string& path,
                                    const std::string& bytes) {
  return ReadNamingFile(path, [&] {
    const PuzzlepaintDataset dataset = DecodePuzzlepaintDataset(bytes);
    FeatureTable table;
    const size_t num_cameras = dataset.image_sizes.size();
    for (size_t c = 0; c < num_cameras; ++c)
      table.cameras.push_back(
          {num_cameras > 1 ? PuzzlepaintCameraName(static_cast<int>(c)) : "",
           {dataset.image_sizes[c], GetCameraFeatures(dataset, c)}});
    for (const PuzzlepaintGeometry& geometry : dataset.geometries)
      table.boards.push_back(
          MakeBoard(geometry, static_cast<int>(table.boards.size())));
    return table;
  });
}

// ---- Writing ---------------------------------------------------------------

// Returns the spacing of a board's square lattice in metres; throws if the
// features are not on such a lattice.
double CellIndex(const Board& board) {
  constexpr double kRounding = 1e-6;  // rounding of points in pattern.yaml, in
                                      // metres
  if (board.IsTagGrid())
    throw InputError(
        fmt::format("board {}: puzzlepaint requires a regular lattice of "
                    "features, which an AprilGrid does not have",
                    board.id));
  if (!board.IsPointSet()) return board.square_m;
  const double cell =
      board.columns > 1 && !board.points.empty() ? board.points[1].x() : 0;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if (!((board.points[board.PointIndex(column, row)] -
             cell * Eigen::Vector3d(column, row, 0))
                .norm() <= kRounding) ||
          !(cell > 0))
        throw InputError(
            fmt::format("board {}: puzzlepaint requires a regular lattice of "
                        "features; use the nominal target geometry",
                        board.id));
  return cell;
}

// Feature indices by board, column and row.
using FeatureIds = std::map<std::array<int, 3>, int32_t>;

// Numbers the features board by board and row by row, without positions inside
// tags.
FeatureIds AddGeometries(const std::vector<Board>& boards,
                         PuzzlepaintDataset* dataset) {
  FeatureIds ids;
  for (const Board& board : boards) {
    PuzzlepaintGeometry& geometry = dataset->geometries.emplace_back();
    geometry.cell_m = static_cast<float>(CellIndex(board));
    for (int row = 0; row < board.rows; ++row)
      for (int column = 0; column < board.columns; ++column) {
        if (!board.HasFeature(column, row)) continue;
        const auto id = static_cast<int32_t>(ids.size());
        ids[{board.id, column, row}] = id;
        geometry.places[id] = {column, row};
      }
  }
  return ids;
}

std::vector<PuzzlepaintFeature> MakePuzzlepaintFeatures(
    const FeatureIds& ids, const ImageSize& size, const ImageFeatures& image) {
  std::vector<PuzzlepaintFeature> features;
  for (const Feature& feature : image.features) {
    const auto id = ids.find({feature.board, feature.column, feature.row});
    if (id == ids.end())
      throw InputError(fmt::format(
          "image '{}': feature ({}, {}) of board {} is on a tag; use the "
          "pattern that the features were detected with",
          Printable(image.image), feature.column, feature.row, feature.board));
    features.push_back(
        {ToProgram(kPuzzlepaintOrigin, size, feature.pixel).cast<float>(),
         id->second});
  }
  return features;
}

// Images of the same name form one imageset. Imagesets are in the order of
// first appearance over the cameras.
void AddImagesets(const FeatureTable& table, const FeatureIds& ids,
                  PuzzlepaintDataset* dataset) {
  std::map<std::string, size_t> places;
  for (size_t c = 0; c < table.cameras.size(); ++c) {
    const Dataset& own = table.cameras[c].dataset;
    dataset->image_sizes.push_back(own.image_size);
    for (const ImageFeatures& image : own.images) {
      const auto [at, is_new] =
          places.emplace(image.image, dataset->imagesets.size());
      if (is_new) {
        dataset->imagesets.push_back({image.image, {}});
        dataset->imagesets.back().cameras.resize(table.cameras.size());
      }
      dataset->imagesets[at->second].cameras[c] =
          MakePuzzlepaintFeatures(ids, own.image_size, image);
    }
  }
}

TableOutput WritePuzzlepaintDataset(const FeatureTable& table) {
  return ReadNamingFile(table.path, [&] {
    PuzzlepaintDataset dataset;
    AddImagesets(table, AddGeometries(table.boards, &dataset), &dataset);
    size_t num_features = 0;
    std::string names;
    for (const NamedDataset& camera : table.cameras) {
      num_features += camera.dataset.num_features();
      names += (names.empty() ? "; cameras in this order: " : ", ") +
               Printable(camera.camera);
    }
    return TableOutput{
        {{table.output, EncodePuzzlepaintDataset(dataset)}},
        fmt::format("{} in {}{}", CountText(num_features, "feature"),
                    CountText(dataset.imagesets.size(), "imageset"),
                    table.cameras.size() > 1 ? names : "")};
  });
}

}  // namespace

std::vector<ImageFeatures> GetCameraFeatures(const PuzzlepaintDataset& dataset,
                                             size_t camera) {
  const std::vector<std::string> names = GetImageNames(dataset);
  const std::map<int32_t, LatticePosition> places =
      ListFeaturePositions(dataset);
  std::vector<ImageFeatures> images;
  for (size_t i = 0; i < names.size(); ++i) {
    ImageFeatures image = {names[i], {}};
    for (const PuzzlepaintFeature& feature :
         dataset.imagesets[i].cameras[camera]) {
      const LatticePosition& at = places.at(feature.id);
      image.features.push_back(
          {at.board, at.place.x(), at.place.y(),
           FromProgram(kPuzzlepaintOrigin, dataset.image_sizes[camera],
                       feature.pixel.cast<double>())});
    }
    if (!image.features.empty()) images.push_back(std::move(image));
  }
  return images;
}

TableFormat MakePuzzlepaintDatasetFormat() {
  TableFormat format;
  format.name = "puzzlepaint-dataset";
  format.holds =
      "dataset.bin of puzzlepaint's camera_calibration: features and target "
      "geometry of all cameras";
  format.options = {"pattern", "image-size"};
  format.write_features = WritePuzzlepaintDataset;
  format.recognizes = IsPuzzlepaintDataset;
  format.read_features = ReadPuzzlepaintDataset;
  return format;
}

}  // namespace raygrid
