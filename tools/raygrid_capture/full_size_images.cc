#include "full_size_images.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "camera_error.h"
#include "downscaled_jpeg.h"
#include "jpeg_encoder.h"

namespace raygrid {
namespace {

constexpr size_t kMaxWaiting = 8;
constexpr size_t kChunkBytes = 64 * 1024;
constexpr char kTooMany[] = "too many requests; try again later\n";

// Encodes a picture; empty if it has no pixels or their number does not match
// its size.
std::vector<uint8_t> EncodeFullSize(const GreyBuffer& picture) {
  if (picture.width <= 0 || picture.height <= 0 ||
      picture.bytes.size() < size_t(picture.width) * size_t(picture.height))
    return {};
  try {
    const StreamFormat format = MakeGreyFormat(picture.width, picture.height);
    JpegEncoder encoder(format);
    const size_t size = encoder.Encode(
        MakeGreyImage(format, picture.bytes.data(), format.width));
    return {encoder.bytes(), encoder.bytes() + size};
  } catch (const CameraError&) {
    return {};  // exceeds the maximum frame size
  }
}

}  // namespace

struct FullSizeImages::Job {
  FullSizeImages* pictures;
  std::string name;
  MHD_Connection* connection;
  bool is_suspended = false, is_ready = false, is_gone = false;
  std::vector<uint8_t> jpeg;  // empty if it could not be read
  size_t sent = 0;
};

FullSizeImages::FullSizeImages(CapturePage::KeptFrameReader read)
    : read_(std::move(read)), worker_(&FullSizeImages::Work, this) {}

MHD_Result FullSizeImages::Answer(MHD_Connection* connection,
                                  const std::string& name) {
  auto job = std::make_shared<Job>();
  job->pictures = this;
  job->name = name;
  job->connection = connection;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_stopped_ || waiting_.size() >= kMaxWaiting)
      return AnswerText(connection, MHD_HTTP_SERVICE_UNAVAILABLE, "text/plain",
                        kTooMany);
    waiting_.push_back(job);
  }
  changed_.notify_one();
  auto asked = std::make_unique<std::shared_ptr<Job>>(job);
  MHD_Response* const response = MHD_create_response_from_callback(
      MHD_SIZE_UNKNOWN, kChunkBytes, &FullSizeImages::ReadCallback, asked.get(),
      &FullSizeImages::FreeCallback);
  if (!response) return MHD_NO;
  asked.release();  // now owned by the response
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, "image/jpeg");
  MHD_add_response_header(response, MHD_HTTP_HEADER_CACHE_CONTROL, "no-store");
  const MHD_Result queued =
      MHD_queue_response(connection, MHD_HTTP_OK, response);
  MHD_destroy_response(response);
  return queued;
}

ssize_t FullSizeImages::ReadCallback(void* asked, uint64_t, char* bytes,
                                     size_t size) {
  Job* const job = static_cast<std::shared_ptr<Job>*>(asked)->get();
  const std::lock_guard<std::mutex> lock(job->pictures->mutex_);
  if (!job->is_ready) {
    job->is_suspended = true;
    MHD_suspend_connection(job->connection);
    return 0;
  }
  if (job->jpeg.empty()) return MHD_CONTENT_READER_END_WITH_ERROR;
  const size_t piece = std::min(size, job->jpeg.size() - job->sent);
  if (piece == 0) return MHD_CONTENT_READER_END_OF_STREAM;
  std::memcpy(bytes, job->jpeg.data() + job->sent, piece);
  job->sent += piece;
  return static_cast<ssize_t>(piece);
}

void FullSizeImages::FreeCallback(void* asked) {
  const std::unique_ptr<std::shared_ptr<Job>> job(
      static_cast<std::shared_ptr<Job>*>(asked));
  const std::lock_guard<std::mutex> lock((*job)->pictures->mutex_);
  (*job)->is_gone = true;
}

void FullSizeImages::Work() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return is_stopped_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const std::shared_ptr<Job> job = waiting_.front();
    waiting_.pop_front();
    std::vector<uint8_t> jpeg;
    if (!job->is_gone && !is_stopped_) {
      lock.unlock();
      GreyBuffer picture;
      if (read_ && read_(job->name, &picture)) jpeg = EncodeFullSize(picture);
      lock.lock();
    }
    job->jpeg = std::move(jpeg);
    job->is_ready = true;
    if (job->is_suspended) MHD_resume_connection(job->connection);
    job->is_suspended = false;
  }
}

void FullSizeImages::End() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
  }
  changed_.notify_one();
  if (worker_.joinable()) worker_.join();
}

}  // namespace raygrid
