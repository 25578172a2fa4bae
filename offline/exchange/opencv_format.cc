#include "exchange/opencv_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <tuple>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/file_storage.h"
#include "exchange/npz.h"
#include "exchange/opencv_forms.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kFisheye[] = "fisheye", kOmnidir[] = "omnidir";

// OpenCV's omnidir: k1, k2, p1, p2, and xi, which stands in a key of its own.
LensForm OmnidirForm() {
  LensForm form =
      FormOf(kOmnidir, "omni-radtan", {"k1", "k2", "p1", "p2", "xi"});
  form.is_only_asked = true;
  return form;
}

const std::vector<LensForm>& OpenCvForms() {
  static const std::vector<LensForm> forms = {OpenCvForm("opencv4", 4),
                                              OpenCvForm("opencv5", 5),
                                              OpenCvForm("opencv8", 8),
                                              OpenCvForm("opencv12", 12),
                                              OpenCvForm("opencv14", 14),
                                              OpenCvFisheyeForm(kFisheye),
                                              OmnidirForm()};
  return forms;
}

// The names that OpenCV's programs, and their users, give to one thing.
using KeyList = std::vector<std::string>;
const KeyList kMatrixKeys = {"camera_matrix",
                             "cameraMatrix",
                             "Camera_Matrix",
                             "CameraMatrix",
                             "camera matrix",
                             "cam_matrix",
                             "camMatrix",
                             "intrinsic_matrix",
                             "intrinsicMatrix",
                             "IntrinsicMatrix",
                             "intrinsics_matrix",
                             "intrinsic",
                             "intrinsics",
                             "K",
                             "mtx",
                             "matrix",
                             "M"};
const KeyList kDistortionKeys = {"distortion_coefficients",
                                 "Distortion_Coefficients",
                                 "distortion_coefficient",
                                 "distortionCoefficients",
                                 "distortion coefficients",
                                 "distortion_coeffs",
                                 "distortion_coeff",
                                 "distCoeffs",
                                 "DistCoeffs",
                                 "distCoeff",
                                 "dist_coeffs",
                                 "dist_coeff",
                                 "dist_coefs",
                                 "distortions",
                                 "distortion",
                                 "distortion_vector",
                                 "coeffs",
                                 "dist",
                                 "D"};
const KeyList kSizeKeys = {
    "cameraResolution", "image_size", "imageSize", "img_shape",
    "img_size",         "resolution", "size",      "image_shape"};
// Rows come first there, as in the shape of numpy's images.
const KeyList kShapeKeys = {"shape"};
const KeyList kWidthKeys = {
    "image_width", "image_Width",      "imageWidth",       "img_width", "width",
    "w",           "resolution/width", "image_size/width", "cols"};
const KeyList kHeightKeys = {"image_height",
                             "image_Height",
                             "imageHeight",
                             "img_height",
                             "height",
                             "h",
                             "resolution/height",
                             "image_size/height",
                             "rows"};
constexpr char kPointsKey[] = "image_points";
const KeyList kNameKeys = {"camera_name", "cameraName", "name"};
const KeyList kModelKeys = {"distortion_model", "distortionModel", "dist_model",
                            "camera_model",     "cameraModel",     "lens_model",
                            "model_type",       "camera_type",     "model",
                            "projection"};
const KeyList kFisheyeKeys = {"fisheye_model", "is_fisheye", "isFisheye",
                              "use_fisheye", "fisheye"};
// Keys of OpenCV's and its users' calibrations that say nothing of the lens.
const KeyList kOtherKeys = {"nr_of_frames",
                            "nframes",
                            "nFrames",
                            "n_frames",
                            "num_images",
                            "framesCount",
                            "calibration*",
                            "board*",
                            "square*",
                            "flag*",
                            "fix_aspect_ratio",
                            "FixAspectRatio",
                            "nrOfFrames",
                            "aspectRatio",
                            "avg_reprojection_error",
                            "Avg_*",
                            "avg_*",
                            "per_view*",
                            "Per_View*",
                            "perView*",
                            "std*",
                            "Std*",
                            "ret",
                            "rms*",
                            "RMS*",
                            "error*",
                            "reproj*",
                            "mean_*",
                            "rvec*",
                            "tvec*",
                            "extrinsic_parameters",
                            "Extrinsic_Parameters",
                            "grid_points",
                            "image_points",
                            "Image_points",
                            "image_names",
                            "Image_names",
                            "board_ids",
                            "raygrid_fit",
                            "cameraMatrix_std*",
                            "dist_coeffs_std*",
                            "distCoeffs_std*",
                            "dispCoeffs_std*",
                            "new_camera_matrix",
                            "newcameramtx",
                            "optimal*",
                            "roi*",
                            "date",
                            "time*",
                            "serial",
                            "pattern*",
                            "fps",
                            "R1",
                            "R2",
                            "P1",
                            "P2",
                            "Q",
                            "E",
                            "F",
                            "valid*",
                            "version",
                            "Version",
                            "R",
                            "T",
                            "Rot",
                            "Trns",
                            "rotation_vector*",
                            "translation_vector*"};

// getOptimalNewCameraMatrix() has an alpha.
const KeyList kVagueKeys = {"alpha"};

// Texts before and behind the names of keys of one camera of a pair.
struct Affixes {
  std::string before, behind, camera;
};
const std::vector<std::array<Affixes, 2>> kPairs = [] {
  std::vector<std::array<Affixes, 2>> pairs;
  for (const auto& [first, second, names] :
       {std::tuple("1", "2", "camera1 camera2"),
        {"_1", "_2", "camera1 camera2"},
        {"0", "1", "camera0 camera1"},
        {"_0", "_1", "camera0 camera1"},
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

// The first of these keys that stands in a map, or "".
std::string FindKey(const CameraKeys& keys, const KeyList& names,
                    const Affixes& affixes = {}) {
  for (const std::string& name : names)
    if (const std::string key = affixes.before + name + affixes.behind;
        keys.Has(key))
      return key;
  return "";
}

std::string TextOf(const CameraKeys& keys, const KeyList& names) {
  const std::string key = FindKey(keys, names);
  return key.empty() ? "" : keys[key].IsScalar() ? keys.Word(key) : "";
}

// fx, fy, cx and cy as numbers of their own, as RealSense has them, too.
const std::array<KeyList, 4> kScalarKeys = {
    {{"fx"}, {"fy"}, {"cx", "ppx"}, {"cy", "ppy"}}};

// A map without data is no matrix: that of a camera in it.
std::string FindMatrix(const CameraKeys& keys, const Affixes& affixes = {}) {
  const std::string key = FindKey(keys, kMatrixKeys, affixes);
  return key.empty() || keys.IsMatrix(key) ? key : "";
}

bool HasMatrix(const CameraKeys& keys, const Affixes& affixes = {}) {
  if (!FindMatrix(keys, affixes).empty()) return true;
  return std::all_of(kScalarKeys.begin(), kScalarKeys.end(),
                     [&](const KeyList& names) {
                       return !FindKey(keys, names, affixes).empty();
                     });
}

ImageSize SizeInFile(const CameraKeys& keys, const Affixes& affixes) {
  for (const Affixes& own : {affixes, Affixes{}}) {
    const std::string width = FindKey(keys, kWidthKeys, own),
                      height = FindKey(keys, kHeightKeys, own),
                      size = FindKey(keys, kSizeKeys, own),
                      shape = FindKey(keys, kShapeKeys, own);
    if (!width.empty() && !height.empty())
      return {SidePx(keys[width], width), SidePx(keys[height], height)};
    if (!size.empty()) return SizeOfList(keys[size], size);
    if (!shape.empty()) {
      const YAML::Node sides = keys[shape];
      if (!sides.IsSequence() || sides.size() < 2)
        throw InputError(fmt::format("{}: not height and width", shape));
      return {SidePx(sides[1], shape), SidePx(sides[0], shape)};
    }
  }
  return {};
}

void TakeIntrinsics(const CameraKeys& keys, const Affixes& affixes,
                    LensInForm* lens) {
  const std::string key = FindMatrix(keys, affixes);
  if (!key.empty()) {
    TakeCameraMatrix(ParseStoredMatrix(keys[key], key).data, key, lens);
    return;
  }
  for (const KeyList& names : kScalarKeys) {
    const std::string scalar = FindKey(keys, names, affixes);
    if (scalar.empty())
      throw InputError("no camera: 'camera_matrix' is missing");
    lens->values.push_back(FiniteNumber(keys[scalar], scalar));
  }
}

// k1, k2, p1, p2, k3 and so on as numbers of their own; without p1 and p2 the
// next is k3, as of a fisheye.
std::vector<double> ScalarCoefficients(const CameraKeys& keys,
                                       const Affixes& affixes) {
  const bool is_tangential = keys.Has(affixes.before + "p1" + affixes.behind);
  std::vector<double> numbers;
  for (const char* name :
       is_tangential ? std::vector<const char*>{"k1", "k2", "p1", "p2", "k3",
                                                "k4", "k5", "k6"}
                     : std::vector<const char*>{"k1", "k2", "k3", "k4"}) {
    const std::string key = affixes.before + name + affixes.behind;
    if (!keys.Has(key)) break;
    numbers.push_back(FiniteNumber(keys[key], key));
  }
  return numbers;
}

// Whether coefficients stand in a column of Python's lists, as those of
// cv2.fisheye do and no others.
struct CoefficientsInFile {
  std::vector<double> numbers;
  bool is_fisheye_column = false;
};

CoefficientsInFile Coefficients(const CameraKeys& keys,
                                const Affixes& affixes) {
  const std::string key = FindKey(keys, kDistortionKeys, affixes);
  if (key.empty() && keys.Has(affixes.before + "k1" + affixes.behind))
    return {ScalarCoefficients(keys, affixes), false};
  if (key.empty())
    throw InputError(
        "'distortion_coefficients' is missing; write 5 zeros if "
        "there is no distortion");
  const YAML::Node node = keys[key];
  if (node.IsNull()) return {};
  const StoredMatrix matrix = ParseStoredMatrix(node, key);
  if (std::min(matrix.rows, matrix.columns) > 1)
    throw InputError(fmt::format("{}: neither a row nor a column", key));
  return {matrix.data,
          node.IsSequence() && matrix.rows == 4 && matrix.columns == 1};
}

const LensForm& FormNamed(const std::string& name) {
  for (const LensForm& form : OpenCvForms())
    if (form.name == name) return form;
  throw InputError(
      fmt::format("unknown distortion model '{}'; OpenCV's are "
                  "opencv4, opencv5, opencv8, opencv12, opencv14, "
                  "fisheye and omnidir",
                  Printable(name)));
}

// The form of so many coefficients.
const LensForm& FormOfCount(size_t count) {
  const std::map<size_t, const char*> names = {
      {0, "opencv4"}, {4, "opencv4"},   {5, "opencv5"},
      {8, "opencv8"}, {12, "opencv12"}, {14, "opencv14"}};
  const auto name = names.find(count);
  if (name == names.end())
    throw InputError(fmt::format(
        "{} distortion coefficients; OpenCV has 4, 5, 8, 12 or 14", count));
  return FormNamed(name->second);
}

// The model that a file says, and the key that says it.
struct SaidModel {
  LensFamily family = LensFamily::kPinhole;
  std::string key, word;
};

std::optional<SaidModel> ModelInFile(const CameraKeys& keys,
                                     const Affixes& affixes) {
  std::optional<SaidModel> said;
  const auto say = [&](LensFamily family, const std::string& key) {
    // A pinhole with a fisheye's distortion is a fisheye.
    const bool is_vague = said && said->word == "pinhole";
    if (said && !is_vague && said->family != family &&
        keys.Word(key) != "pinhole")
      throw InputError(fmt::format("'{}' says {}, and '{}' {}", said->key,
                                   TextOf(said->family), key, TextOf(family)));
    if (!said || is_vague) said = SaidModel{family, key, keys.Word(key)};
  };
  const std::string xi = affixes.before + "xi" + affixes.behind;
  if (keys.Has(xi)) say(LensFamily::kOmni, xi);
  for (const std::string& key : kFisheyeKeys) {
    const std::string word = Lowercase(keys.Word(key));
    if (word == "1" || word == "true" || word == "yes")
      say(LensFamily::kFisheye, key);
    else if (word == "0" || word == "false" || word == "no")
      say(LensFamily::kPinhole, key);
    else
      continue;
    keys.Skip({key});
  }
  for (const std::string& key : kModelKeys) {
    const auto family = FamilyOfWord(keys.Word(key));
    if (!family) continue;
    say(*family, key);
    keys.Skip({key});
  }
  return said;
}

// The form of what the file says, or else the user; or else of the number of
// coefficients.
const LensForm& FormSaid(const CameraKeys& keys, const Affixes& affixes,
                         const ReadRequest& request, double skew_px,
                         CoefficientsInFile* coefficients,
                         std::vector<std::string>* remarks) {
  std::vector<double>& d = coefficients->numbers;
  const auto said = ModelInFile(keys, affixes);
  bool is_fisheye = said && said->family == LensFamily::kFisheye;
  // RealSense says an inverse of distortion that it does not have.
  const bool is_nothing = std::all_of(
      d.begin(), d.end(), [](double number) { return number == 0; });
  if (said && said->family == LensFamily::kOther && !is_nothing)
    throw InputError(fmt::format(
        "'{}' is {}, which is none of OpenCV's: a pinhole, fisheye and omnidir",
        said->key, Printable(said->word)));
  if (said && said->family == LensFamily::kOmni) {
    if (!keys.Has(affixes.before + "xi" + affixes.behind))
      throw InputError("'xi' of the omnidirectional camera is missing");
    return FormNamed(kOmnidir);
  }
  const LensForm* const wanted =
      request.form.empty() ? nullptr : &FormNamed(request.form);
  if (said && wanted && (wanted->name == kFisheye) != is_fisheye)
    throw InputError(fmt::format(
        "--model {}: the file says its model itself, '{}' {}; leave the option "
        "out",
        request.form, said->key, Printable(said->word)));
  if (wanted && wanted->name != kFisheye) {
    TrimCoefficients(wanted->parameters.size() - 4, &d);
    if (d.size() + 4 != wanted->parameters.size())
      throw InputError(fmt::format(
          "--model {}: the file has {} distortion coefficients; leave the "
          "option out",
          request.form, d.size()));
  }
  is_fisheye = is_fisheye || (wanted && wanted->name == kFisheye);
  if (!said && !wanted && d.size() == 4) {
    is_fisheye = coefficients->is_fisheye_column || skew_px != 0;
    remarks->push_back(
        is_fisheye
            ? "its 4 coefficients are taken for k1, k2, k3, k4 of cv::fisheye, "
              "which writes such a column, or a skew; those of a pinhole are "
              "imported with --model opencv4"
            : "its 4 coefficients are taken for k1, k2, p1, p2 of a pinhole; "
              "those of cv::fisheye are imported with --model fisheye");
  }
  if (is_fisheye) {
    TrimCoefficients(4, &d);
    if (d.empty()) d.assign(4, 0);
    return FormNamed(kFisheye);
  }
  // OpenCV's 12 or 14 coefficients that are those of 8.
  if (d.size() > 8) TrimCoefficients(8, &d);
  if (d.size() > 5 && d.size() < 8) TrimCoefficients(5, &d);
  const LensForm& form = FormOfCount(d.size());
  if (d.empty()) d.assign(4, 0);
  return form;
}

// R and T of stereoCalibrate: the pose of the first camera's frame, or a rig's.
std::optional<Pose> PoseInFile(const CameraKeys& keys) {
  const std::string r_key = FindKey(keys, {"R", "Rot", "rotation_matrix"}),
                    t_key = FindKey(keys, {"T", "Trns", "translation_vector"});
  if (r_key.empty() || t_key.empty()) return std::nullopt;
  const StoredMatrix r = ParseStoredMatrix(keys[r_key], r_key),
                     t = ParseStoredMatrix(keys[t_key], t_key);
  if (r.rows != 3 || r.columns != 3 || t.data.size() != 3)
    throw InputError("R, T: not 3 x 3 and 3 x 1");
  std::vector<double> rows;
  for (int row = 0; row < 3; ++row) {
    rows.insert(rows.end(), r.data.begin() + 3 * row,
                r.data.begin() + 3 * row + 3);
    rows.push_back(t.data[row]);
  }
  return PoseOfMatrix(rows, "R");
}

// The name of an image, which OpenCV's samples do not store.
std::string ImageName(const YAML::Node& names, int index) {
  if (names.IsDefined() && names.IsSequence() &&
      index < static_cast<int>(names.size()) && names[index].IsScalar())
    return names[index].as<std::string>();
  return fmt::format("view{:04}", index);
}

// The board that the file tells, or else the user. The message of an error
// begins with image_points.
ImageSize BoardOf(const YAML::Node& root, const ReadRequest& request,
                  int num_points) {
  ImageSize board = request.board.value_or(ImageSize{0, 0});
  if (root["board_width"]) {
    const int width = SidePx(root["board_width"], "board_width");
    const int height = root["board_height"]
                           ? SidePx(root["board_height"], "board_height")
                           : num_points / width;
    if (request.board && *request.board != ImageSize{width, height})
      throw InputError(
          fmt::format("image_points: its board is {} x {}, not that of --board",
                      width, height));
    board = {width, height};
  }
  if (board.width == 0)
    throw InputError(
        "image_points: 'board_width' is missing; import them with --board "
        "COLUMNSxROWS, counting corners, as --board 9x6");
  if (int64_t{board.width} * board.height != num_points)
    throw InputError(fmt::format(
        "image_points: {} corners of an image, while its board has {} x {}",
        num_points, board.width, board.height));
  return board;
}

// image_points of OpenCV's calibration sample: a row of corners an image, in
// the order of a board of board_width columns.
std::vector<ImageFeatures> FeaturesOf(const YAML::Node& root,
                                      const StoredMatrix& points,
                                      const ImageSize& board) {
  std::vector<ImageFeatures> images;
  for (int row = 0; row < points.rows; ++row) {
    ImageFeatures& image = images.emplace_back();
    image.image = ImageName(root["image_names"], row);
    for (int k = 0; k < points.columns; ++k) {
      const size_t at = 2 * (static_cast<size_t>(row) * points.columns + k);
      image.features.push_back({0,
                                k % board.width,
                                k / board.width,
                                {points.data[at], points.data[at + 1]}});
    }
  }
  return images;
}

// The features of a camera, or why there are none: a board that is not told is
// no fault of the camera.
void TakeFeatures(const YAML::Node& root, const ReadRequest& request,
                  ReadLens* camera) {
  if (!root[kPointsKey]) return;
  const StoredMatrix points = ParseStoredPoints(root[kPointsKey], kPointsKey);
  try {
    camera->features =
        FeaturesOf(root, points, BoardOf(root, request, points.columns));
  } catch (const InputError& error) {
    camera->why_no_features = error.what();
  }
}

ExchangeContents ReadCornersAlone(const YAML::Node& root,
                                  const ReadRequest& request) {
  const StoredMatrix points = ParseStoredPoints(root[kPointsKey], kPointsKey);
  ExchangeContents contents;
  contents.corners =
      FeaturesOf(root, points, BoardOf(root, request, points.columns));
  return contents;
}

// extrinsic_parameters of the same: a rotation vector and a translation a row.
std::vector<BoardPose> PosesOf(const YAML::Node& root) {
  std::vector<BoardPose> poses;
  if (!root["extrinsic_parameters"]) return poses;
  const StoredMatrix rows =
      ParseStoredMatrix(root["extrinsic_parameters"], "extrinsic_parameters");
  if (rows.columns != 6)
    throw InputError("extrinsic_parameters: not 6 numbers a row");
  std::vector<double> boards(rows.rows, 0);
  if (root["board_ids"]) {
    boards = ParseStoredMatrix(root["board_ids"], "board_ids").data;
    boards.resize(rows.rows, 0);
  }
  for (int row = 0; row < rows.rows; ++row) {
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> pose(rows.data.data() +
                                                             6 * row);
    if (!(std::abs(boards[row]) < 1e6 && pose.head<3>().norm() < 1e3))
      throw InputError("extrinsic_parameters, board_ids: no pose");
    poses.push_back({ImageName(root["image_names"], row),
                     static_cast<int>(boards[row]),
                     {RotationFromVector(pose.head<3>()), pose.tail<3>()}});
  }
  return poses;
}

void AddPoses(const std::vector<BoardPose>& poses, FileStorageText* text) {
  if (poses.empty()) return;
  const int count = static_cast<int>(poses.size());
  StoredMatrix rows = {count, 6, {}}, boards = {1, count, {}};
  std::vector<std::string> names;
  for (const BoardPose& pose : poses) {
    const Eigen::AngleAxisd turn(pose.camera_from_board.rotation);
    const Eigen::Vector3d vector = turn.angle() * turn.axis();
    const Eigen::Vector3d& t = pose.camera_from_board.translation;
    rows.data.insert(rows.data.end(),
                     {vector.x(), vector.y(), vector.z(), t.x(), t.y(), t.z()});
    boards.data.push_back(pose.board);
    names.push_back(pose.image);
  }
  text->Add("image_names", names);
  text->Add("board_ids", boards);
  text->Add("extrinsic_parameters", rows);
}

// ---- Cameras of a file -----------------------------------------------------

ReadLens ReadCamera(const CameraKeys& keys, const Affixes& affixes,
                    const ReadRequest& request,
                    std::vector<std::string>* remarks) {
  ReadLens camera;
  LensInForm& lens = camera.lens;
  lens.size = SizeInFile(keys, affixes);
  TakeIntrinsics(keys, affixes, &lens);
  CoefficientsInFile coefficients = Coefficients(keys, affixes);
  lens.form =
      &FormSaid(keys, affixes, request, lens.skew_px, &coefficients, remarks);
  lens.values.insert(lens.values.end(), coefficients.numbers.begin(),
                     coefficients.numbers.end());
  if (lens.form->name == kOmnidir) {
    const std::string xi = affixes.before + "xi" + affixes.behind;
    const std::vector<double> numbers = AllNumbers(keys[xi], xi);
    if (numbers.size() != 1)
      throw InputError(fmt::format("{}: not one number", xi));
    lens.values.push_back(numbers[0]);
    RequireModelOfFile(request, *lens.form);
  }
  return camera;
}

// A camera, and what else a file of one has.
ReadLens ReadSingle(const CameraKeys& keys, const YAML::Node& root,
                    const ReadRequest& request,
                    std::vector<std::string>* remarks) {
  ReadLens camera = ReadCamera(keys, {}, request, remarks);
  camera.name = TextOf(keys, kNameKeys);
  camera.serial = keys.Word("serial");
  camera.camera_from_rig = PoseInFile(keys);
  TakeFeatures(root, request, &camera);
  camera.poses = PosesOf(root);
  keys.Skip(kOtherKeys);
  keys.NameOnly(kVagueKeys);
  keys.Finish(*camera.lens.form, remarks, camera.lens.values);
  return camera;
}

const std::array<Affixes, 2>* FindPair(const CameraKeys& keys) {
  for (const auto& pair : kPairs)
    if (HasMatrix(keys, pair[0]) && HasMatrix(keys, pair[1])) return &pair;
  return nullptr;
}

// A file of two cameras as stereo_calib writes it, and the pose if it is
// there.
void ReadPair(const CameraKeys& keys, const std::array<Affixes, 2>& pair,
              const ReadRequest& request, ExchangeContents* contents) {
  for (const Affixes& affixes : pair) {
    contents->cameras.push_back(
        ReadCamera(keys, affixes, request, &contents->remarks));
    contents->cameras.back().name = affixes.camera;
  }
  TakePoseOfPair(PoseInFile(keys), request.path, &contents->cameras);
  keys.Skip(kOtherKeys);
  keys.Finish(*contents->cameras.front().lens.form, &contents->remarks);
}

// Cameras in maps under their names, or in lists.
void ReadNamed(const YAML::Node& root, const ReadRequest& request, int depth,
               ExchangeContents* contents) {
  constexpr int kDeepest = 2;
  for (const auto& entry : root) {
    const YAML::Node node = root.IsMap() ? entry.second : YAML::Node(entry);
    if (!node.IsMap() && !node.IsSequence()) continue;
    if (node.IsMap()) {
      const CameraKeys keys(node);
      if (HasMatrix(keys) &&
          (!FindKey(keys, kDistortionKeys).empty() || keys.Has("k1"))) {
        ReadLens camera = ReadSingle(keys, node, request, &contents->remarks);
        if (root.IsMap() && entry.first.IsScalar())
          camera.name = entry.first.as<std::string>();
        contents->cameras.push_back(std::move(camera));
        continue;
      }
    }
    if (depth < kDeepest) ReadNamed(node, request, depth + 1, contents);
  }
}

ExchangeContents ReadTree(const YAML::Node& root, const ReadRequest& request) {
  const CameraKeys keys(root);
  const bool has_matrix = HasMatrix(keys);
  if (!has_matrix && keys.Has(kPointsKey))
    return ReadCornersAlone(root, request);
  ExchangeContents contents;
  if (has_matrix) {
    contents.cameras.push_back(
        ReadSingle(keys, root, request, &contents.remarks));
    return contents;
  }
  if (const auto* pair = FindPair(keys)) {
    ReadPair(keys, *pair, request, &contents);
    return contents;
  }
  if (const auto pose = PoseInFile(keys)) {
    contents.second_from_first = pose;
    return contents;
  }
  ReadNamed(root, request, 0, &contents);
  if (contents.cameras.empty())
    throw InputError("no camera: 'camera_matrix' is missing");
  return contents;
}

ExchangeContents ReadOpenCv(const ReadRequest& request) {
  const YAML::Node root = ParseFileStorage(request.path, request.text);
  if (!root.IsMap()) throw InputError("no camera: no map of keys");
  return ReadTree(root, request);
}

// ---- Dictionaries of Python ------------------------------------------------

// The numbers of an array as lists in each other; other arrays are left out.
YAML::Node ListsOf(const NpyArray& array) {
  const std::vector<double> numbers = NpyNumbers(array);
  YAML::Node list(YAML::NodeType::Sequence);
  const size_t columns = array.shape.empty() ? 1 : array.shape.back();
  if (array.shape.size() < 2) {
    if (array.shape.empty()) return YAML::Node(numbers.at(0));
    for (const double number : numbers) list.push_back(number);
    return list;
  }
  for (size_t k = 0; columns > 0 && k + columns <= numbers.size();
       k += columns) {
    YAML::Node row(YAML::NodeType::Sequence);
    for (size_t c = 0; c < columns; ++c) row.push_back(numbers[k + c]);
    list.push_back(row);
  }
  return list;
}

// A text or a pickled object is no number, and says nothing that is read.
YAML::Node TreeOfNpz(const std::string& bytes) {
  constexpr size_t kMostNumbers = 64;
  YAML::Node root(YAML::NodeType::Map);
  for (const NpyArray& array : ReadNpz(bytes, true)) {
    if (array.bytes.empty()) {
      root[array.name] = array.type;
      continue;
    }
    size_t count = 1;
    for (const size_t side : array.shape) count *= side;
    if (count > kMostNumbers) continue;  // corners and poses
    root[array.name] = ListsOf(array);
  }
  return root;
}

ExchangeContents ReadPython(const ReadRequest& request) {
  if (IsNpz(request.text)) return ReadTree(TreeOfNpz(request.text), request);
  const YAML::Node root = ParseFileStorage(request.path, request.text);
  if (root.IsMap()) return ReadTree(root, request);
  ExchangeContents contents;
  if (root.IsSequence()) ReadNamed(root, request, 0, &contents);
  return contents;
}

// Whether a text has a key of YAML or JSON, behind whatever prefix a pair has.
bool HasKeyInText(const std::string& text, const KeyList& names) {
  const auto is_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.';
  };
  for (const std::string& name : names)
    for (size_t at = text.find(name); at != std::string::npos;
         at = text.find(name, at + 1)) {
      if (at > 0 && is_word(text[at - 1]) && text[at - 1] != '_' &&
          text[at - 1] != '.')
        continue;
      size_t end = at + name.size();
      // A pair has _left or 1 behind it.
      const size_t most = std::min(text.size(), end + 6);
      while (end < most && is_word(text[end])) ++end;
      if (end < text.size() && (text[end] == '"' || text[end] == '\'')) ++end;
      end = text.find_first_not_of(" \t", end);
      if (end != std::string::npos && text[end] == ':') return true;
    }
  return false;
}

void AddFit(const LensFit& fit, FileStorageText* text) {
  const Eigen::Quaterniond& q = fit.lens_from_camera;
  text->BeginMap("raygrid_fit");
  text->Add("rms_px", fit.rms_px);
  text->Add("p99_px", fit.p99_px);
  text->Add("max_px", fit.max_px);
  text->Add("pixels", static_cast<int>(fit.num_pixels));
  text->Add("pixels_beyond", static_cast<int>(fit.num_beyond));
  text->Add("lens_from_camera_wxyz",
            StoredMatrix{1, 4, {q.w(), q.x(), q.y(), q.z()}});
  text->EndMap();
}

std::string WriteOpenCv(const WriteRequest& request) {
  const WrittenLens& camera = request.cameras.front();
  const LensInForm& lens = camera.lens;
  FileStorageText text(FileStorageText::KindOf(request.path));
  if (!camera.name.empty()) text.Add("camera_name", camera.name);
  if (!camera.serial.empty()) text.Add("serial", camera.serial);
  text.Add("image_width", lens.size.width);
  text.Add("image_height", lens.size.height);
  if (lens.form->name != kOmnidir)
    text.Add("fisheye_model", lens.form->name == kFisheye ? 1 : 0);
  if (camera.fit) AddFit(*camera.fit, &text);
  text.Add("camera_matrix",
           StoredMatrix{3,
                        3,
                        {lens.Value("fx"), 0, lens.Value("cx"), 0,
                         lens.Value("fy"), lens.Value("cy"), 0, 0, 1}});
  std::vector<double> coefficients = lens.ValuesFrom(4);
  if (lens.form->name == kOmnidir) {
    coefficients.pop_back();
    text.Add("xi", lens.Value("xi"));
  }
  text.Add(
      "distortion_coefficients",
      StoredMatrix{1, static_cast<int>(coefficients.size()), coefficients});
  if (camera.camera_from_rig) {
    const Eigen::Matrix3d r =
        camera.camera_from_rig->rotation.toRotationMatrix();
    const Eigen::Vector3d& t = camera.camera_from_rig->translation;
    text.Add("R", StoredMatrix{3,
                               3,
                               {r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1),
                                r(1, 2), r(2, 0), r(2, 1), r(2, 2)}});
    text.Add("T", StoredMatrix{3, 1, {t.x(), t.y(), t.z()}});
  }
  AddPoses(camera.poses, &text);
  return text.Finish();
}

}  // namespace

bool IsNpzOfCamera(const std::string& bytes) {
  const auto has_any = [&](const KeyList& names) {
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) {
                         return bytes.find(name + ".npy") != std::string::npos;
                       });
  };
  return IsNpz(bytes) && has_any(kMatrixKeys) && has_any(kDistortionKeys);
}

Format OpenCvFormat() {
  Format format;
  format.name = "opencv";
  format.holds =
      "FileStorage .yaml, .xml or .json: a pinhole with 4, 5, 8, 12 or 14 "
      "coefficients, cv::fisheye or cv::omnidir; of a rig a file for each "
      "camera, with R and T of its pose, or both of a pair as stereo_calib "
      "has them; poses and corners of boards, also corners alone";
  format.forms = OpenCvForms();
  format.holds_poses = true;
  format.takes_model = true;
  format.may_take_board = true;
  format.recognizes = IsFileStorage;
  format.read = ReadOpenCv;
  format.write = WriteOpenCv;
  return format;
}

Format PythonFormat() {
  Format format;
  format.name = "python";
  format.holds =
      "a dictionary of Python as .json, .yaml or .npz: K, mtx or "
      "camera_matrix, and D, dist or dist_coeffs of OpenCV's models, of one "
      "camera or by the names of several";
  format.forms = OpenCvForms();
  format.takes_model = true;
  format.recognizes = [](const std::string& text) {
    if (IsNpz(text)) return IsNpzOfCamera(text);
    for (const Format& other : Formats())  // whose words say more
      if (other.name != "python" && other.recognizes(text)) return false;
    return (HasKeyInText(text, kMatrixKeys) || HasKeyInText(text, {"fx"})) &&
           (HasKeyInText(text, kDistortionKeys) || HasKeyInText(text, {"k1"}));
  };
  format.read = ReadPython;
  format.write = nullptr;
  return format;
}

}  // namespace raygrid
