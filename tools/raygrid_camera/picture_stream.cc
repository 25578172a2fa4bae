#include "picture_stream.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>

namespace raygrid {
namespace {

using PictureClock = std::chrono::steady_clock;

constexpr size_t kPartHeader = 128;  // at most
constexpr size_t kPiece = 64 * 1024;
constexpr char kType[] = "multipart/x-mixed-replace; boundary=frame";

}  // namespace

struct PictureStream::Client {
  PictureStream* stream;
  MHD_Connection* connection;
  PictureClock::time_point* since;
  std::vector<uint8_t> part;  // the one being sent
  size_t sent = 0;
  uint64_t number = 0;
};

PictureStream::PictureStream(size_t max_size)
    : max_size_(max_size + kPartHeader) {
  part_.reserve(max_size_);
}

void PictureStream::Publish(const uint8_t* jpeg, size_t size) {
  char header[kPartHeader];
  const int length = std::snprintf(
      header, sizeof(header),
      "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %zu\r\n\r\n",
      size);
  const std::lock_guard<std::mutex> lock(mutex_);
  part_.assign(header, header + length);
  part_.insert(part_.end(), jpeg, jpeg + size);
  part_.insert(part_.end(), {'\r', '\n'});
  ++number_;
  WakeAll();
}

void PictureStream::End() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_ended_ = true;
  WakeAll();
}

void PictureStream::WakeAll() {
  for (Client* const client : waiting_)
    MHD_resume_connection(client->connection);
  waiting_.clear();
}

MHD_Result PictureStream::Answer(MHD_Connection* connection,
                                 PictureClock::time_point* since) {
  auto client = std::make_unique<Client>();
  client->stream = this;
  client->connection = connection;
  client->since = since;
  client->part.reserve(max_size_);
  MHD_Response* const response = MHD_create_response_from_callback(
      MHD_SIZE_UNKNOWN, kPiece, &PictureStream::ReadOf, client.get(),
      &PictureStream::FreeOf);
  if (!response) return MHD_NO;
  client.release();  // now the response's
  ++num_clients_;
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, kType);
  MHD_add_response_header(response, MHD_HTTP_HEADER_CACHE_CONTROL, "no-store");
  const MHD_Result queued =
      MHD_queue_response(connection, MHD_HTTP_OK, response);
  MHD_destroy_response(response);
  return queued;
}

ssize_t PictureStream::ReadOf(void* state, uint64_t, char* bytes, size_t size) {
  Client* const client = static_cast<Client*>(state);
  return client->stream->Read(client, bytes, size);
}

void PictureStream::FreeOf(void* state) {
  const std::unique_ptr<Client> client(static_cast<Client*>(state));
  PictureStream* const stream = client->stream;
  const std::lock_guard<std::mutex> lock(stream->mutex_);
  auto& waiting = stream->waiting_;
  waiting.erase(std::remove(waiting.begin(), waiting.end(), client.get()),
                waiting.end());
  --stream->num_clients_;
}

ssize_t PictureStream::Read(Client* client, char* bytes, size_t size) {
  if (client->sent == client->part.size()) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_ended_) return MHD_CONTENT_READER_END_OF_STREAM;
    if (client->number == number_) {
      waiting_.push_back(client);
      *client->since = PictureClock::time_point::max();
      MHD_suspend_connection(client->connection);
      return 0;
    }
    client->part = part_;
    client->number = number_;
    client->sent = 0;
    *client->since = PictureClock::now();
  }
  const size_t piece = std::min(size, client->part.size() - client->sent);
  std::memcpy(bytes, client->part.data() + client->sent, piece);
  client->sent += piece;
  return static_cast<ssize_t>(piece);
}

}  // namespace raygrid
