#include "undistorted_bag.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "bags/message_writer.h"
#include "dataset/error.h"
#include "dataset/files.h"

namespace raygrid {
namespace {

CameraInfo MakeViewInfo(const std::string& path, const VirtualView& view) {
  if (view.projection != ViewProjection::kPinhole)
    throw Error(ExitCode::kUsage,
                path +
                    ": sensor_msgs/CameraInfo describes pinhole views only; "
                    "write images to a folder instead");
  const Eigen::Vector2d f = view.focal_px, c = view.center_px;
  CameraInfo info;
  info.width = static_cast<uint32_t>(view.size.width);
  info.height = static_cast<uint32_t>(view.size.height);
  info.model = "plumb_bob";
  info.d = {0, 0, 0, 0, 0};
  info.k = {f.x(), 0, c.x(), 0, f.y(), c.y(), 0, 0, 1};
  info.p = {f.x(), 0, c.x(), 0, 0, f.y(), c.y(), 0, 0, 0, 1, 0};
  for (int k = 0; k < 9; ++k)
    info.r.push_back(view.camera_from_view(k % 3, k / 3));
  return info;
}

}  // namespace

UndistortedBag::UndistortedBag(const std::string& path, const VirtualView& view)
    : info_(MakeViewInfo(path, view)),
      path_(path),
      temporary_(fmt::format("{}.part-{}", path, getpid())),
      file_(temporary_, std::ios::binary),
      writer_(&file_) {
  RequireWritten();
}

UndistortedBag::~UndistortedBag() { unlink(temporary_.c_str()); }

void UndistortedBag::RequireWritten() {
  if (!file_) ThrowWriteError(path_, errno ? errno : EIO);
}

void UndistortedBag::Finish() {
  writer_.Finish();
  file_.close();
  RequireWritten();
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0)
    ThrowWriteError(path_, errno);
}

void UndistortedBag::Add(const BagFrame& frame, const Image& image) {
  const auto [place, is_new] = topics_.try_emplace(frame.topic);
  if (is_new) {
    const std::string camera =
        frame.topic.substr(0, frame.topic.rfind('/') + 1);
    place->second = {
        writer_.AddTopic(camera + "image_rect", "sensor_msgs/msg/Image"),
        writer_.AddTopic(camera + "camera_info", "sensor_msgs/msg/CameraInfo")};
  }
  const MessageHeader header = {frame.stamp_ns, frame.frame_id};
  writer_.Write(place->second.info, frame.log_ns,
                WriteCameraInfo(header, info_));
  writer_.Write(place->second.image, frame.log_ns,
                WriteImageMessage(header, image));
  RequireWritten();
}

}  // namespace raygrid
