#include "exchange/colmap_format.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "dataset/error.h"
#include "dataset/text_encoding.h"
#include "dataset/yaml_file.h"
#include "exchange/colmap_files.h"
#include "exchange/nearest_grid.h"
#include "exchange/opencv_model_list.h"

namespace raygrid {
namespace {

ExternalModel MakeColmapModel(ExternalModel external_model,
                              bool export_only_if_named) {
  external_model.origin = PixelOrigin::kImageCorner;
  external_model.max_supported_angle_rad = M_PI / 2;
  external_model.export_only_if_named = export_only_if_named;
  return external_model;
}

// COLMAP's fisheye models normalize by z like OpenCV's. Models with one focal
// length are special cases of others; COLMAP before version 4 lacks the last
// three models.
std::vector<ExternalModel> MakeColmapModels() {
  const std::string fisheye = models::kThinPrismFisheye;
  std::vector<ExternalModel> external_models = {
      MakeColmapModel(MakeOpenCvModel("PINHOLE", 0), false),
      MakeColmapModel(MakeOpenCvModel("OPENCV", 4), false),
      MakeColmapModel(MakeOpenCvModel("FULL_OPENCV", 8), false),
      MakeColmapModel(MakeOpenCvFisheyeModel("OPENCV_FISHEYE"), false),
      MakeColmapModel(
          MakeExternalModel("THIN_PRISM_FISHEYE", fisheye,
                            {"k1", "k2", "p1", "p2", "k3", "k4", "sx1", "sy1"}),
          false)};
  const std::vector<ExternalModel> asked = {
      {"SIMPLE_PINHOLE", models::kOpenCv, {"f", "cx", "cy"}},
      {"SIMPLE_RADIAL", models::kOpenCv, {"f", "cx", "cy", "k1"}},
      {"RADIAL", models::kOpenCv, {"f", "cx", "cy", "k1", "k2"}},
      {"SIMPLE_RADIAL_FISHEYE", fisheye, {"f", "cx", "cy", "k1"}},
      {"RADIAL_FISHEYE", fisheye, {"f", "cx", "cy", "k1", "k2"}},
      {"SIMPLE_FISHEYE", fisheye, {"f", "cx", "cy"}},
      {"FISHEYE", fisheye, {"fx", "fy", "cx", "cy"}},
      MakeExternalModel("EUCM", models::kEucm, {"alpha", "beta"})};
  for (const ExternalModel& external_model : asked)
    external_models.push_back(MakeColmapModel(external_model, true));
  return external_models;
}

const std::vector<ExternalModel>& GetColmapModels() {
  static const std::vector<ExternalModel> external_models = MakeColmapModels();
  return external_models;
}

const ExternalModel& FindColmapModel(const ColmapCamera& camera) {
  std::string names;
  for (const ExternalModel& external_model : GetColmapModels()) {
    if (external_model.name == camera.model) return external_model;
    names += (names.empty() ? "" : ", ") + external_model.name;
  }
  const std::vector<std::string>& known = ColmapModelNames();
  const bool is_known =
      std::find(known.begin(), known.end(), camera.model) != known.end();
  throw InputError(fmt::format(
      "camera {}: {} {}; supported are {}", camera.id, Printable(camera.model),
      is_known ? "is a COLMAP model that is not supported"
               : "is not a COLMAP model",
      names));
}

// Project Aria's fisheye model: k0 to k5 are radial coefficients in the
// incidence angle, p0 and p1 tangential, s0 to s3 thin-prism coefficients.
// raygrid has no equivalent model.
constexpr char kAriaFisheye[] = "RAD_TAN_THIN_PRISM_FISHEYE";

// Projects a direction, given as incidence angle times unit direction, to
// normalized image coordinates.
Eigen::Vector2d ProjectAria(const Eigen::Vector2d& angle, const double* d) {
  const double t2 = angle.squaredNorm();
  double factor = 0;
  for (int k = 5; k >= 0; --k) factor = (factor + d[k]) * t2;
  const Eigen::Vector2d xy = angle * (1 + factor), p(d[6], d[7]);
  const double r2 = xy.squaredNorm(), r4 = r2 * r2;
  return xy + 2 * xy.dot(p) * xy + r2 * p +
         Eigen::Vector2d(d[8] * r2 + d[9] * r4, d[10] * r2 + d[11] * r4);
}

// Inverts the projection by Newton's method, starting at the image point;
// nullopt if it leaves the half-space in front of the camera or the Jacobian
// becomes singular.
std::optional<Eigen::Vector3d> AriaDirection(const Eigen::Vector2d& place,
                                             const double* d) {
  constexpr double kStep = 1e-6, kNear = 1e-12;
  Eigen::Vector2d angle = place;
  for (int round = 0; round < 50; ++round) {
    const Eigen::Vector2d off = ProjectAria(angle, d) - place;
    Eigen::Matrix2d jacobian;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(k);
      jacobian.col(k) =
          (ProjectAria(angle + step, d) - ProjectAria(angle - step, d)) /
          (2 * kStep);
    }
    if (!(jacobian.determinant() > 0)) return std::nullopt;
    angle -= jacobian.inverse() * off;
    const double theta = angle.norm();
    if (!(theta < M_PI)) return std::nullopt;
    if (off.norm() > kNear) continue;
    if (theta >= M_PI / 2) return std::nullopt;
    const double sine = theta > 0 ? std::sin(theta) / theta : 1;
    return Eigen::Vector3d(angle.x() * sine, angle.y() * sine, std::cos(theta));
  }
  return std::nullopt;
}

ConvertedCamera ReadAriaFisheye(const ColmapCamera& camera,
                                std::vector<std::string>* warnings) {
  const std::vector<double>& values = camera.parameters;
  if (values.size() != 16)
    throw InputError(fmt::format("camera {}: {}: expected 16 numbers, found {}",
                                 camera.id, kAriaFisheye, values.size()));
  if (!(values[0] > 0 && values[1] > 0))
    throw InputError("focal lengths must be positive");
  return FitNearestGrid(
      camera.size,
      [&](const Eigen::Vector2d& pixel) {
        const Eigen::Vector2d at =
            ToProgram(PixelOrigin::kImageCorner, camera.size, pixel);
        return AriaDirection({(at.x() - values[2]) / values[0],
                              (at.y() - values[3]) / values[1]},
                             values.data() + 4);
      },
      fmt::format("camera {} is a {}, which has no equivalent model", camera.id,
                  kAriaFisheye),
      warnings);
}

bool IsBinaryPath(const std::string& path) {
  return std::filesystem::path(path).extension() == ".bin";
}

// Returns the path of a companion file: "m/rigs.txt" for "m/cameras.txt".
std::string MakeCompanionPath(const std::string& path,
                              const std::string& stem) {
  return std::filesystem::path(path)
      .replace_filename(stem + (IsBinaryPath(path) ? ".bin" : ".txt"))
      .string();
}

// In the order of ReadRequest::beside.
std::vector<std::string> MakeCompanionPaths(const std::string& path) {
  return {MakeCompanionPath(path, "rigs"), MakeCompanionPath(path, "images")};
}

// Returns the only rig with several cameras if it contains all cameras with
// their poses; otherwise an empty rig, with a warning if any rig has several
// cameras.
ColmapRig FindColmapRig(const std::vector<ColmapRig>& rigs, size_t num_cameras,
                        std::vector<std::string>* warnings) {
  std::vector<ColmapRig> large_rigs;
  for (const ColmapRig& rig : rigs)
    if (rig.size() > 1) large_rigs.push_back(rig);
  if (large_rigs.empty()) return {};
  const bool has_poses =
      std::all_of(large_rigs.front().begin(), large_rigs.front().end(),
                  [](const ColmapSensor& sensor) {
                    return sensor.sensor_from_rig.has_value();
                  });
  if (large_rigs.size() == 1 && large_rigs.front().size() == num_cameras &&
      has_poses)
    return large_rigs.front();
  warnings->push_back(
      "rig poses are ignored, since they do not cover all cameras in one rig");
  return {};
}

size_t GetCameraIndex(uint32_t id, const std::vector<ColmapCamera>& cameras,
                      const std::string& owner) {
  for (size_t c = 0; c < cameras.size(); ++c)
    if (cameras[c].id == id) return c;
  throw InputError(
      fmt::format("{} refers to camera {}, which does not exist", owner, id));
}

void SetPoses(const ColmapRig& rig, const std::vector<ColmapCamera>& cameras,
              ExchangeContents* contents) {
  for (const ColmapSensor& sensor : rig)
    contents->cameras[GetCameraIndex(sensor.camera, cameras, "a rig")]
        .camera_from_rig = sensor.sensor_from_rig;
}

// Removes the camera's folder from an image name: "left/1.png" becomes "1.png"
// for camera "left".
std::string RemoveCameraFolder(const std::string& image,
                               const std::string& camera) {
  const std::string folder = camera + "/";
  return !camera.empty() && image.rfind(folder, 0) == 0
             ? image.substr(folder.size())
             : image;
}

// The world frame is a target's frame. COLMAP writes images in any order.
void AddImages(std::vector<ColmapImage> images,
               const std::vector<ColmapCamera>& cameras,
               ExchangeContents* contents) {
  std::stable_sort(
      images.begin(), images.end(),
      [](const ColmapImage& a, const ColmapImage& b) { return a.id < b.id; });
  for (const ColmapImage& image : images) {
    InputCamera& camera = contents->cameras[GetCameraIndex(
        image.camera, cameras,
        fmt::format("image '{}'", Printable(image.name)))];
    RequireStorableName("image", image.name);
    camera.poses.push_back({cameras.size() > 1
                                ? RemoveCameraFolder(image.name, camera.name)
                                : image.name,
                            0, image.camera_from_world});
  }
}

void ReadCompanionFiles(const ReadRequest& request, bool is_text,
                        const std::vector<ColmapCamera>& cameras,
                        ExchangeContents* contents) {
  if (request.beside.size() != 2) return;
  const auto take = [&](const char* stem, const std::string& text,
                        const auto& parse, const auto& decode,
                        const auto& add) {
    const std::string path = MakeCompanionPath(request.path, stem);
    if (text.empty()) return;
    ReadNamingFile(path,
                   [&] { add(is_text ? parse(path, text) : decode(text)); });
  };
  take("rigs", request.beside[0], ParseColmapRigs, DecodeColmapRigs,
       [&](const std::vector<ColmapRig>& rigs) {
         SetPoses(FindColmapRig(rigs, cameras.size(), &contents->warnings),
                  cameras, contents);
       });
  take("images", request.beside[1], ParseColmapImages, DecodeColmapImages,
       [&](const std::vector<ColmapImage>& images) {
         AddImages(images, cameras, contents);
       });
}

ExchangeContents ReadColmap(const ReadRequest& request) {
  const bool is_text = IsColmapText(request.text);
  const std::vector<ColmapCamera> cameras =
      is_text ? ParseColmapCameras(request.path, request.text)
              : DecodeColmapCameras(request.text);
  if (cameras.empty()) throw InputError("contains no camera");
  ExchangeContents contents;
  std::set<uint32_t> ids;
  for (const ColmapCamera& camera : cameras) {
    if (!ids.insert(camera.id).second)
      throw InputError(fmt::format("duplicate camera {}", camera.id));
    InputCamera read;
    read.name = camera.name.empty() && cameras.size() > 1
                    ? fmt::format("camera{}", camera.id)
                    : camera.name;
    read.serial = camera.serial;
    read.lens = camera.model == kAriaFisheye
                    ? ReadAriaFisheye(camera, &contents.warnings)
                    : ConvertedCamera{&FindColmapModel(camera), camera.size,
                                      camera.parameters};
    contents.cameras.push_back(std::move(read));
  }
  ReadCompanionFiles(request, is_text, cameras, &contents);
  return contents;
}

std::string WriteColmap(const WriteRequest& request) {
  std::vector<ColmapCamera> cameras;
  for (const OutputCamera& camera : request.cameras)
    cameras.push_back({static_cast<uint32_t>(cameras.size() + 1),
                       camera.lens.external_model->name, camera.lens.size,
                       camera.lens.values, camera.name, camera.serial,
                       camera.fit ? FormatModelFit(*camera.fit) : ""});
  return IsBinaryPath(request.path) ? EncodeColmapCameras(cameras)
                                    : FormatColmapCameras(cameras);
}

// COLMAP's rig frame is the frame of its reference sensor, the first camera.
ColmapRig MakeColmapRig(const std::vector<OutputCamera>& cameras) {
  const Pose rig_from_first = cameras.front().camera_from_rig.value().Inverse();
  ColmapRig rig;
  for (const OutputCamera& camera : cameras)
    rig.push_back({static_cast<uint32_t>(rig.size() + 1),
                   *camera.camera_from_rig * rig_from_first});
  return rig;
}

// Images of several cameras are in folders named after the cameras.
std::vector<ColmapImage> MakeColmapImages(
    const std::vector<OutputCamera>& cameras) {
  std::vector<ColmapImage> images;
  for (size_t c = 0; c < cameras.size(); ++c)
    for (const BoardPose& pose : cameras[c].poses)
      images.push_back(
          {static_cast<uint32_t>(images.size() + 1),
           static_cast<uint32_t>(c + 1),
           (cameras.size() > 1 ? cameras[c].name + "/" : "") + pose.image,
           pose.camera_from_board});
  return images;
}

// Groups images of the same name into frames. images: result of
// MakeColmapImages().
std::vector<ColmapFrame> GroupIntoFrames(
    const std::vector<ColmapImage>& images,
    const std::vector<OutputCamera>& cameras) {
  const ColmapRig rig = MakeColmapRig(cameras);
  std::vector<ColmapFrame> frames;
  std::map<std::string, size_t> by_name;
  for (const ColmapImage& image : images) {
    const size_t camera = image.camera - 1;
    const auto [at, is_new] = by_name.emplace(
        RemoveCameraFolder(image.name, cameras[camera].name), frames.size());
    if (is_new)
      frames.push_back(
          {rig[camera].sensor_from_rig->Inverse() * image.camera_from_world,
           {}});
    frames[at->second].images.emplace_back(image.camera, image.id);
  }
  return frames;
}

// COLMAP requires a points file, so an empty one is written. The points and
// images of an existing reconstruction are never overwritten. Since version
// 3.12, COLMAP also requires frames if there are rigs.
std::vector<CompanionFile> WriteColmapCompanions(const WriteRequest& request) {
  std::vector<CompanionFile> files;
  const bool is_binary = IsBinaryPath(request.path);
  const auto add = [&](const char* stem, const auto& encode, const auto& format,
                       const auto&... what) {
    files.push_back({MakeCompanionPath(request.path, stem),
                     is_binary ? encode(what...) : format(what...)});
  };
  RequireOneBoard("COLMAP", request.cameras);
  const bool is_rig = request.cameras.front().camera_from_rig.has_value();
  if (is_rig)
    add("rigs", EncodeColmapRig, FormatColmapRig,
        MakeColmapRig(request.cameras));
  const std::vector<ColmapImage> images = MakeColmapImages(request.cameras);
  if (images.empty()) return files;
  if (is_rig)
    add("frames", EncodeColmapFrames, FormatColmapFrames,
        GroupIntoFrames(images, request.cameras));
  add("images", EncodeColmapImages, FormatColmapImages, images);
  add("points3D", EncodeNoColmapPoints, FormatNoColmapPoints);
  files.back().is_never_replaced = true;
  return files;
}

}  // namespace

Format MakeColmapFormat() {
  Format format;
  format.name = "colmap";
  format.holds =
      "cameras.txt or cameras.bin; rigs with rigs.txt or rigs.bin; poses of a "
      "board as images.txt or images.bin";
  format.external_models = GetColmapModels();
  format.supports_rigs = true;
  format.recognizes = [](const std::string& text) {
    return IsColmapText(text) || IsColmapBinary(text);
  };
  format.read = ReadColmap;
  format.write = WriteColmap;
  format.supports_poses = true;
  format.beside = MakeCompanionPaths;
  format.write_beside = WriteColmapCompanions;
  return format;
}

}  // namespace raygrid
