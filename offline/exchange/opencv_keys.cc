#include "exchange/opencv_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <tuple>

#include "dataset/error.h"
#include "exchange/file_storage.h"
#include "exchange/keyed_table.h"
#include "exchange/opencv_model_list.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace opencv_file {

const KeyList kMatrixKeys = SplitText(
    "camera_matrix|cameraMatrix|Camera_Matrix|CameraMatrix|camera matrix|"
    "cam_matrix|camMatrix|cam_K|CameraMat|camera_intrinsics|camera_intrinsic|"
    "intrinsic_matrix|intrinsicMatrix|IntrinsicMatrix|intrinsics_matrix|"
    "intrinsic|intrinsics|K|mtx|matrix|M",
    '|');
const KeyList kDistortionKeys = SplitText(
    "distortion_coefficients|Distortion_Coefficients|distortion_coefficient|"
    "distortionCoefficients|distortion coefficients|distortion_coeffs|"
    "distortion_coeff|distCoeffs|DistCoeffs|distCoeff|dist_coeffs|dist_coeff|"
    "dist_coefs|dist_coef|distCoef|DistCoeff|cam_dist|camera_dist_coeffs|"
    "distortions|distortion|distortion_vector|camera_distortion|coeffs|dist|D",
    '|');
static const KeyList kSizeKeys = SplitText(
    "cameraResolution|ImageSize|image_size|imageSize|img_shape|img_size|"
    "resolution|size|image_shape|DIM|dim|frame_size|frameSize|"
    "image_dimensions",
    '|');
// The number of rows is first, as in the shape of numpy images.
static const KeyList kShapeKeys = {"shape"};
static const KeyList kWidthKeys = SplitText(
    "image_width|Camera.width|img_dist_w|image_Width|imageWidth|img_width|"
    "width|w|cols",
    '|');
static const KeyList kHeightKeys = SplitText(
    "image_height|Camera.height|img_dist_h|image_Height|imageHeight|"
    "img_height|height|h|rows",
    '|');
const KeyList kNameKeys = {"camera_name", "cameraName", "name", "camera_id"};
const KeyList kModelKeys = SplitText(
    "distortion_model|distortionModel|dist_model|DistModel|camera_model|"
    "cameraModel|lens_model|model_type|camera_type|model|projection|"
    "projection_model|distortion_type|lens_type|type",
    '|');
const KeyList kFisheyeKeys = {"fisheye_model", "is_fisheye", "isFisheye",
                              "use_fisheye", "fisheye"};
// Keys in calibrations of OpenCV and its users that are not intrinsics.
const KeyList kOtherKeys = SplitText(
    "nr_of_frames|nframes|nFrames|n_frames|num_images|framesCount|"
    "calibration*|board*|square*|flag*|fix_aspect_ratio|FixAspectRatio|"
    "nrOfFrames|aspectRatio|avg_reprojection_error|Avg_*|avg_*|per_view*|"
    "Per_View*|perView*|std*|Std*|ret|rms*|RMS*|error*|reproj*|"
    "ReprojectionError|mean_*|rvec*|tvec*|extrinsic_parameters|"
    "Extrinsic_Parameters|grid_points|image_points|Image_points|image_names|"
    "Image_names|board_ids|raygrid_fit|cameraMatrix_std*|dist_coeffs_std*|"
    "distCoeffs_std*|dispCoeffs_std*|new_camera_matrix|newcameramtx|optimal*|"
    "roi*|date|time*|serial|pattern*|fps|R1|R2|P1|P2|Q|E|F|valid*|version|"
    "Version|R|T|Rot|Trns|rotation_vector*|translation_vector*",
    '|');

// alpha may be the parameter of getOptimalNewCameraMatrix() or of a camera
// model.
const KeyList kVagueKeys = {"alpha"};

namespace {

const std::vector<std::array<Affixes, 2>> kPairs = [] {
  std::vector<std::array<Affixes, 2>> pairs;
  for (const auto& [first, second, names] :
       {std::tuple("0", "1", "camera0 camera1"),
        {"_0", "_1", "camera0 camera1"},
        {"1", "2", "camera1 camera2"},
        {"_1", "_2", "camera1 camera2"},
        {"_left", "_right", "left right"},
        {"Left", "Right", "left right"},
        {"L", "R", "left right"},
        {"_l", "_r", "left right"},
        {"_L", "_R", "left right"}}) {
    const std::string both = names;
    const size_t space = both.find(' ');
    pairs.push_back({{{"", first, both.substr(0, space)},
                      {"", second, both.substr(space + 1)}}});
  }
  for (const auto& [first, second] : {std::pair("left_", "right_"),
                                      {"left", "right"},
                                      {"Left", "Right"},
                                      {"LEFT.", "RIGHT."},
                                      {"L_", "R_"},
                                      {"l_", "r_"}})
    pairs.push_back({{{first, "", "left"}, {second, "", "right"}}});
  return pairs;
}();

}  // namespace

std::string FindKey(const CameraKeys& keys, const KeyList& names,
                    const Affixes& affixes) {
  for (const std::string& name : names)
    if (const std::string key = affixes.prefix + name + affixes.suffix;
        keys.Has(key))
      return key;
  return "";
}

std::string GetKeyText(const CameraKeys& keys, const KeyList& names) {
  const std::string key = FindKey(keys, names);
  return key.empty() ? "" : keys[key].IsScalar() ? keys.Word(key) : "";
}

namespace {

// fx, fy, cx and cy as separate numbers, which RealSense also uses.
const std::array<KeyList, 4> kScalarKeys = {
    {{"fx"}, {"fy"}, {"cx", "ppx"}, {"cy", "ppy"}}};

// A mapping without data is not a matrix but a mapping of the camera.
std::string FindMatrix(const CameraKeys& keys, const Affixes& affixes) {
  const std::string key = FindKey(keys, kMatrixKeys, affixes);
  return key.empty() || keys.IsMatrix(key) ? key : "";
}

}  // namespace

bool HasMatrix(const CameraKeys& keys, const Affixes& affixes) {
  if (!FindMatrix(keys, affixes).empty()) return true;
  return std::all_of(kScalarKeys.begin(), kScalarKeys.end(),
                     [&](const KeyList& names) {
                       return !FindKey(keys, names, affixes).empty();
                     });
}

namespace {

// Reads [width, height], {width: , height: }, or 640x480.
ImageSize SizeFrom(const YAML::Node& node, const std::string& name) {
  if (node.IsMap() && node["width"].IsDefined() && node["height"].IsDefined())
    return {SidePx(node["width"], name), SidePx(node["height"], name)};
  if (node.IsScalar()) {
    const std::string text = node.Scalar();
    const size_t x = text.find('x');
    if (x != std::string::npos)
      return {SidePx(YAML::Node(text.substr(0, x)), name),
              SidePx(YAML::Node(text.substr(x + 1)), name)};
  }
  return GetListSize(node, name);
}

}  // namespace

ImageSize ReadImageSize(const CameraKeys& keys, const Affixes& affixes) {
  for (const Affixes& own : {affixes, Affixes{}}) {
    const std::string width = FindKey(keys, kWidthKeys, own),
                      height = FindKey(keys, kHeightKeys, own),
                      size = FindKey(keys, kSizeKeys, own),
                      shape = FindKey(keys, kShapeKeys, own);
    if (!width.empty() && !height.empty())
      return {SidePx(keys[width], width), SidePx(keys[height], height)};
    if (!size.empty()) return SizeFrom(keys[size], size);
    if (!shape.empty()) {
      const YAML::Node sides = keys[shape];
      if (!sides.IsSequence() || sides.size() < 2)
        throw InputError(fmt::format("{}: expected height and width", shape));
      return {SidePx(sides[1], shape), SidePx(sides[0], shape)};
    }
  }
  return {};
}

void ReadIntrinsics(const CameraKeys& keys, const Affixes& affixes,
                    ConvertedCamera* lens) {
  const std::string key = FindMatrix(keys, affixes);
  if (!key.empty()) {
    const std::vector<double> k = ParseStoredMatrix(keys[key], key).data;
    if (k.size() == 4)
      lens->values = k;  // fx, fy, cx, cy
    else
      ReadCameraMatrix(k, key, lens);
    return;
  }
  for (const KeyList& names : kScalarKeys) {
    const std::string scalar = FindKey(keys, names, affixes);
    if (scalar.empty())
      throw InputError("contains no camera: 'camera_matrix' is missing");
    lens->values.push_back(FiniteNumber(keys[scalar], scalar));
  }
}

namespace {

// Reads k1, k2, p1, p2, k3 etc. stored as separate numbers; missing ones are 0.
// k1 to k4 without others are fisheye coefficients.
DistortionCoefficients ScalarCoefficients(const CameraKeys& keys,
                                          const Affixes& affixes) {
  const auto has = [&](const std::string& name) {
    return keys.Has(affixes.prefix + name + affixes.suffix);
  };
  const auto all = [&](const std::vector<std::string>& names) {
    std::vector<double> numbers;
    for (const std::string& name : names) {
      const std::string key = affixes.prefix + name + affixes.suffix;
      numbers.push_back(has(name) ? FiniteNumber(keys[key], key) : 0);
    }
    return numbers;
  };
  if (has("k4") && !has("k5") && !has("p1") && !has("p2"))
    return {all({"k1", "k2", "k3", "k4"}), false, true};
  if (has("k4")) return {all({"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"})};
  return {all({"k1", "k2", "p1", "p2", "k3"})};
}

}  // namespace

bool HasCoefficients(const CameraKeys& keys, const Affixes& affixes) {
  return !FindKey(keys, kDistortionKeys, affixes).empty() ||
         keys.Has(affixes.prefix + "k1" + affixes.suffix);
}

DistortionCoefficients Coefficients(const CameraKeys& keys,
                                    const Affixes& affixes) {
  const std::string key = FindKey(keys, kDistortionKeys, affixes);
  if (key.empty() && HasCoefficients(keys, affixes))
    return ScalarCoefficients(keys, affixes);
  if (key.empty())
    throw InputError(
        "'distortion_coefficients' is missing; use 5 zeros for no distortion");
  const YAML::Node node = keys[key];
  if (node.IsNull()) return {};
  const StoredMatrix matrix = ParseStoredMatrix(node, key);
  if (std::min(matrix.rows, matrix.columns) > 1)
    throw InputError(fmt::format("{}: expected a row or column vector", key));
  return {matrix.data, matrix.rows == 4 && matrix.columns == 1};
}

std::vector<Affixes> FindCameraAffixes(const CameraKeys& keys) {
  std::vector<Affixes> found;
  const auto add = [&](const Affixes& affixes) {
    if (HasMatrix(keys, affixes)) found.push_back(affixes);
    return !found.empty() && found.back().camera == affixes.camera;
  };
  // EasyMocap lists the suffixes of its keys.
  if (keys.Has("names") && keys["names"].IsSequence())
    for (const YAML::Node& name : keys["names"])
      if (name.IsScalar())
        add({"", "_" + name.as<std::string>(), name.as<std::string>()});
  if (!found.empty()) return found;
  for (const auto& pair : kPairs) {
    if (!HasMatrix(keys, pair[0]) || !HasMatrix(keys, pair[1])) continue;
    found.assign(pair.begin(), pair.end());
    // Further cameras with consecutive numbers.
    const std::string& last = pair[1].suffix;
    for (int number = 2; !last.empty() && std::isdigit(last.back()); ++number)
      if (number > last.back() - '0' &&
          !add({"", last.substr(0, last.size() - 1) + std::to_string(number),
                fmt::format("camera{}", number)}))
        break;
    return found;
  }
  return found;
}

}  // namespace opencv_file
}  // namespace raygrid
