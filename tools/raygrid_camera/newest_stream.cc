#include "newest_stream.h"

#include <algorithm>
#include <cstring>
#include <memory>

namespace raygrid {
namespace {

using StreamClock = std::chrono::steady_clock;

constexpr size_t kPiece = 64 * 1024;

}  // namespace

struct NewestStream::Client {
  NewestStream* stream;
  MHD_Connection* connection;
  StreamClock::time_point* since;
  std::vector<uint8_t> part;  // the part being sent
  size_t sent = 0;
  uint64_t number = 0;
};

NewestStream::NewestStream(const char* type, std::string_view first,
                           size_t max_size)
    : type_(type), first_(first), max_size_(max_size) {
  part_.reserve(max_size_);
}

void NewestStream::Publish(std::initializer_list<std::string_view> pieces) {
  const std::lock_guard<std::mutex> lock(mutex_);
  part_.clear();
  for (const std::string_view piece : pieces)
    part_.insert(part_.end(), piece.begin(), piece.end());
  ++number_;
  WakeAll();
}

void NewestStream::End() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_ended_ = true;
  WakeAll();
}

void NewestStream::WakeAll() {
  for (Client* const client : waiting_)
    MHD_resume_connection(client->connection);
  waiting_.clear();
}

MHD_Result NewestStream::Answer(MHD_Connection* connection,
                                StreamClock::time_point* since) {
  auto client = std::make_unique<Client>();
  client->stream = this;
  client->connection = connection;
  client->since = since;
  client->part.reserve(max_size_);
  client->part.assign(first_.begin(), first_.end());
  MHD_Response* const response = MHD_create_response_from_callback(
      MHD_SIZE_UNKNOWN, kPiece, &NewestStream::ReadCallback, client.get(),
      &NewestStream::FreeCallback);
  if (!response) return MHD_NO;
  client.release();  // now owned by the response
  ++num_clients_;
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, type_);
  MHD_add_response_header(response, MHD_HTTP_HEADER_CACHE_CONTROL, "no-store");
  const MHD_Result queued =
      MHD_queue_response(connection, MHD_HTTP_OK, response);
  MHD_destroy_response(response);
  return queued;
}

ssize_t NewestStream::ReadCallback(void* state, uint64_t, char* bytes,
                                   size_t size) {
  Client* const client = static_cast<Client*>(state);
  return client->stream->Read(client, bytes, size);
}

void NewestStream::FreeCallback(void* state) {
  const std::unique_ptr<Client> client(static_cast<Client*>(state));
  NewestStream* const stream = client->stream;
  const std::lock_guard<std::mutex> lock(stream->mutex_);
  auto& waiting = stream->waiting_;
  waiting.erase(std::remove(waiting.begin(), waiting.end(), client.get()),
                waiting.end());
  --stream->num_clients_;
}

ssize_t NewestStream::Read(Client* client, char* bytes, size_t size) {
  if (client->sent == client->part.size()) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (client->number == number_) {
      if (is_ended_) return MHD_CONTENT_READER_END_OF_STREAM;
      waiting_.push_back(client);
      *client->since = StreamClock::time_point::max();
      MHD_suspend_connection(client->connection);
      return 0;
    }
    client->part = part_;
    client->number = number_;
    client->sent = 0;
    *client->since = StreamClock::now();
  }
  const size_t piece = std::min(size, client->part.size() - client->sent);
  std::memcpy(bytes, client->part.data() + client->sent, piece);
  client->sent += piece;
  return static_cast<ssize_t>(piece);
}

}  // namespace raygrid
