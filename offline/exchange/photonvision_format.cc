#include "exchange/photonvision_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/count_text.h"
#include "exchange/opencv_model_list.h"
#include "exchange/raygrid_json.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kPhotonMatrix[] = "cameraIntrinsics";
constexpr char kPhotonSize[] = "resolution";
// Before 2024, files use the wrong key for the distortion coefficients.
constexpr const char* kPhotonDistortion[] = {"distCoeffs", "cameraExtrinsics"};
constexpr char kLensModel[] = "lensmodel";
constexpr char kOpenCvLens[] = "LENSMODEL_OPENCV";
constexpr char kCalibrations[] = "calibrations";
constexpr char kObservations[] = "observations";
constexpr char kObjectPoints[] = "locationInObjectSpace";
constexpr char kImagePoints[] = "locationInImageSpace";
constexpr char kSpacing[] = "calobjectSpacing";
constexpr int kFloat64 = 6;  // OpenCV's CV_64F
constexpr int kMaxCornerIndex = 1000;

const std::vector<ExternalModel>& GetPhotonVisionModels() {
  static const std::vector<ExternalModel> external_models = {
      MakeOpenCvModel("opencv5", 5), MakeOpenCvModel("opencv8", 8)};
  return external_models;
}

// ---- JSON ------------------------------------------------------------------

// Parses a file without its snapshot images, which account for most of its
// size.
Json ParsePhotonJson(const std::string& text) {
  const auto keeps = [](int, Json::parse_event_t event, Json& parsed) {
    return event != Json::parse_event_t::key || parsed != "snapshotData";
  };
  constexpr size_t kMaxBytesWithImages = 1 << 30;
  RequireSmallTree("", text, kYamlStructureCharacters, kMaxBytesWithImages);
  try {
    return Json::parse(text, keeps);
  } catch (const Json::parse_error& error) {
    throw InputError(fmt::format("invalid JSON at byte {}", error.byte));
  } catch (const Json::out_of_range&) {
    throw InputError("number too large");
  }
}

// Returns the value of a key; null if missing.
const Json& GetJsonValue(const Json& map, const std::string& key) {
  static const Json none;
  const auto found = map.is_object() ? map.find(key) : map.end();
  return found == map.end() ? none : *found;
}

double FiniteJson(const Json& node, const std::string& name) {
  if (!node.is_number() || !std::isfinite(node.get<double>()))
    throw InputError(fmt::format("{}: expected a finite number", name));
  return node.get<double>();
}

const Json& GetJsonList(const Json& map, const std::string& key) {
  const Json& list = GetJsonValue(map, key);
  if (!list.is_array())
    throw InputError(fmt::format("{}: expected a list", key));
  return list;
}

// ---- The camera ------------------------------------------------------------

int PhotonSidePx(const Json& root, const char* key) {
  const std::string name = fmt::format("{}.{}", kPhotonSize, key);
  const double side =
      FiniteJson(GetJsonValue(GetJsonValue(root, kPhotonSize), key), name);
  if (!(side >= 1 && side <= 1e6) || side != std::floor(side))
    throw InputError(fmt::format("{}: invalid image size", name));
  return static_cast<int>(side);
}

std::vector<double> PhotonNumbers(const Json& root, const std::string& key) {
  std::vector<double> numbers;
  for (const Json& number : GetJsonList(GetJsonValue(root, key), "data"))
    numbers.push_back(FiniteJson(number, key + ".data"));
  return numbers;
}

std::vector<double> PhotonCoefficients(const Json& root) {
  for (const char* key : kPhotonDistortion)
    if (!GetJsonValue(root, key).is_null()) return PhotonNumbers(root, key);
  throw InputError(fmt::format("'{}' is missing", kPhotonDistortion[0]));
}

void RequireOpenCvModel(const Json& root) {
  const Json& model = GetJsonValue(root, kLensModel);
  if (model.is_null() || model == kOpenCvLens) return;
  throw InputError(
      fmt::format("{}: unsupported model '{}'; supported is {}", kLensModel,
                  model.is_string() ? Printable(model.get<std::string>()) : "",
                  kOpenCvLens));
}

ConvertedCamera ReadPhotonIntrinsics(const Json& root) {
  RequireOpenCvModel(root);
  ConvertedCamera lens;
  lens.size = {PhotonSidePx(root, "width"), PhotonSidePx(root, "height")};
  ReadCameraMatrix(PhotonNumbers(root, kPhotonMatrix), kPhotonMatrix, &lens);
  std::vector<double> coefficients = PhotonCoefficients(root);
  if (coefficients.size() == 4) coefficients.push_back(0);
  if (coefficients.size() != 5 && coefficients.size() != 8)
    throw InputError(fmt::format("{} distortion coefficients, expected 5 or 8",
                                 coefficients.size()));
  lens.external_model = &GetPhotonVisionModels()[coefficients.size() == 8];
  lens.values.insert(lens.values.end(), coefficients.begin(),
                     coefficients.end());
  return lens;
}

// Warns about unknown keys, which newer versions may add.
void WarnAboutUnknownPhotonKeys(Json root, const ExternalModel& external_model,
                                std::vector<std::string>* warnings) {
  root.erase(kObservations);
  const CameraKeys keys(YAML::Load(root.dump()));
  keys.Skip({kPhotonSize, kPhotonMatrix, kPhotonDistortion[0],
             kPhotonDistortion[1], kLensModel, kSpacing, kRaygridKey,
             "calobjectWarp", "calobjectSize", "perViewErrors",
             "standardDeviation"});
  keys.Finish(external_model, warnings);
}

// ---- Corners ---------------------------------------------------------------

struct PhotonCorner {
  Eigen::Vector2d on_board, pixel;
};

struct PhotonView {
  std::string image;
  std::vector<PhotonCorner> corners;  // used by PhotonVision's calibration
  std::optional<Pose> camera_from_board;
  Eigen::Vector2d min_position_m;  // smallest coordinates of object points;
                                   // infinite if there are none
};

struct PhotonCounts {
  size_t left_out = 0, skipped = 0;
};

Eigen::Vector2d GetPlanePoint(const Json& point, const char* list) {
  return {FiniteJson(GetJsonValue(point, "x"), fmt::format("{}: x", list)),
          FiniteJson(GetJsonValue(point, "y"), fmt::format("{}: y", list))};
}

// Whether the solver used a corner; older files do not store this.
bool IsUsed(const Json& view, size_t corner) {
  const Json& used = GetJsonValue(view, "cornersUsed");
  return !used.is_array() || corner >= used.size() || used[corner] != false;
}

// Returns the detected corners. Undetected ones are at (-1, -1) both on the
// board and in the image.
std::vector<PhotonCorner> ReadCorners(const Json& view, PhotonCounts* counts) {
  const Json &places = GetJsonList(view, kObjectPoints),
             &pixels = GetJsonList(view, kImagePoints);
  if (places.size() != pixels.size())
    throw InputError(fmt::format("{} has {} points, but {} has {}",
                                 kObjectPoints, places.size(), kImagePoints,
                                 pixels.size()));
  std::vector<PhotonCorner> corners;
  for (size_t k = 0; k < pixels.size(); ++k) {
    const Eigen::Vector2d pixel = GetPlanePoint(pixels[k], kImagePoints);
    if (pixel.minCoeff() < 0) continue;
    if (!IsUsed(view, k)) {
      ++counts->left_out;
      continue;
    }
    corners.push_back({GetPlanePoint(places[k], kObjectPoints), pixel});
  }
  return corners;
}

// Returns the smallest coordinates of object points. Undetected corners also
// have their positions, except on ChArUco boards.
Eigen::Vector2d ComputeMinPosition(const Json& view) {
  Eigen::Vector2d min_position(INFINITY, INFINITY);
  for (const Json& point : GetJsonList(view, kObjectPoints)) {
    const Eigen::Vector2d place = GetPlanePoint(point, kObjectPoints);
    if (place.minCoeff() >= 0) min_position = min_position.cwiseMin(place);
  }
  return min_position;
}

// Returns nullopt if the solver provided no pose.
std::optional<Pose> PhotonPose(const Json& pose) {
  const Json& t = GetJsonValue(pose, "translation");
  const Json& q = GetJsonValue(GetJsonValue(pose, "rotation"), "quaternion");
  if (!t.is_object() || !q.is_object()) return std::nullopt;
  std::array<double, 7> numbers;
  for (int k = 0; k < 4; ++k)
    numbers[k] =
        FiniteJson(GetJsonValue(q, std::string(1, "WXYZ"[k])), "quaternion");
  for (int k = 0; k < 3; ++k)
    numbers[4 + k] =
        FiniteJson(GetJsonValue(t, std::string(1, "xyz"[k])), "translation");
  if (numbers[4] == 0 && numbers[5] == 0 && numbers[6] == 0)
    return std::nullopt;
  return PoseFromQuaternion(numbers);
}

PhotonView ReadPhotonView(const Json& view, size_t index,
                          PhotonCounts* counts) {
  const Json& name = GetJsonValue(view, "snapshotName");
  const std::string image = name.is_string() ? name.get<std::string>() : "";
  return {image.empty() ? fmt::format("view{:04}", index) : image,
          ReadCorners(view, counts),
          PhotonPose(GetJsonValue(view, "optimisedCameraToObject")),
          ComputeMinPosition(view)};
}

std::vector<PhotonView> ReadPhotonViews(const Json& root,
                                        PhotonCounts* counts) {
  std::vector<PhotonView> views;
  if (GetJsonValue(root, kObservations).is_null()) return views;
  const Json& list = GetJsonList(root, kObservations);
  for (size_t k = 0; k < list.size(); ++k) {
    if (GetJsonValue(list[k], "includeObservationInCalibration") == false) {
      ++counts->skipped;
      continue;
    }
    try {
      views.push_back(ReadPhotonView(list[k], k, counts));
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("{}[{}]: {}", kObservations, k, error.what()));
    }
  }
  return views;
}

// Returns the corner spacing in metres. Older files do not state it: it is then
// the smallest distance between the first corner of a view and another along
// one axis.
double EstimateSpacing(const Json& root, const std::vector<PhotonView>& views) {
  const Json& configuration = GetJsonValue(root, kSpacing);
  double spacing =
      configuration.is_null() ? 0 : FiniteJson(configuration, kSpacing);
  if (spacing != 0) return std::abs(spacing);
  spacing = INFINITY;
  for (const PhotonView& view : views)
    for (const PhotonCorner& corner : view.corners)
      for (const double step : corner.on_board - view.corners[0].on_board)
        if (std::abs(step) > 1e-6) spacing = std::min(spacing, std::abs(step));
  return spacing;
}

// Returns the 0-based column and row of a corner relative to the board's
// origin.
Eigen::Vector2i ComputeGridPosition(const PhotonCorner& corner,
                                    double spacing) {
  constexpr double kMaxGridDeviation = 0.02;
  const Eigen::Vector2d exact = corner.on_board / spacing;
  const Eigen::Vector2d rounded = exact.array().round();
  if (!((exact - rounded).cwiseAbs().maxCoeff() < kMaxGridDeviation) ||
      !(rounded.cwiseAbs().maxCoeff() <= kMaxCornerIndex))
    throw InputError(
        fmt::format("{}: ({:g}, {:g}) is not a corner of a board with {} {:g}",
                    kObjectPoints, corner.on_board.x(), corner.on_board.y(),
                    kSpacing, spacing));
  return rounded.cast<int>();
}

// Returns the position of the first corner: on ChArUco boards, it is one square
// from the board's origin.
Eigen::Vector2i FindFirstPosition(const std::vector<PhotonView>& views,
                                  double spacing) {
  Eigen::Vector2d min_position(INFINITY, INFINITY);
  for (const PhotonView& view : views)
    min_position = min_position.cwiseMin(view.min_position_m);
  const bool is_charuco =
      min_position.allFinite() && min_position.minCoeff() > 0.5 * spacing;
  return is_charuco ? Eigen::Vector2i(1, 1) : Eigen::Vector2i(0, 0);
}

void RequireDistinct(const std::vector<Feature>& features,
                     const std::string& image) {
  std::set<std::pair<int, int>> places;
  for (const Feature& feature : features)
    if (std::min(feature.column, feature.row) < 0 ||
        !places.insert({feature.column, feature.row}).second)
      throw InputError(fmt::format(
          "{} of '{}': corner ({}, {}) is a duplicate or not on the board",
          kObservations, Printable(image), feature.column, feature.row));
}

void AddPhotonViews(const Json& root, ExchangeContents* contents) {
  PhotonCounts counts;
  const std::vector<PhotonView> views = ReadPhotonViews(root, &counts);
  const double spacing = EstimateSpacing(root, views);
  const Eigen::Vector2i first = FindFirstPosition(views, spacing);
  InputCamera& camera = contents->cameras.back();
  for (const PhotonView& view : views) {
    ImageFeatures image = {view.image, {}};
    for (const PhotonCorner& corner : view.corners) {
      const Eigen::Vector2i place =
          ComputeGridPosition(corner, spacing) - first;
      image.features.push_back({0, place.x(), place.y(),
                                FromProgram(PixelOrigin::kFirstPixelCenter,
                                            camera.lens.size, corner.pixel)});
    }
    RequireDistinct(image.features, image.image);
    if (!image.features.empty()) camera.features.push_back(std::move(image));
    if (view.camera_from_board && first.isZero())
      camera.poses.push_back({view.image, 0, *view.camera_from_board});
  }
  const auto warning = [&](size_t count, const char* what) {
    if (count > 0)
      contents->warnings.push_back(fmt::format(
          "ignored {} that its solver had rejected", CountText(count, what)));
  };
  warning(counts.left_out, "corner");
  warning(counts.skipped, "image");
  if (!first.isZero())
    contents->warnings.push_back(
        "board poses are ignored: PhotonVision's board origin is one square "
        "from the first corner");
}

void ReadPhotonCamera(const Json& root, ExchangeContents* contents) {
  InputCamera& camera = contents->cameras.emplace_back();
  camera.lens = ReadPhotonIntrinsics(root);
  WarnAboutUnknownPhotonKeys(root, *camera.lens.external_model,
                             &contents->warnings);
  ParseRaygridJson(YAML::Load(GetJsonValue(root, kRaygridKey).dump()), &camera);
  AddPhotonViews(root, contents);
}

// Reads a calibration, or camera settings with one calibration per resolution.
ExchangeContents ReadPhotonVision(const ReadRequest& request) {
  const Json root = ParsePhotonJson(request.text);
  ExchangeContents contents;
  if (GetJsonValue(root, kCalibrations).is_null()) {
    ReadPhotonCamera(root, &contents);
    return contents;
  }
  for (const Json& calibration : GetJsonList(root, kCalibrations)) {
    ReadPhotonCamera(calibration, &contents);
    const ImageSize& size = contents.cameras.back().lens.size;
    contents.cameras.back().name =
        fmt::format("{}x{}", size.width, size.height);
  }
  if (contents.cameras.empty())
    throw InputError(fmt::format("{}: contains no camera", kCalibrations));
  return contents;
}

// ---- Writing ---------------------------------------------------------------

Json PhotonMatrix(int rows, const std::vector<double>& data) {
  return {{"rows", rows},
          {"cols", data.size() / rows},
          {"type", kFloat64},
          {"data", data}};
}

std::string WritePhotonVision(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const ConvertedCamera& lens = camera.lens;
  const Json root = {
      {kPhotonSize,
       {{"width", double(lens.size.width)},
        {"height", double(lens.size.height)}}},
      {kPhotonMatrix,
       PhotonMatrix(3, {lens.Value("fx"), 0, lens.Value("cx"), 0,
                        lens.Value("fy"), lens.Value("cy"), 0, 0, 1})},
      {kPhotonDistortion[0], PhotonMatrix(1, lens.ValuesFrom(4))},
      {"calobjectWarp", {0.0, 0.0}},
      {kObservations, Json::array()},
      {"calobjectSize", {{"width", 0.0}, {"height", 0.0}}},
      {kSpacing, 0.0},
      {kLensModel, kOpenCvLens},
      {kRaygridKey, MakeRaygridJson(camera)}};
  return root.dump(2) + "\n";
}

}  // namespace

bool IsPhotonVision(const std::string& text) {
  for (const char* key : {kPhotonMatrix, kPhotonSize})
    if (text.find(fmt::format("\"{}\"", key)) == std::string::npos)
      return false;
  return text.find_first_not_of(" \t\r\n") == text.find('{');
}

Format MakePhotonVisionFormat() {
  Format format;
  format.name = "photonvision";
  format.holds =
      "calibration .json: pinhole with 5 or 8 OpenCV coefficients; one file "
      "per camera of a rig; corners and poses of boards are imported";
  format.external_models = GetPhotonVisionModels();
  format.ending = ".json";
  format.discards_rig_poses = true;
  format.recognizes = IsPhotonVision;
  format.read = ReadPhotonVision;
  format.write = WritePhotonVision;
  return format;
}

}  // namespace raygrid
