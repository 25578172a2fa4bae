#include <fmt/format.h>

#include "dataset/byte_reader.h"
#include "dataset/error.h"
#include "exchange/colmap_files.h"
#include "exchange/yaml_numbers.h"

namespace raygrid {
namespace {

constexpr int32_t kCameraSensor = 0;
constexpr uint64_t kMaxCameras = 1000000, kMaxSidePx = 1000000;

int GetSide(uint64_t side) {
  if (side < 1 || side > kMaxSidePx)
    throw InputError(fmt::format("invalid image width or height {}", side));
  return static_cast<int>(side);
}

Pose GetPose(ByteReader* reader) {
  std::array<double, 7> numbers;
  for (double& number : numbers) number = reader->GetFinite();
  return PoseFromQuaternion(numbers);
}

void AppendPose(const Pose& pose, std::string* bytes) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  for (const double number : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()})
    Append(number, bytes);
}

ColmapRig DecodeRig(ByteReader* reader) {
  ColmapRig rig;
  reader->Get<uint32_t>();
  const auto count = reader->Get<uint32_t>();
  for (uint32_t k = 0; k < count; ++k) {
    const bool is_camera = reader->Get<int32_t>() == kCameraSensor;
    ColmapSensor sensor;
    sensor.camera = reader->Get<uint32_t>();
    if (k == 0) {
      sensor.sensor_from_rig = Pose{};
    } else if (reader->Get<uint8_t>() != 0) {
      sensor.sensor_from_rig = GetPose(reader);
    }
    if (is_camera) rig.push_back(sensor);
  }
  return rig;
}

}  // namespace

const std::vector<std::string>& ColmapModelNames() {
  static const std::vector<std::string> names = {"SIMPLE_PINHOLE",
                                                 "PINHOLE",
                                                 "SIMPLE_RADIAL",
                                                 "RADIAL",
                                                 "OPENCV",
                                                 "OPENCV_FISHEYE",
                                                 "FULL_OPENCV",
                                                 "FOV",
                                                 "SIMPLE_RADIAL_FISHEYE",
                                                 "RADIAL_FISHEYE",
                                                 "THIN_PRISM_FISHEYE",
                                                 "RAD_TAN_THIN_PRISM_FISHEYE",
                                                 "SIMPLE_DIVISION",
                                                 "DIVISION",
                                                 "SIMPLE_FISHEYE",
                                                 "FISHEYE",
                                                 "EUCM",
                                                 "EQUIRECTANGULAR"};
  return names;
}

int NumColmapParameters(const std::string& model) {
  static const int counts[] = {3, 4,  4,  5, 8, 8, 12, 5, 4,
                               5, 12, 16, 4, 5, 3, 4,  6, 2};
  const std::vector<std::string>& names = ColmapModelNames();
  return counts[std::find(names.begin(), names.end(), model) - names.begin()];
}

bool IsColmapBinary(const std::string& bytes) {
  constexpr int kMaxModels = 256;
  if (bytes.size() < 32) return false;
  ByteReader reader(bytes);
  const auto count = reader.Get<uint64_t>();
  reader.Get<uint32_t>();
  const auto model = reader.Get<int32_t>();
  const auto width = reader.Get<uint64_t>(), height = reader.Get<uint64_t>();
  return count >= 1 && count <= kMaxCameras && model >= 0 &&
         model < kMaxModels && width >= 1 && width <= kMaxSidePx &&
         height >= 1 && height <= kMaxSidePx;
}

std::vector<ColmapCamera> DecodeColmapCameras(const std::string& bytes) {
  ByteReader reader(bytes);
  const auto count = reader.Get<uint64_t>();
  std::vector<ColmapCamera> cameras;
  for (uint64_t k = 0; k < count; ++k) {
    ColmapCamera camera;
    camera.id = reader.Get<uint32_t>();
    const auto model = reader.Get<int32_t>();
    const std::vector<std::string>& names = ColmapModelNames();
    if (model < 0 || model >= static_cast<int32_t>(names.size()))
      throw InputError(
          fmt::format("camera {}: unknown model {}", camera.id, model));
    camera.model = names[model];
    camera.size.width = GetSide(reader.Get<uint64_t>());
    camera.size.height = GetSide(reader.Get<uint64_t>());
    for (int n = NumColmapParameters(camera.model); n > 0; --n)
      camera.parameters.push_back(reader.GetFinite());
    cameras.push_back(std::move(camera));
  }
  reader.RequireEnd();
  return cameras;
}

std::vector<ColmapRig> DecodeColmapRigs(const std::string& bytes) {
  ByteReader reader(bytes);
  std::vector<ColmapRig> rigs;
  for (auto count = reader.Get<uint64_t>(); count > 0; --count)
    rigs.push_back(DecodeRig(&reader));
  reader.RequireEnd();
  return rigs;
}

std::string EncodeColmapCameras(const std::vector<ColmapCamera>& cameras) {
  const std::vector<std::string>& names = ColmapModelNames();
  std::string bytes;
  Append<uint64_t>(cameras.size(), &bytes);
  for (const ColmapCamera& camera : cameras) {
    Append<uint32_t>(camera.id, &bytes);
    Append<int32_t>(
        std::find(names.begin(), names.end(), camera.model) - names.begin(),
        &bytes);
    Append<uint64_t>(camera.size.width, &bytes);
    Append<uint64_t>(camera.size.height, &bytes);
    for (const double number : camera.parameters) Append(number, &bytes);
  }
  return bytes;
}

std::string EncodeColmapRig(const ColmapRig& rig) {
  std::string bytes;
  Append<uint64_t>(1, &bytes);
  Append<uint32_t>(1, &bytes);
  Append<uint32_t>(rig.size(), &bytes);
  for (size_t k = 0; k < rig.size(); ++k) {
    Append<int32_t>(kCameraSensor, &bytes);
    Append<uint32_t>(rig[k].camera, &bytes);
    if (k == 0) continue;
    Append<uint8_t>(1, &bytes);
    AppendPose(rig[k].sensor_from_rig.value(), &bytes);
  }
  return bytes;
}

std::vector<ColmapImage> DecodeColmapImages(const std::string& bytes) {
  constexpr size_t kPointSize = 24;  // x, y, 3D point ID
  ByteReader reader(bytes);
  std::vector<ColmapImage> images;
  for (auto count = reader.Get<uint64_t>(); count > 0; --count) {
    ColmapImage image;
    image.id = reader.Get<uint32_t>();
    image.camera_from_world = GetPose(&reader);
    image.camera = reader.Get<uint32_t>();
    image.name = reader.GetText();
    reader.Skip(reader.Get<uint64_t>(), kPointSize);
    images.push_back(std::move(image));
  }
  reader.RequireEnd();
  return images;
}

std::string EncodeColmapImages(const std::vector<ColmapImage>& images) {
  std::string bytes;
  Append<uint64_t>(images.size(), &bytes);
  for (const ColmapImage& image : images) {
    Append<uint32_t>(image.id, &bytes);
    AppendPose(image.camera_from_world, &bytes);
    Append<uint32_t>(image.camera, &bytes);
    bytes += image.name + '\0';
    Append<uint64_t>(0, &bytes);
  }
  return bytes;
}

std::string EncodeColmapFrames(const std::vector<ColmapFrame>& frames) {
  std::string bytes;
  Append<uint64_t>(frames.size(), &bytes);
  for (size_t k = 0; k < frames.size(); ++k) {
    Append<uint32_t>(k + 1, &bytes);
    Append<uint32_t>(1, &bytes);
    AppendPose(frames[k].rig_from_world, &bytes);
    Append<uint32_t>(frames[k].images.size(), &bytes);
    for (const auto& [camera, image] : frames[k].images) {
      Append<int32_t>(kCameraSensor, &bytes);
      Append<uint32_t>(camera, &bytes);
      Append<uint64_t>(image, &bytes);
    }
  }
  return bytes;
}

std::string EncodeNoColmapPoints() {
  std::string bytes;
  Append<uint64_t>(0, &bytes);
  return bytes;
}

}  // namespace raygrid
