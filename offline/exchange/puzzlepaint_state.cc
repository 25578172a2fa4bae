#include "exchange/puzzlepaint_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <set>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/puzzlepaint_dataset_format.h"
#include "exchange/puzzlepaint_files.h"

namespace raygrid {
namespace {

// ---- Reading ---------------------------------------------------------------

// In the order of ReadRequest::beside.
constexpr const char* kStateFiles[] = {
    "camera_tr_rig.yaml", "rig_tr_global.yaml", "dataset.bin", "points.yaml"};

// Contents of the companion files of a camera; nullopt if missing.
struct PuzzlepaintState {
  std::optional<PuzzlepaintPoses> camera_from_rig, rig_from_world;
  std::optional<PuzzlepaintDataset> dataset;
  std::map<int, Eigen::Vector3d> points;
};

// texts: contents of the files of ListStateFiles(path).
PuzzlepaintState ReadState(const std::string& path,
                           const std::vector<std::string>& texts) {
  PuzzlepaintState state;
  const std::vector<std::string> paths = ListStateFiles(path);
  const auto take = [&](size_t k, const auto& read) {
    if (k < texts.size() && !texts[k].empty())
      ReadNamingFile(paths[k], [&] { read(paths[k], texts[k]); });
  };
  take(0, [&](const std::string& file, const std::string& text) {
    state.camera_from_rig = ParsePuzzlepaintPoses(file, text);
  });
  take(1, [&](const std::string& file, const std::string& text) {
    state.rig_from_world = ParsePuzzlepaintPoses(file, text);
  });
  take(2, [&](const std::string&, const std::string& text) {
    state.dataset = DecodePuzzlepaintDataset(text);
  });
  take(3, [&](const std::string& file, const std::string& text) {
    state.points = ParsePuzzlepaintPoints(file, text);
  });
  return state;
}

// Aligns a board's lattice with its estimated 3D points: the program's world
// frame is not that of a board, and drifts. Returns nullopt if too few points
// are known.
std::optional<Pose> ComputeWorldFromBoard(
    const PuzzlepaintGeometry& geometry,
    const std::map<int, Eigen::Vector3d>& known) {
  constexpr Eigen::Index kLeast = 4;
  Eigen::Matrix3Xd lattice(3, geometry.places.size()), points = lattice;
  Eigen::Index count = 0;
  std::set<int> columns, rows;
  for (const auto& [id, place] : geometry.places) {
    const auto found = known.find(id);
    if (found == known.end()) continue;
    columns.insert(place.x());
    rows.insert(place.y());
    lattice.col(count) = geometry.PointAt(place);
    points.col(count++) = found->second;
  }
  if (count < kLeast || columns.size() < 2 || rows.size() < 2)
    return std::nullopt;
  lattice.conservativeResize(3, count);
  points.conservativeResize(3, count);
  const Eigen::Matrix4d pose = Eigen::umeyama(lattice, points, false);
  const double off_m =
      ((pose * lattice.colwise().homogeneous()).topRows<3>() - points).norm() /
      std::sqrt(static_cast<double>(count));
  if (!(off_m < geometry.cell_m))
    throw InputError(
        fmt::format("points.yaml: the points deviate by {:g} m from the board "
                    "in dataset.bin (cell size {:g} m); both files must come "
                    "from the same calibration",
                    off_m, geometry.cell_m));
  return Pose{Eigen::Quaterniond(Eigen::Matrix3d(pose.topLeftCorner<3, 3>()))
                  .normalized(),
              pose.topRightCorner<3, 1>()};
}

// Returns the world poses, by board index, of boards with known positions.
std::map<int, Pose> ComputeBoardPoses(const PuzzlepaintState& state) {
  std::map<int, Pose> boards;
  if (!state.dataset || state.points.empty()) return boards;
  const auto& geometries = state.dataset->geometries;
  for (size_t k = 0; k < geometries.size(); ++k)
    if (const auto pose = ComputeWorldFromBoard(geometries[k], state.points))
      boards.emplace(static_cast<int>(k), *pose);
  return boards;
}

// Returns the indices of the boards that a camera observed in an image.
std::set<int> ListObservedBoards(const PuzzlepaintDataset& dataset,
                                 int imageset, int camera) {
  std::set<int> boards;
  for (const PuzzlepaintFeature& feature :
       dataset.imagesets[imageset].cameras[camera])
    for (size_t k = 0; k < dataset.geometries.size(); ++k)
      if (dataset.geometries[k].places.count(feature.id) > 0)
        boards.insert(static_cast<int>(k));
  return boards;
}

bool HasCamera(const PuzzlepaintDataset& dataset, int camera) {
  return static_cast<size_t>(camera) < dataset.image_sizes.size();
}

// Whether the dataset has as many imagesets as there are poses and contains the
// camera.
bool MatchesCamera(const PuzzlepaintState& state, int camera) {
  return state.dataset && HasCamera(*state.dataset, camera) &&
         static_cast<int>(state.dataset->imagesets.size()) ==
             state.rig_from_world->count;
}

// Without board positions, the world frame is assumed to be that of the only
// board.
std::vector<BoardPose> ListCameraPoses(const PuzzlepaintState& state, int index,
                                       const Pose& camera_from_rig) {
  const bool has_dataset = MatchesCamera(state, index);
  const std::map<int, Pose> boards =
      has_dataset ? ComputeBoardPoses(state) : std::map<int, Pose>{};
  const std::vector<std::string> names =
      has_dataset ? GetImageNames(*state.dataset) : std::vector<std::string>{};
  std::vector<BoardPose> poses;
  for (const auto& [image, rig_from_world] : state.rig_from_world->poses) {
    const std::string name = has_dataset ? names[image] : std::to_string(image);
    const Pose camera_from_world = camera_from_rig * rig_from_world;
    if (boards.empty()) {
      poses.push_back({name, 0, camera_from_world});
      continue;
    }
    for (const int board : ListObservedBoards(*state.dataset, image, index))
      if (const auto at = boards.find(board); at != boards.end())
        poses.push_back({name, board, camera_from_world * at->second});
  }
  return poses;
}

// ---- Writing ---------------------------------------------------------------

// Returns the number if an image's name is one; nullopt for other names.
std::optional<int> ParseImageNumber(const std::string& name) {
  constexpr size_t kMaxDigits = 6;
  if (name.empty() || name.size() > kMaxDigits ||
      name.find_first_not_of("0123456789") != std::string::npos ||
      (name[0] == '0' && name.size() > 1))
    return std::nullopt;
  return std::stoi(name);
}

// Image names by index; "" for missing images.
struct NumberedImages {
  std::vector<std::string> names;
  std::map<std::string, int> numbers;

  void Put(const std::string& name, int number) {
    if (static_cast<size_t>(number) >= names.size()) names.resize(number + 1);
    names[number] = name;
    numbers[name] = number;
  }
};

// Numbers images by the dataset if there is one, otherwise by their names if
// all are numbers, otherwise consecutively.
NumberedImages NumberImages(const std::vector<OutputCamera>& cameras,
                            const PuzzlepaintDataset* dataset) {
  NumberedImages images;
  if (dataset) {
    for (const std::string& name : GetImageNames(*dataset))
      images.Put(name, static_cast<int>(images.names.size()));
    return images;
  }
  bool are_numbers = true;
  for (const OutputCamera& camera : cameras)
    for (const BoardPose& pose : camera.poses)
      are_numbers = are_numbers && ParseImageNumber(pose.image);
  for (const OutputCamera& camera : cameras)
    for (const BoardPose& pose : camera.poses)
      if (images.numbers.count(pose.image) == 0)
        images.Put(pose.image, are_numbers
                                   ? *ParseImageNumber(pose.image)
                                   : static_cast<int>(images.names.size()));
  return images;
}

std::string FormatRigPoses(const std::vector<OutputCamera>& cameras,
                           const std::string& dataset_path,
                           const PuzzlepaintDataset* dataset) {
  const NumberedImages images = NumberImages(cameras, dataset);
  PuzzlepaintPoses poses;
  std::map<int, std::string> names;
  poses.count = static_cast<int>(images.names.size());
  for (const OutputCamera& camera : cameras)
    for (const BoardPose& pose : camera.poses) {
      const auto number = images.numbers.find(pose.image);
      if (number == images.numbers.end())
        throw InputError(
            fmt::format("--poses: image '{}' is not in {}; use another folder, "
                        "or export the features there first",
                        Printable(pose.image), dataset_path));
      poses.poses.emplace(number->second,
                          camera.camera_from_rig.value_or(Pose{}).Inverse() *
                              pose.camera_from_board);
      names[number->second] = pose.image;
    }
  return FormatPuzzlepaintPoses(poses, names);
}

std::string FormatCameraPoses(const std::vector<OutputCamera>& cameras) {
  PuzzlepaintPoses poses;
  std::map<int, std::string> names;
  for (const OutputCamera& camera : cameras) {
    const int index = poses.count++;
    poses.poses[index] = camera.camera_from_rig.value_or(Pose{});
    names[index] = camera.name;
  }
  if (cameras.size() == 1) names.clear();
  return FormatPuzzlepaintPoses(poses, names);
}

// Adds points.yaml with the lattice of the dataset's only board, whose frame is
// the world frame. The program requires this file; the file of an existing
// calibration is not overwritten.
void AddPoints(const std::string& path, const PuzzlepaintDataset& dataset,
               std::vector<CompanionFile>* files) {
  if (dataset.geometries.size() != 1) return;
  const PuzzlepaintGeometry& geometry = dataset.geometries.front();
  std::map<int, Eigen::Vector3d> points;
  for (const auto& [id, place] : geometry.places)
    points[id] = geometry.PointAt(place);
  files->push_back({path, FormatPuzzlepaintPoints(points), true});
}

}  // namespace

std::optional<int> ParseCameraFileIndex(const std::string& path) {
  const std::string stem = std::filesystem::path(path).stem().string();
  const size_t at = stem.find_first_of("0123456789");
  int index = 0;
  if (at == std::string::npos ||
      std::from_chars(stem.data() + at, stem.data() + stem.size(), index).ec !=
          std::errc() ||
      stem != PuzzlepaintCameraName(index))
    return std::nullopt;
  return index;
}

std::vector<std::string> ListStateFiles(const std::string& path) {
  std::vector<std::string> paths;
  if (!ParseCameraFileIndex(path)) return paths;
  for (const char* name : kStateFiles)
    paths.push_back(
        std::filesystem::path(path).replace_filename(name).string());
  return paths;
}

std::string MakeStateFilePath(const std::string& folder, int camera) {
  return (std::filesystem::path(folder) /
          (PuzzlepaintCameraName(camera) + ".yaml"))
      .string();
}

void ReadCameraState(const ReadRequest& request, InputCamera* camera,
                     std::vector<std::string>* warnings) {
  const std::optional<int> number = ParseCameraFileIndex(request.path);
  if (!number) return;
  const int index = *number;
  const PuzzlepaintState state = ReadState(request.path, request.beside);
  if (state.dataset && HasCamera(*state.dataset, index))
    camera->features = GetCameraFeatures(*state.dataset, index);
  if (!state.camera_from_rig) {
    if (state.rig_from_world)
      warnings->push_back(
          "rig_tr_global.yaml is ignored without camera_tr_rig.yaml");
    return;
  }
  const auto own = state.camera_from_rig->poses.find(index);
  if (own == state.camera_from_rig->poses.end()) {
    warnings->push_back(
        fmt::format("missing pose of camera {} in camera_tr_rig.yaml", index));
    return;
  }
  camera->camera_from_rig = own->second;
  if (!state.rig_from_world) return;
  if (state.dataset && !MatchesCamera(state, index))
    warnings->push_back(
        "dataset.bin does not match the poses; images are named by number");
  if (state.dataset && state.dataset->geometries.size() > 1 &&
      state.points.empty())
    warnings->push_back(
        "several boards but no points.yaml: assuming poses of board 0");
  camera->poses = ListCameraPoses(state, index, own->second);
}

std::vector<CompanionFile> WriteState(const std::string& path,
                                      const std::vector<OutputCamera>& cameras,
                                      const std::vector<std::string>& beside) {
  RequireOneBoard("puzzlepaint", cameras);
  const std::vector<std::string> paths = ListStateFiles(path);
  std::vector<CompanionFile> files = {{paths[0], FormatCameraPoses(cameras)}};
  const bool has_poses =
      std::any_of(cameras.begin(), cameras.end(),
                  [](const OutputCamera& lens) { return !lens.poses.empty(); });
  if (!has_poses) return files;
  std::optional<PuzzlepaintDataset> dataset;
  if (beside.size() > 2 && !beside[2].empty())
    dataset = ReadNamingFile(
        paths[2], [&] { return DecodePuzzlepaintDataset(beside[2]); });
  files.push_back({paths[1], FormatRigPoses(cameras, paths[2],
                                            dataset ? &*dataset : nullptr)});
  if (dataset) AddPoints(paths[3], *dataset, &files);
  return files;
}

}  // namespace raygrid
