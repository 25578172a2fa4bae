#include "exchange/keyed_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/camera_keys.h"
#include "exchange/file_storage.h"
#include "exchange/opencv_forms.h"
#include "exchange/plain_trees.h"
#include "exchange/ros_format.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

// ---- The table's terms -----------------------------------------------------

// A camera model, and where its parameters stand. Texts are words with spaces
// between. '@' in a key stands for the camera's word, and a key with '?' behind
// it may be missing.
struct KeyedModel {
  LensForm form;
  // "KEY=WORD|WORD": what the file says of this model.
  const char* says;
  // "KEY=PARAMETER,PARAMETER": a number or a list, at "KEY|KEY" the first
  // that is there. "KEY=K" is the camera matrix, "KEY=P" a projection matrix of
  // 3 x 4 with the pose of a rectified camera, "KEY~=" a list that may be
  // shorter. Longer ones end with 0.
  const char* values;
};

// Kinds of poses.
enum class PoseKind {
  kCameraFromRig,  // a matrix
  kRigFromCamera,
  kVectors,  // "KEY KEY": rotation vector and translation, camera_from_rig
  kRAndT     // "KEY KEY": rotation matrix and translation, likewise
};

struct KeyedPose {
  const char* keys;
  PoseKind kind;
  const char* word =
      "";  // of the camera that has it; the first then is the rig
};

struct KeyedFormat {
  const char *name, *holds;
  YAML::Node (*parse)(const ReadRequest& request);
  bool (*recognizes)(const std::string& text);
  // The place of cameras: "" is the file itself, "*" its maps by their names,
  // else the key of a list or a map of them.
  const char* place;
  std::vector<const char*> words;  // for '@', one for each camera of a map
  std::vector<KeyedModel> models;
  const char* size;  // "KEY" of a list, "KEY KEY", or "" if there is none
  std::vector<KeyedPose> poses;
  const char* camera_name;  // its key
  const char* ones;    // keys whose value must be 1: scales that are not taken
  bool is_normalized;  // lengths are parts of the longer side of the image
  std::vector<std::string> others;  // keys that say nothing of the lens
};

// ---- Texts -----------------------------------------------------------------

YAML::Node ParseKeyedYaml(const ReadRequest& request) {
  return ParseFileStorage(request.path, request.text);
}
YAML::Node ParseTomlOf(const ReadRequest& request) {
  return ParseToml(request.text);
}
YAML::Node ParseLinesOf(const ReadRequest& request) {
  return ParseKeyLines(request.text);
}
YAML::Node ParseNumbersOf(const ReadRequest& request) {
  return ParseKeyLines("numbers: " + request.text);
}

bool HasAllWords(const std::string& text,
                 std::initializer_list<const char*> words) {
  return std::all_of(words.begin(), words.end(), [&](const char* word) {
    return text.find(word) != std::string::npos;
  });
}

// One line of 4, 8 or 9 numbers.
bool IsLineOfNumbers(const std::string& text) {
  constexpr size_t kLongest = 400;
  if (text.size() > kLongest ||
      text.find_first_not_of("0123456789.+-eE \t\r\n") != std::string::npos)
    return false;
  const size_t end = text.find('\n');
  if (end != std::string::npos &&
      text.find_first_not_of(" \t\r\n", end) != std::string::npos)
    return false;
  std::istringstream words(text);
  size_t count = 0;
  for (double number = 0; words >> number;) ++count;
  return words.eof() && (count == 4 || count == 8 || count == 9);
}

// ---- The table -------------------------------------------------------------

LensForm KeyedPinhole(const char* name, int count) {
  return OpenCvForm(name, count);
}
LensForm KeyedFisheye(const char* name) {
  LensForm form = OpenCvFisheyeForm(name);
  form.reach_rad = M_PI;
  return form;
}
LensForm KeyedOmni(const char* name) {
  return FormOf(name, "omni-radtan", {"xi", "k1", "k2", "p1", "p2"});
}
// OpenSfM's pixels count from the image's middle.
LensForm FromMiddle(LensForm form) {
  form.origin = PixelOrigin::kImageMiddle;
  return form;
}

const std::vector<KeyedFormat>& KeyedTable() {
  static const std::vector<KeyedFormat> table = {
      {"gyroflow",
       "Gyroflow's lens profile .json",
       ParseKeyedYaml,
       [](const std::string& text) {
         return HasAllWords(text,
                            {"\"fisheye_params\"", "\"calib_dimension\""});
       },
       "",
       {},
       {{OpenCvFisheyeForm("opencv_fisheye"),
         "distortion_model?=opencv_fisheye",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=k1,k2,k3,k4"},
        {KeyedPinhole("opencv_standard", 12),
         "distortion_model=opencv_standard",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=k1,k2,p1,p2,k3,k4,k5,k6,s1,s2,s3,"
         "s4"}},
       "calib_dimension/w calib_dimension/h",
       {},
       "",
       "input_horizontal_stretch input_vertical_stretch",
       false,
       {"name",
        "note",
        "calibrated_by",
        "camera_brand",
        "camera_model",
        "lens_model",
        "camera_setting",
        "orig_dimension",
        "output_dimension",
        "frame_readout_time",
        "frame_readout_direction",
        "gyro_lpf",
        "num_images",
        "fps",
        "crop",
        "official",
        "asymmetrical",
        "use_opencv_fisheye",
        "fisheye_params/RMS_error",
        "fisheye_params/radial_distortion_limit",
        "identifier",
        "calibrator_version",
        "date",
        "compatible_settings",
        "sync_settings",
        "focal_length",
        "crop_factor",
        "global_shutter",
        "per_zoom_level*",
        "digital_lens_params",
        "interpolations",
        "file",
        "lens_profile*"}},
      {"orbslam",
       "settings .yaml of ORB-SLAM2 and 3, and of OpenVSLAM",
       ParseKeyedYaml,
       [](const std::string& text) {
         return HasAllWords(text, {"Camera.fx"}) ||
                HasAllWords(text, {"Camera1.fx"});
       },
       "",
       {"Camera", "Camera1", "Camera2"},
       {{KeyedPinhole("PinHole", 5),
         "Camera.type?=PinHole Camera.model?=perspective",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy @.k1?=k1 @.k2?=k2 @.p1?=p1 @.p2?=p2 "
         "@.k3?=k3"},
        {KeyedPinhole("Rectified", 0), "Camera.type=Rectified",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy"},
        {KeyedFisheye("KannalaBrandt8"), "Camera.type=KannalaBrandt8",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy @.k1=k1 @.k2=k2 @.k3=k3 @.k4=k4"},
        {OpenCvFisheyeForm("fisheye"), "Camera.model=fisheye",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy @.k1=k1 @.k2=k2 @.k3=k3 @.k4=k4"}},
       "Camera.width|Camera.cols Camera.height|Camera.rows",
       {{"Stereo.T_c1_c2", PoseKind::kRigFromCamera, "Camera2"},
        {"Tlr", PoseKind::kRigFromCamera, "Camera2"}},
       "",
       "",
       false,
       {"Camera.fps",
        "Camera.RGB",
        "Camera.bf",
        "Camera.bFishEye",
        "Camera.name",
        "Camera.setup",
        "Camera.color_order",
        "Camera.newWidth",
        "Camera.newHeight",
        "Camera.imageScale",
        "Camera.lappingBegin",
        "Camera.lappingEnd",
        "Camera2.lapping*",
        "Camera1.overlapping*",
        "Camera2.overlapping*",
        "File.version",
        "ORBextractor.*",
        "Viewer.*",
        "IMU.*",
        "System.*",
        "RGBD.*",
        "Stereo.*",
        "ThDepth",
        "DepthMapFactor",
        "Tbc",
        "loopClosing",
        "thFarPoints"}},
      {"camodocal",
       "camodocal's and VINS's camera .yaml",
       ParseKeyedYaml,
       [](const std::string& text) {
         return HasAllWords(text, {"model_type:", "projection_parameters:"});
       },
       "",
       {},
       {{KeyedPinhole("PINHOLE", 4), "model_type=PINHOLE",
         "projection_parameters/fx=fx projection_parameters/fy=fy "
         "projection_parameters/cx=cx projection_parameters/cy=cy "
         "distortion_parameters/k1=k1 distortion_parameters/k2=k2 "
         "distortion_parameters/p1=p1 distortion_parameters/p2=p2"},
        {KeyedPinhole("PINHOLE_FULL", 8), "model_type=PINHOLE_FULL",
         "projection_parameters/fx=fx projection_parameters/fy=fy "
         "projection_parameters/cx=cx projection_parameters/cy=cy "
         "distortion_parameters/k1=k1 distortion_parameters/k2=k2 "
         "distortion_parameters/k3=k3 distortion_parameters/k4=k4 "
         "distortion_parameters/k5=k5 distortion_parameters/k6=k6 "
         "distortion_parameters/p1=p1 distortion_parameters/p2=p2"},
        {KeyedOmni("MEI"), "model_type=MEI",
         "mirror_parameters/xi=xi projection_parameters/gamma1=fx "
         "projection_parameters/gamma2=fy projection_parameters/u0=cx "
         "projection_parameters/v0=cy distortion_parameters/k1=k1 "
         "distortion_parameters/k2=k2 distortion_parameters/p1=p1 "
         "distortion_parameters/p2=p2"},
        {KeyedFisheye("KANNALA_BRANDT"), "model_type=KANNALA_BRANDT",
         "projection_parameters/mu=fx projection_parameters/mv=fy "
         "projection_parameters/u0=cx projection_parameters/v0=cy "
         "projection_parameters/k2|distortion_parameters/k2=k1 "
         "projection_parameters/k3|distortion_parameters/k3=k2 "
         "projection_parameters/k4|distortion_parameters/k4=k3 "
         "projection_parameters/k5|distortion_parameters/k5=k4"}},
       "image_width image_height",
       {},
       "camera_name",
       "",
       false,
       {"fisheye", "fisheye_mask"}},
      {"euroc",
       "sensor.yaml of EuRoC, ASL and Kimera",
       ParseKeyedYaml,
       [](const std::string& text) {
         return HasAllWords(
             text,
             {"T_BS", "intrinsics:", "distortion_model:", "camera_model:"});
       },
       "",
       {},
       {{KeyedPinhole("pinhole-radtan", 5),
         "camera_model=pinhole "
         "distortion_model=radial-tangential|radtan|plumb_bob",
         "intrinsics=fx,fy,cx,cy distortion_coefficients~=k1,k2,p1,p2,k3"},
        {KeyedFisheye("pinhole-equidistant"),
         "camera_model=pinhole distortion_model=equidistant|fisheye",
         "intrinsics=fx,fy,cx,cy distortion_coefficients~=k1,k2,k3,k4"},
        {KeyedPinhole("pinhole-none", 0),
         "camera_model=pinhole distortion_model=none",
         "intrinsics=fx,fy,cx,cy"}},
       "resolution",
       {{"T_BS", PoseKind::kRigFromCamera}},
       "camera_id",
       "",
       false,
       {"sensor_type", "comment", "rate_hz", "sensor_id", "name"}},
      {"anipose",
       "calibration .toml of anipose, freemocap and Pose2Sim",
       ParseTomlOf,
       [](const std::string& text) {
         return HasAllWords(text,
                            {"matrix", "distortions", "rotation", "=", "["}) &&
                text.find('{') == std::string::npos;
       },
       "*",
       {},
       {{KeyedPinhole("pinhole", 8), "fisheye?=false",
         "matrix=K distortions~=k1,k2,p1,p2,k3,k4,k5,k6"},
        {OpenCvFisheyeForm("fisheye"), "fisheye=true",
         "matrix=K distortions~=k1,k2,k3,k4"}},
       "size",
       {{"rotation translation", PoseKind::kVectors}},
       "name",
       "",
       false,
       {"world_position", "world_orientation", "extra_dist"}},
      {"okvis",
       "OKVIS's configuration .yaml",
       ParseKeyedYaml,
       [](const std::string& text) {
         return HasAllWords(text, {"T_SC", "image_dimension", "focal_length",
                                   "distortion_type"});
       },
       "cameras",
       {},
       {{KeyedPinhole("radialtangential", 4),
         "distortion_type=radialtangential",
         "focal_length=fx,fy principal_point=cx,cy "
         "distortion_coefficients=k1,k2,p1,p2"},
        {KeyedPinhole("radialtangential8", 8),
         "distortion_type=radialtangential8",
         "focal_length=fx,fy principal_point=cx,cy "
         "distortion_coefficients=k1,k2,p1,p2,k3,k4,k5,k6"},
        {KeyedFisheye("equidistant"), "distortion_type=equidistant",
         "focal_length=fx,fy principal_point=cx,cy "
         "distortion_coefficients=k1,k2,k3,k4"}},
       "image_dimension",
       {{"T_SC", PoseKind::kRigFromCamera}},
       "",
       "",
       false,
       {"camera_type", "slam_use", "mapping", "mapping_rectification"}},
      {"opensfm",
       "OpenSfM's camera_models.json and reconstruction.json",
       ParseKeyedYaml,
       [](const std::string& text) {
         return HasAllWords(text,
                            {"\"projection_type\"", "\"width\"", "\"focal"});
       },
       "*",
       {},
       {{FromMiddle({"perspective", "opencv", {"f", "k1", "k2"}}),
         "projection_type=perspective", "focal=f k1?=k1 k2?=k2"},
        {FromMiddle(KeyedPinhole("brown", 5)), "projection_type=brown",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1?=k1 k2?=k2 p1?=p1 p2?=p2 "
         "k3?=k3"},
        {FromMiddle(FormOf("simple_radial", "opencv", {"k1"})),
         "projection_type=simple_radial",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1=k1"},
        {FromMiddle(FormOf("radial", "opencv", {"k1", "k2"})),
         "projection_type=radial",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1=k1 k2=k2"},
        {FromMiddle({"fisheye", "thin-prism-fisheye", {"f", "k1", "k2"}}),
         "projection_type=fisheye", "focal=f k1?=k1 k2?=k2"},
        {FromMiddle(KeyedFisheye("fisheye_opencv")),
         "projection_type=fisheye_opencv",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1=k1 k2=k2 k3=k3 k4=k4"}},
       "width height",
       {},
       "",
       "",
       true,
       {"focal_prior", "focal_x_prior", "focal_y_prior", "c_x_prior",
        "c_y_prior", "k1_prior", "k2_prior", "k3_prior", "k4_prior", "p1_prior",
        "p2_prior"}},
      {"kitti",
       "KITTI's calib_cam_to_cam.txt",
       ParseLinesOf,
       [](const std::string& text) {
         return HasAllWords(text, {"K_00:", "D_00:", "S_00:"});
       },
       "",
       {"00", "01", "02", "03"},
       {{KeyedPinhole("pinhole", 5), "", "K_@=K D_@~=k1,k2,p1,p2,k3"}},
       "S_@",
       {{"R_@ T_@", PoseKind::kRAndT}},
       "",
       "",
       false,
       {"calib_time", "corner_dist", "S_rect_*", "R_rect_*", "P_rect_*"}},
      {"kitti-rectified",
       "KITTI's calib.txt of rectified cameras",
       ParseLinesOf,
       [](const std::string& text) {
         return text.rfind("P0:", 0) == 0 && HasAllWords(text, {"\nP1:"});
       },
       "",
       {"P0", "P1", "P2", "P3"},
       {{KeyedPinhole("pinhole", 0), "", "@=P"}},
       "",
       {},
       "",
       "",
       false,
       {"Tr*", "R0_rect", "R_rect", "calib_time", "corner_dist"}},
      {"calib-line",
       "calib.txt of one line, as DROID-SLAM has TUM's: fx fy cx cy, and "
       "k1 k2 p1 p2 k3",
       ParseNumbersOf,
       IsLineOfNumbers,
       "",
       {},
       {{KeyedPinhole("pinhole", 5), "",
         "numbers~=fx,fy,cx,cy,k1,k2,p1,p2,k3"}},
       "",
       {},
       "",
       "",
       false,
       {}}};
  return table;
}

// ---- Reading ---------------------------------------------------------------

std::vector<std::string> PartsOf(const std::string& text, char space = ' ') {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, space);)
    if (!word.empty()) words.push_back(word);
  return words;
}

std::string WithWord(std::string key, const std::string& word) {
  const size_t at = key.find('@');
  return at == std::string::npos ? key : key.replace(at, 1, word);
}

// "KEY?=WORDS" as "KEY" and "WORDS", and whether the mark stands there.
struct KeyedWord {
  std::string key, words;
  bool has_mark = false;
};

KeyedWord Parted(const std::string& text, char mark, const std::string& word) {
  const size_t equals = text.find('=');
  KeyedWord parted = {text.substr(0, equals), text.substr(equals + 1)};
  parted.has_mark = parted.key.back() == mark;
  if (parted.has_mark) parted.key.pop_back();
  parted.key = WithWord(parted.key, word);
  return parted;
}

// Whether the file says a model; what it says counts as read then.
bool IsSaid(const CameraKeys& keys, const KeyedModel& model) {
  const std::vector<std::string> conditions = PartsOf(model.says);
  std::vector<std::string> read;
  for (const std::string& condition : conditions) {
    const KeyedWord said = Parted(condition, '?', "");
    const std::string word = Lowercase(keys.Word(said.key));
    const std::vector<std::string> words = PartsOf(said.words, '|');
    const bool is_absent = word.empty() || word == "null" || word == "~";
    if (is_absent ? !said.has_mark
                  : std::none_of(words.begin(), words.end(),
                                 [&](const std::string& one) {
                                   return Lowercase(one) == word;
                                 }))
      return false;
    read.push_back(said.key);
  }
  keys.Skip(read);
  return true;
}

const KeyedModel& FindKeyedModel(const KeyedFormat& format,
                                 const CameraKeys& keys) {
  std::string said, names;
  for (const KeyedModel& model : format.models) {
    if (IsSaid(keys, model)) return model;
    names += (names.empty() ? "" : ", ") + model.form.name;
    said.clear();
    for (const std::string& condition : PartsOf(model.says)) {
      const std::string key = Parted(condition, '?', "").key;
      said += fmt::format("{}{} '{}'", said.empty() ? "" : ", ", key,
                          Printable(keys.Word(key)));
    }
  }
  throw InputError(fmt::format(
      "{}: of no model that raygrid reads there; those are {}", said, names));
}

// The first key of "KEY|KEY" that is there, or the first one.
std::string FirstThatIsThere(const CameraKeys& keys, const std::string& names) {
  const std::vector<std::string> all = PartsOf(names, '|');
  for (const std::string& name : all)
    if (keys.Has(name)) return name;
  return all.empty() ? "" : all[0];
}

// The numbers of one entry of KeyedModel::values, by parameter.
void TakeKeyedValue(const KeyedFormat& format, const CameraKeys& keys,
                    const std::string& entry, const std::string& word,
                    std::map<std::string, double>* values, ReadLens* camera) {
  const bool may_be_missing = entry.find("?=") != std::string::npos;
  KeyedWord part = Parted(entry, may_be_missing ? '?' : '~', word);
  part.key = FirstThatIsThere(keys, part.key);
  if (!keys.Has(part.key)) {
    if (may_be_missing) return;
    throw InputError(fmt::format("'{}' is missing", part.key));
  }
  const YAML::Node node = keys[part.key];
  const std::vector<double> numbers =
      node.IsNull() ? std::vector<double>{} : AllNumbers(node, part.key);
  if (part.words == "K" || part.words == "P") {
    const bool is_p = part.words == "P";
    if (numbers.size() != (is_p ? 12 : 9))
      throw InputError(fmt::format("{}: not 3 x {}", part.key, is_p ? 4 : 3));
    const auto& n = numbers;
    TakeCameraMatrix(is_p ? std::vector<double>{n[0], n[1], n[2], n[4], n[5],
                                                n[6], n[8], n[9], n[10]}
                          : n,
                     part.key, &camera->lens);
    const std::vector<double>& k = camera->lens.values;
    if (is_p && k[0] > 0 && k[1] > 0)
      // P = K [I t], and K's last row is 0 0 1.
      camera->camera_from_rig = Pose{
          Eigen::Quaterniond::Identity(),
          {(n[3] - k[2] * n[11]) / k[0], (n[7] - k[3] * n[11]) / k[1], n[11]}};
    *values = {{"fx", k[0]}, {"fy", k[1]}, {"cx", k[2]}, {"cy", k[3]}};
    return;
  }
  const std::vector<std::string> parameters = PartsOf(part.words, ',');
  const bool is_longer = numbers.size() > parameters.size();
  if ((numbers.size() < parameters.size() && !part.has_mark) ||
      (is_longer &&
       std::any_of(numbers.begin() + parameters.size(), numbers.end(),
                   [](double number) { return number != 0; })))
    throw InputError(fmt::format(
        "{}: {} numbers where {} of {} has {}", part.key, numbers.size(),
        camera->lens.form->name, format.name, parameters.size()));
  for (size_t k = 0; k < std::min(numbers.size(), parameters.size()); ++k)
    (*values)[parameters[k]] = numbers[k];
}

ImageSize KeyedSizeOf(const KeyedFormat& format, const CameraKeys& keys,
                      const std::string& word) {
  std::vector<std::string> names = PartsOf(WithWord(format.size, word));
  for (std::string& name : names) name = FirstThatIsThere(keys, name);
  if (names.empty() || !keys.Has(names[0])) return {};
  if (names.size() == 1) return SizeOfList(keys[names[0]], names[0]);
  return {SidePx(keys[names[0]], names[0]), SidePx(keys[names[1]], names[1])};
}

std::optional<Pose> KeyedPoseOf(const KeyedPose& pose, const CameraKeys& keys,
                                const std::string& word) {
  std::vector<std::vector<double>> numbers;
  for (const std::string& text : PartsOf(pose.keys)) {
    const std::string key = WithWord(text, word);
    if (!keys.Has(key)) return std::nullopt;
    numbers.push_back(AllNumbers(keys[key], key));
  }
  const std::string name = WithWord(pose.keys, word);
  const auto require = [&](bool is_right) {
    if (!is_right) throw InputError(fmt::format("{}: no pose", name));
  };
  if (pose.kind == PoseKind::kVectors) {
    require(numbers[0].size() == 3 && numbers[1].size() == 3 &&
            Eigen::Map<const Eigen::Vector3d>(numbers[0].data()).norm() < 1e3);
    return Pose{RotationFromVector(
                    Eigen::Map<const Eigen::Vector3d>(numbers[0].data())),
                Eigen::Map<const Eigen::Vector3d>(numbers[1].data())};
  }
  if (pose.kind == PoseKind::kRAndT) {
    require(numbers[0].size() == 9 && numbers[1].size() == 3);
    std::vector<double> rows;
    for (int row = 0; row < 3; ++row) {
      rows.insert(rows.end(), numbers[0].begin() + 3 * row,
                  numbers[0].begin() + 3 * row + 3);
      rows.push_back(numbers[1][row]);
    }
    return PoseOfMatrix(rows, name);
  }
  require(numbers[0].size() == 16 || numbers[0].size() == 12);
  const Pose matrix = PoseOfMatrix(numbers[0], name);
  return pose.kind == PoseKind::kCameraFromRig ? matrix : matrix.Inverse();
}

ReadLens ReadKeyedCamera(const KeyedFormat& format, const CameraKeys& keys,
                         const std::string& word) {
  const KeyedModel& model = FindKeyedModel(format, keys);
  ReadLens camera;
  camera.lens.form = &model.form;
  camera.lens.size = KeyedSizeOf(format, keys, word);
  std::map<std::string, double> values;
  for (const std::string& entry : PartsOf(model.values))
    TakeKeyedValue(format, keys, entry, word, &values, &camera);
  const double unit = format.is_normalized ? std::max(camera.lens.size.width,
                                                      camera.lens.size.height)
                                           : 1;
  for (const char* length : {"f", "fx", "fy", "cx", "cy"})
    if (values.count(length) > 0) values[length] *= unit;
  camera.lens.values.clear();
  for (const std::string& parameter : model.form.parameters)
    camera.lens.values.push_back(values[parameter]);
  for (const KeyedPose& pose : format.poses) {
    if (pose.word[0] != 0 && word != pose.word) continue;
    if (!camera.camera_from_rig)
      camera.camera_from_rig = KeyedPoseOf(pose, keys, word);
  }
  for (const std::string& key : PartsOf(format.ones))
    if (keys.Has(key) && !keys[key].IsNull() &&
        FiniteNumber(keys[key], key) != 1)
      throw InputError(fmt::format(
          "{}: {:g}; images are stretched before this lens, which is not read",
          key, FiniteNumber(keys[key], key)));
  if (format.camera_name[0] != 0 && keys.Has(format.camera_name)) {
    camera.name = keys.Word(format.camera_name);
    keys.Skip({format.camera_name});
  }
  return camera;
}

// The cameras of one map: as many as there are words whose first value stands
// there, or one.
void ReadKeyedMap(const KeyedFormat& format, const CameraKeys& keys,
                  const std::string& name, ExchangeContents* contents) {
  const size_t first = contents->cameras.size();
  const std::string value = PartsOf(format.models[0].values)[0];
  if (format.words.empty()) {
    contents->cameras.push_back(ReadKeyedCamera(format, keys, ""));
    ReadLens& camera = contents->cameras.back();
    if (camera.name.empty()) camera.name = name;
  }
  for (const char* word : format.words) {
    if (!keys.Has(Parted(value, '?', word).key)) continue;
    contents->cameras.push_back(ReadKeyedCamera(format, keys, word));
    contents->cameras.back().name = fmt::format(
        "{}{}", std::isdigit(static_cast<unsigned char>(word[0])) ? "cam" : "",
        word);
  }
  if (contents->cameras.size() == first) throw InputError("no camera");
  if (!format.words.empty() && contents->cameras.size() == first + 1)
    contents->cameras.back().name = name;
  // A pose that only the second camera has is that in the first one.
  ReadLens& leader = contents->cameras[first];
  if (contents->cameras.size() > first + 1 && !leader.camera_from_rig &&
      contents->cameras.back().camera_from_rig)
    leader.camera_from_rig = Pose{};
  keys.Skip(format.others);
  keys.Finish(*leader.lens.form, &contents->remarks);
}

// Maps by their names, or those of a list. Without the key that a camera begins
// with, a map is none.
void ReadKeyedMaps(const KeyedFormat& format, const YAML::Node& maps,
                   ExchangeContents* contents) {
  const std::string value = PartsOf(format.models[0].values)[0];
  const std::string begin = Parted(value, '?', "").key;
  int number = 0;
  for (const auto& entry : maps) {
    const YAML::Node map = maps.IsMap() ? entry.second : YAML::Node(entry);
    const std::string name = maps.IsMap() && entry.first.IsScalar()
                                 ? entry.first.as<std::string>()
                                 : fmt::format("cam{}", number);
    ++number;
    if (!map.IsMap() || (maps.IsMap() && map.size() == 0)) continue;
    const CameraKeys keys(map, Printable(name));
    if (std::none_of(format.models.begin(), format.models.end(),
                     [&](const KeyedModel& model) {
                       return keys.Has(
                           Parted(PartsOf(model.values)[0], '?', "").key);
                     }))
      continue;
    try {
      ReadKeyedMap(format, keys, name, contents);
    } catch (const InputError& error) {
      const std::string message = error.what();
      if (message.rfind(Printable(name) + ": ", 0) == 0) throw;
      throw InputError(fmt::format("{}: {}", Printable(name), message));
    }
  }
}

ExchangeContents ReadKeyed(const KeyedFormat& format,
                           const ReadRequest& request) {
  YAML::Node root = format.parse(request);
  // OpenSfM's reconstruction.json is a list of scenes, which have cameras.
  if (format.is_normalized && root.IsSequence() && root.size() > 0)
    root.reset(root[0]);
  if (format.is_normalized && root.IsMap() && root["cameras"].IsDefined())
    root.reset(root["cameras"]);
  if (!root.IsMap()) throw InputError("no camera: no map of keys");
  const std::string place = format.place;
  ExchangeContents contents;
  if (place.empty()) {
    ReadKeyedMap(format, CameraKeys(root), "", &contents);
    return contents;
  }
  const YAML::Node maps = place == "*" ? root : root[place];
  if (!maps.IsDefined() || (!maps.IsMap() && !maps.IsSequence()))
    throw InputError(fmt::format("'{}' is missing", place));
  ReadKeyedMaps(format, maps, &contents);
  if (contents.cameras.size() == 1 && maps.IsSequence())
    contents.cameras.front().name.clear();
  return contents;
}

// ---- ROS's .ini ------------------------------------------------------------

ExchangeContents ReadRosIni(const ReadRequest& request) {
  const YAML::Node ini = ParseRosIni(request.text);
  const std::map<std::string, std::string> names = {
      {"width", "image_width"},
      {"height", "image_height"},
      {"name", "camera_name"},
      {"camera matrix", "camera_matrix"},
      {"distortion", "distortion_coefficients"},
      {"rectification", "rectification_matrix"},
      {"projection", "projection_matrix"}};
  YAML::Node root(YAML::NodeType::Map);
  for (const auto& entry : ini) {
    const std::string key = entry.first.as<std::string>();
    const auto name = names.find(key);
    root[name == names.end() ? key : name->second] = entry.second;
  }
  const YAML::Node d = root["distortion_coefficients"];
  if (d.IsDefined())
    root["distortion_model"] =
        d.IsSequence() && d.size() > 5 ? "rational_polynomial" : "plumb_bob";
  return ReadRosCamera(root, request);
}

}  // namespace

std::vector<Format> KeyedFormats() {
  std::vector<Format> formats;
  for (const KeyedFormat& row : KeyedTable()) {
    Format format;
    format.name = row.name;
    format.holds = row.holds;
    for (const KeyedModel& model : row.models)
      format.forms.push_back(model.form);
    format.recognizes = row.recognizes;
    format.read = [&row](const ReadRequest& request) {
      return ReadKeyed(row, request);
    };
    format.write = nullptr;
    formats.push_back(std::move(format));
  }
  Format ini;
  ini.name = "ros-ini";
  ini.holds = "camera_calibration's .ini of ROS";
  ini.forms = RosFormat().forms;
  ini.recognizes = [](const std::string& text) {
    return HasAllWords(text, {"[image]", "camera matrix", "distortion"});
  };
  ini.read = ReadRosIni;
  ini.write = nullptr;
  formats.push_back(std::move(ini));
  return formats;
}

}  // namespace raygrid
