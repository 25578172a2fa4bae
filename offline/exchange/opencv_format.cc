#include "exchange/opencv_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "exchange/file_storage.h"
#include "exchange/opencv_forms.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr char kFisheye[] = "fisheye";

const std::vector<LensForm>& OpenCvForms() {
  static const std::vector<LensForm> forms = {
      OpenCvForm("opencv4", 4),   OpenCvForm("opencv5", 5),
      OpenCvForm("opencv8", 8),   OpenCvForm("opencv12", 12),
      OpenCvForm("opencv14", 14), OpenCvFisheyeForm(kFisheye)};
  return forms;
}

// The names that OpenCV's programs, and their users, give to one thing.
const std::vector<std::string> kMatrixKeys = {"camera_matrix",
                                              "cameraMatrix",
                                              "Camera_Matrix",
                                              "intrinsic_matrix",
                                              "CameraMatrix",
                                              "K",
                                              "mtx"};
const std::vector<std::string> kDistortionKeys = {"distortion_coefficients",
                                                  "distCoeffs",
                                                  "Distortion_Coefficients",
                                                  "dist_coeffs",
                                                  "D",
                                                  "dist",
                                                  "distortion_coeffs",
                                                  "DistCoeffs"};
const std::vector<std::string> kSizeKeys = {"cameraResolution", "image_size",
                                            "imageSize", "img_shape"};
const std::vector<std::string> kWidthKeys = {"image_width", "image_Width",
                                             "imageWidth", "width"};
const std::vector<std::string> kHeightKeys = {"image_height", "image_Height",
                                              "imageHeight", "height"};
constexpr char kPointsKey[] = "image_points";
const std::vector<std::string> kNameKeys = {"camera_name", "cameraName"};

// The first of these keys that stands in a map, or "".
std::string FindKey(const YAML::Node& root,
                    const std::vector<std::string>& keys) {
  for (const std::string& key : keys)
    if (root[key]) return key;
  return "";
}

std::string TextOf(const YAML::Node& root,
                   const std::vector<std::string>& keys) {
  const std::string key = FindKey(root, keys);
  return key.empty() || !root[key].IsScalar() ? ""
                                              : root[key].as<std::string>();
}

ImageSize SizeOfImages(const YAML::Node& root, const ReadRequest& request) {
  if (request.size) return *request.size;
  const std::string width = FindKey(root, kWidthKeys),
                    height = FindKey(root, kHeightKeys),
                    size = FindKey(root, kSizeKeys);
  if (!width.empty() && !height.empty())
    return {SidePx(root[width], width), SidePx(root[height], height)};
  if (!size.empty()) return SizeOfList(root[size], size);
  throw InputError(
      "the size of the images is missing; import it with --image-size WxH");
}

// Throws for a matrix that is not fx 0 cx, 0 fy cy, 0 0 1.
std::vector<double> Intrinsics(const YAML::Node& root) {
  const std::string key = FindKey(root, kMatrixKeys);
  if (key.empty()) throw InputError("no camera: 'camera_matrix' is missing");
  const StoredMatrix matrix = ParseStoredMatrix(root[key], key);
  if (matrix.rows != 3 || matrix.columns != 3)
    throw InputError(fmt::format("{}: not 3 x 3", key));
  const std::vector<double>& k = matrix.data;
  if (k[1] != 0)
    throw InputError(
        fmt::format("{}: a skew of {:g}, which no model here has", key, k[1]));
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    throw InputError(fmt::format("{}: not fx 0 cx, 0 fy cy, 0 0 1", key));
  return {k[0], k[4], k[2], k[5]};
}

std::vector<double> Coefficients(const YAML::Node& root) {
  const std::string key = FindKey(root, kDistortionKeys);
  if (key.empty())
    throw InputError(
        "'distortion_coefficients' is missing; write 5 zeros if "
        "there is no distortion");
  const StoredMatrix matrix = ParseStoredMatrix(root[key], key);
  if (std::min(matrix.rows, matrix.columns) != 1)
    throw InputError(fmt::format("{}: neither a row nor a column", key));
  return matrix.data;
}

const LensForm& FormNamed(const std::string& name) {
  for (const LensForm& form : OpenCvForms())
    if (form.name == name) return form;
  throw InputError(
      fmt::format("unknown distortion model '{}'; OpenCV's are "
                  "opencv4, opencv5, opencv8, opencv12, opencv14 "
                  "and fisheye",
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

// The form that the user or the file tells, or else the number of
// coefficients.
const LensForm& FormSaid(const YAML::Node& root, const ReadRequest& request,
                         size_t count, std::vector<std::string>* remarks) {
  if (!request.form.empty()) return FormNamed(request.form);
  const std::string model = TextOf(root, {"distortion_model"});
  if (model == kFisheye || model == "equidistant" ||
      TextOf(root, {"fisheye_model"}) == "1")
    return FormNamed(kFisheye);
  if (!model.empty() && model != "plumb_bob" && model != "rational_polynomial")
    return FormNamed(model);
  if (count == 4 && !root["fisheye_model"])
    remarks->push_back(
        "its 4 coefficients are taken for k1, k2, p1, p2 of a pinhole; those "
        "of cv::fisheye are imported with --model fisheye");
  return FormOfCount(count);
}

// OpenCV's 12 or 14 coefficients that are those of 8.
LensInForm Shortened(const LensInForm& lens) {
  if (lens.form->model != "opencv-14") return lens;
  LensInForm shorter = lens;
  shorter.form = &FormNamed("opencv8");
  const size_t count = shorter.form->parameters.size();
  for (size_t k = count; k < lens.values.size(); ++k)
    if (lens.values[k] != 0) return lens;
  shorter.values.resize(count);
  return shorter;
}

// R and T of stereoCalibrate: the pose of the first camera's frame, or a rig's.
std::optional<Pose> PoseOfCamera(const YAML::Node& root) {
  if (!root["R"] || !root["T"]) return std::nullopt;
  const StoredMatrix r = ParseStoredMatrix(root["R"], "R"),
                     t = ParseStoredMatrix(root["T"], "T");
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

ExchangeContents ReadOpenCv(const ReadRequest& request) {
  const YAML::Node root = ParseFileStorage(request.path, request.text);
  if (!root.IsMap()) throw InputError("no camera: no map of keys");
  if (FindKey(root, kMatrixKeys).empty() && root[kPointsKey])
    return ReadCornersAlone(root, request);
  ExchangeContents contents;
  ReadLens camera;
  camera.name = TextOf(root, kNameKeys);
  camera.serial = TextOf(root, {"serial"});
  camera.lens.size = SizeOfImages(root, request);
  camera.camera_from_rig = PoseOfCamera(root);
  TakeFeatures(root, request, &camera);
  camera.poses = PosesOf(root);
  camera.lens.values = Intrinsics(root);
  std::vector<double> coefficients = Coefficients(root);
  camera.lens.form =
      &FormSaid(root, request, coefficients.size(), &contents.remarks);
  if (coefficients.empty()) coefficients.assign(4, 0);
  camera.lens.values.insert(camera.lens.values.end(), coefficients.begin(),
                            coefficients.end());
  if (camera.lens.values.size() == camera.lens.form->parameters.size())
    camera.lens = Shortened(camera.lens);
  contents.cameras.push_back(camera);
  return contents;
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
  text.Add("fisheye_model", lens.form->name == kFisheye ? 1 : 0);
  if (camera.fit) AddFit(*camera.fit, &text);
  text.Add("camera_matrix",
           StoredMatrix{3,
                        3,
                        {lens.Value("fx"), 0, lens.Value("cx"), 0,
                         lens.Value("fy"), lens.Value("cy"), 0, 0, 1}});
  const std::vector<double> coefficients = lens.ValuesFrom(4);
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

Format OpenCvFormat() {
  Format format;
  format.name = "opencv";
  format.holds =
      "FileStorage .yaml, .xml or .json: a pinhole with 4, 5, 8, 12 or 14 "
      "coefficients, or cv::fisheye; of a rig a file for each camera, with R "
      "and T of its pose; poses and corners of boards, also corners alone";
  format.forms = OpenCvForms();
  format.holds_poses = true;
  format.may_take_board = true;
  format.recognizes = IsFileStorage;
  format.read = ReadOpenCv;
  format.write = WriteOpenCv;
  return format;
}

}  // namespace raygrid
