#include "preview_server.h"

#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>
#include <vector>

#include "jpeg_encoder.h"
#include "mjpeg_stream.h"
#include "preview_page.h"
#include "rgb_rows.h"

namespace raygrid {
namespace {

// One of the two streams: before or after undistortion.
struct View {
  explicit View(const StreamFormat& stream_format)
      : format(stream_format),
        bytes(stream_format.packed_size()),
        encoder(stream_format),
        stream(encoder.max_size()) {}

  void Show() {
    if (!stream.has_clients()) return;
    const size_t size = encoder.Encode(MakePackedImage(format, bytes.data()));
    if (size > 0) stream.ShowImage(encoder.bytes(), size);
  }

  const StreamFormat format;
  std::vector<uint8_t> bytes;  // a copy of the frame
  JpegEncoder encoder;
  MjpegStream stream;
};

}  // namespace

class PreviewServer::Impl {
 public:
  Impl(const PageAddress& address, const StreamFormat& before,
       const StreamFormat& after);
  ~Impl();
  void OnFrame(const CapturedFrame& before, const UndistortedFrame& after);
  const PageServer& server() const { return server_; }

 private:
  MHD_Result Answer(MHD_Connection* connection, const std::string& path);
  void Encode();

  View before_, after_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_full_ = false, is_stopped_ = false;  // state of the frame copies
  PageServer server_;
  std::thread encoder_;
};

PreviewServer::Impl::Impl(const PageAddress& address,
                          const StreamFormat& before, const StreamFormat& after)
    : before_(before),
      after_(after),
      server_(address, {"raygrid-camera"}, false,
              [this](MHD_Connection* connection, const std::string& path,
                     bool) { return Answer(connection, path); }),
      encoder_(&Impl::Encode, this) {}

PreviewServer::Impl::~Impl() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
  }
  changed_.notify_one();
  encoder_.join();
  before_.stream.End();
  after_.stream.End();
}

void PreviewServer::Impl::OnFrame(const CapturedFrame& before,
                                  const UndistortedFrame& after) {
  if (!before_.stream.has_clients() && !after_.stream.has_clients()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_full_) return;  // the encoder is still busy
  }
  CopyPlanes(before_.format, before.image, before_.bytes.data());
  std::memcpy(after_.bytes.data(), after.bytes.data(), after.bytes.size());
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_full_ = true;
  }
  changed_.notify_one();
}

void PreviewServer::Impl::Encode() {
  for (;;) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return is_full_ || is_stopped_; });
    if (is_stopped_) return;
    lock.unlock();
    before_.Show();
    after_.Show();
    lock.lock();
    is_full_ = false;
  }
}

// Paths are compared with known ones, but never opened.
MHD_Result PreviewServer::Impl::Answer(MHD_Connection* connection,
                                       const std::string& path) {
  if (path == "/before")
    return server_.AnswerStream(connection, &before_.stream);
  if (path == "/after") return server_.AnswerStream(connection, &after_.stream);
  if (path == "/")
    return AnswerText(connection, MHD_HTTP_OK, "text/html; charset=utf-8",
                      kPreviewPage);
  return AnswerText(connection, MHD_HTTP_NOT_FOUND, "text/plain",
                    "not found; available are /, /before and /after\n");
}

PreviewServer::PreviewServer(const PageAddress& address,
                             const StreamFormat& before,
                             const StreamFormat& after)
    : impl_(std::make_unique<Impl>(address, before, after)) {}

PreviewServer::~PreviewServer() = default;

std::string PreviewServer::link() const { return impl_->server().link(); }
bool PreviewServer::has_new_token() const {
  return impl_->server().has_new_token();
}

void PreviewServer::OnFrame(const CapturedFrame& before,
                            const UndistortedFrame& after) {
  impl_->OnFrame(before, after);
}

}  // namespace raygrid
