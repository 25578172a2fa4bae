#include "libcamera_source.h"

#include <libcamera/logging.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "camera_error.h"
#include "libcamera_controls.h"
#include "libcamera_state.h"
#include "libcamera_version.h"

namespace raygrid {
namespace {

using libcamera::Camera;
using libcamera::CameraConfiguration;
using libcamera::PixelFormat;
using libcamera::Request;
using libcamera::StreamConfiguration;
using libcamera::StreamRole;

constexpr unsigned kNumBuffers = 4;
// The time for a frame whose request restores automatic modes at the end.
constexpr std::chrono::seconds kUnlockPatience(1);

CameraError InputError(const std::string& message) {
  return CameraError(CameraExit::kInput, message);
}

std::string GetName(const Camera& camera) {
  const auto model = GetModelName(camera);
  return model ? camera.id() + " (" + *model + ")" : camera.id();
}

// "  YUYV 640x480 1280x720"
std::string DescribeFormats(const StreamConfiguration& stream) {
  std::string text;
  for (const PixelFormat& format : stream.formats().pixelformats()) {
    text += "  " + format.toString();
    for (const libcamera::Size& size : stream.formats().sizes(format))
      text += " " + size.toString();
    if (!FindPixelFormat(format.toString())) text += " (not supported)";
    text += "\n";
  }
  return text;
}

std::string DescribeRole(Camera* camera, StreamRole role) {
  const auto configuration = GenerateConfiguration(camera, role);
  if (!configuration || configuration->empty()) return "";
  return DescribeFormats(configuration->at(0));
}

std::string DescribeCamera(Camera* camera) {
  const std::string viewfinder = DescribeRole(camera, StreamRole::Viewfinder);
  const std::string raw = DescribeRole(camera, StreamRole::Raw);
  return "libcamera:" + GetName(*camera) + "\n" + viewfinder +
         (raw == viewfinder ? "" : raw) + DescribeControls(camera->controls());
}

// Returns the requested format; without request, the camera's default or else
// the first of its formats that the runtime supports.
PixelFormat ChooseFormat(const StreamConfiguration& stream,
                         const std::string& name) {
  std::vector<PixelFormat> candidates = stream.formats().pixelformats();
  candidates.insert(candidates.begin(), stream.pixelFormat);
  for (const PixelFormat& format : candidates)
    if (name.empty() ? FindPixelFormat(format.toString()) != nullptr
                     : format.toString() == name)
      return format;
  const std::string other = DescribeOtherName(name);
  throw InputError("camera: has no pixel format " +
                   (name.empty() ? "that can be undistorted" : name) + "; " +
                   (other.empty() ? "see --list" : other));
}

bool IsRaw(const std::string& name) {
  const PixelFormatInfo* const info = FindPixelFormat(name);
  return info && info->model == ColourModel::kBayer;
}

void TakeMetadata(Request* completed, FrameInfo* info) {
  const auto& metadata = completed->metadata();
  info->lens_position = metadata.get(libcamera::controls::LensPosition);
  info->sensor_temperature_c =
      metadata.get(libcamera::controls::SensorTemperature);
  if (const auto exposure = metadata.get(libcamera::controls::ExposureTime))
    info->exposure_us = static_cast<float>(*exposure);
  info->analogue_gain = metadata.get(libcamera::controls::AnalogueGain);
  if (const auto crop = metadata.get(libcamera::controls::ScalerCrop))
    info->crop = SensorCrop{crop->x, crop->y, crop->width, crop->height};
}

}  // namespace

CameraList::CameraList() {
  // Errors are reported once, by this library. The variable enables libcamera's
  // messages.
  if (!std::getenv("LIBCAMERA_LOG_LEVELS"))
    libcamera::logSetTarget(libcamera::LoggingTargetNone);
  manager_ = std::make_unique<libcamera::CameraManager>();
  const int status = manager_->start();
  if (status < 0)
    throw InputError(std::string("libcamera: failed to start: ") +
                     std::strerror(-status) +
                     "; set LIBCAMERA_LOG_LEVELS=*:DEBUG for details");
}

std::string CameraList::Describe() const {
  std::string text;
  for (const auto& camera : manager_->cameras())
    text += DescribeCamera(camera.get());
  return text;
}

std::shared_ptr<Camera> CameraList::Find(const std::string& id) const {
  std::vector<std::shared_ptr<Camera>> found;
  for (const auto& camera : manager_->cameras()) {
    if (camera->id() == id) return camera;
    if (camera->id().find(id) != std::string::npos) found.push_back(camera);
  }
  if (found.size() == 1) return found[0];
  if (manager_->cameras().empty())
    throw InputError(
        "camera: none found by libcamera; connect one, check that udevd is "
        "running, or use --source v4l2");
  const std::string what = id.empty()      ? "several found"
                           : found.empty() ? "none named " + id
                                           : "several named " + id;
  throw InputError("camera: " + what +
                   "; select one with --camera ID (see --list)");
}

LibcameraSource::LibcameraSource(std::shared_ptr<Camera> camera,
                                 const LibcameraOptions& options)
    : camera_(std::move(camera)) {
  const int status = camera_->acquire();
  if (status == -EBUSY)
    throw InputError("camera: in use by another process; stop it first");
  if (status < 0)
    throw InputError(std::string("camera: cannot be acquired: ") +
                     std::strerror(-status) + "; reconnect it");
  try {
    Configure(options);
    controls_ = MakeControlList(camera_->controls(), options.controls);
    Allocate();
  } catch (...) {
    Free();
    throw;
  }
  queue_ = std::make_unique<BoundedQueue<CapturedFrame>>(
      options.every_frame ? requests_.size()
                          : std::max<size_t>(requests_.size() / 2, 1));
}

LibcameraSource::~LibcameraSource() {
  Stop();
  Free();
}

void LibcameraSource::Free() {
  requests_.clear();
  buffers_.reset();
  allocator_.reset();
  camera_->release();
}

void LibcameraSource::Configure(const LibcameraOptions& options) {
  configuration_ = GenerateConfiguration(
      camera_.get(),
      IsRaw(options.format) ? StreamRole::Raw : StreamRole::Viewfinder);
  if (!configuration_ || configuration_->empty())
    throw InputError("camera: has no such stream; see --list");
  StreamConfiguration& stream = configuration_->at(0);
  stream.pixelFormat = ChooseFormat(stream, options.format);
  stream.size = libcamera::Size(options.width, options.height);
  stream.bufferCount = std::max(stream.bufferCount, kNumBuffers);
  const bool is_valid =
      configuration_->validate() != CameraConfiguration::Invalid;
  if (!is_valid || camera_->configure(configuration_.get()) < 0)
    throw InputError("camera: does not support " + stream.toString() +
                     "; use a size from --list");
  orientation_ = GetOrientation(*configuration_);
  // ScalerCropMaximum applies to the sensor mode, which may already be cropped.
  const auto areas =
      camera_->properties().get(libcamera::properties::PixelArrayActiveAreas);
  if (areas && !areas->empty()) widest_ = (*areas)[0].width;
  const std::string name = stream.pixelFormat.toString();
  const PixelFormatInfo* const info = FindPixelFormat(name);
  if (!info || (!options.format.empty() && name != options.format))
    throw InputError("camera: delivers " + name +
                     " at that size; use another --format from --list");
  format_ = MakeStreamFormat(*info, stream.size.width, stream.size.height,
                             stream.stride);
  format_.is_full_range =
      stream.colorSpace &&
      stream.colorSpace->range == libcamera::ColorSpace::Range::Full;
}

void LibcameraSource::Allocate() {
  libcamera::Stream* const stream = configuration_->at(0).stream();
  allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
  if (allocator_->allocate(stream) < 0)
    throw InputError("camera: cannot allocate frame buffers; free some memory");
  const auto& buffers = allocator_->buffers(stream);
  buffers_ = std::make_unique<MappedBuffers>(format_, buffers);
  for (const auto& buffer : buffers) {
    requests_.push_back(camera_->createRequest(requests_.size()));
    if (!requests_.back() ||
        requests_.back()->addBuffer(stream, buffer.get()) < 0)
      throw InputError("camera: does not accept requests; reconnect it");
  }
}

void LibcameraSource::Start() {
  camera_->requestCompleted.connect(this, &LibcameraSource::OnCompleted);
  camera_->disconnected.connect(this, &LibcameraSource::OnDisconnected);
  if (camera_->start(&controls_) < 0) {
    camera_->requestCompleted.disconnect(this);
    camera_->disconnected.disconnect(this);
    throw InputError(
        "camera: failed to start; check that it is connected and not in use");
  }
  is_running_ = true;
  // Pipelines without controls at the start, such as that of USB cameras,
  // accept those of a request.
  for (const auto& [id, value] : controls_)
    requests_[0]->controls().set(id, value);
  for (const auto& request : requests_) Queue(request.get());
}

std::optional<CapturedFrame> LibcameraSource::Next(
    std::chrono::milliseconds timeout) {
  return queue_->Pop(timeout);
}

void LibcameraSource::Release(const CapturedFrame& frame) {
  buffers_->EndRead(frame.buffer);
  QueueAgain(frame.buffer);
}

std::string LibcameraSource::fault() const {
  return is_disconnected_ ? "camera: disconnected; reconnect it" : "";
}

SourceCounts LibcameraSource::counts() const {
  return {arrived_, dropped_, damaged_, missed_};
}

StateLock LibcameraSource::LockState() {
  const std::lock_guard<std::mutex> lock(state_mutex_);
  if (is_disconnected_ || (last_info_ && !is_running_))
    return MakeUnlockedState("the stream has ended");
  if (!last_info_) return MakeUnlockedState("no frame received yet");
  FrameInfo info = *last_info_;
  if (focus_.lens_position) info.lens_position = focus_.lens_position;
  LibcameraLock state = MakeLibcameraLock(camera_->controls(), controls_, info);
  next_controls_ = std::move(state.lock_controls);
  unlock_controls_ = std::move(state.unlock_controls);
  return state.lock_state;
}

void LibcameraSource::FocusAt(const LensFocus& focus) {
  const std::lock_guard<std::mutex> lock(state_mutex_);
  focus_ = focus;
}

void LibcameraSource::UnlockState() {
  const std::lock_guard<std::mutex> lock(state_mutex_);
  // A lock that no request contains yet is dropped.
  if (!unlock_controls_.empty()) next_controls_ = std::move(unlock_controls_);
  unlock_controls_.clear();
}

// Cameras may retain their controls. The release is sent with a request, so one
// is queued once more.
void LibcameraSource::SendUnlock() {
  UnlockState();
  const Clock::time_point start = Clock::now();
  while (is_running_ && !is_disconnected_ &&
         Clock::now() - start < kUnlockPatience) {
    {
      const std::lock_guard<std::mutex> lock(state_mutex_);
      if (next_controls_.empty()) return;
    }
    if (const auto frame = queue_->Pop(std::chrono::milliseconds(20)))
      Release(*frame);
  }
}

void LibcameraSource::Stop() {
  SendUnlock();
  if (!is_running_.exchange(false)) return;
  camera_->stop();
  camera_->requestCompleted.disconnect(this);
  camera_->disconnected.disconnect(this);
  queue_->Close();
}

void LibcameraSource::Queue(Request* request) {
  if (!is_running_ || is_disconnected_) return;
  {
    const std::lock_guard<std::mutex> lock(state_mutex_);
    for (const auto& [id, value] : next_controls_)
      request->controls().set(id, value);
    next_controls_.clear();
  }
  camera_->queueRequest(request);
}

void LibcameraSource::QueueAgain(uint32_t buffer) {
  Request* const request = requests_[buffer].get();
  request->reuse(Request::ReuseBuffers);
  Queue(request);
}

void LibcameraSource::CountMissed(uint32_t sequence) {
  if (last_sequence_ && sequence > *last_sequence_)
    missed_ += sequence - *last_sequence_ - 1;
  last_sequence_ = sequence;
}

void LibcameraSource::OnCompleted(Request* request) {
  if (request->status() == Request::RequestCancelled) return;
  const auto& metadata = request->buffers().begin()->second->metadata();
  CountMissed(metadata.sequence);
  const uint32_t buffer = static_cast<uint32_t>(request->cookie());
  if (!IsWhole(format_, metadata) || !buffers_->BeginRead(buffer)) {
    ++damaged_;
    QueueAgain(buffer);
    return;
  }
  CapturedFrame frame = {};
  frame.arrived = Clock::now();
  frame.image = MakeImage(format_, buffers_->planes(buffer).data());
  frame.buffer = buffer;
  frame.info.sequence = metadata.sequence;
  frame.info.timestamp_ns = metadata.timestamp;
  TakeMetadata(request, &frame.info);
  if (orientation_ != 0) frame.info.orientation = orientation_;
  if (frame.info.crop && frame.info.crop->width > 0 && widest_ > 0)
    frame.info.zoom = double{1} * widest_ / frame.info.crop->width;
  {
    const std::lock_guard<std::mutex> lock(state_mutex_);
    last_info_ = frame.info;
  }
  ++arrived_;
  if (const auto dropped = queue_->Push(frame)) {
    ++dropped_;
    Release(*dropped);
  }
}

void LibcameraSource::OnDisconnected() {
  is_disconnected_ = true;
  queue_->Close();
}

}  // namespace raygrid
