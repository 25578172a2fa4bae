#include "preview_server.h"

#include <arpa/inet.h>
#include <microhttpd.h>
#include <netdb.h>
#include <strings.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "access_token.h"
#include "camera_error.h"
#include "client_places.h"
#include "host_names.h"
#include "jpeg_encoder.h"
#include "picture_rows.h"
#include "picture_stream.h"
#include "preview_page.h"

namespace raygrid {
namespace {

constexpr size_t kMaxClients = 16;         // that watch, and that ask
constexpr unsigned kMaxConnections = 48;   // and some that are sent away
constexpr size_t kMaxRequest = 16 * 1024;  // memory of a connection
constexpr unsigned kTimeout_s = 10;
constexpr char kTokenParameter[] = "token";

struct FreeAddress {
  void operator()(addrinfo* address) const { freeaddrinfo(address); }
};

std::unique_ptr<addrinfo, FreeAddress> ParseAddress(const std::string& address,
                                                    uint16_t port) {
  addrinfo hints = {};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string number = std::to_string(port);
  // [::1] is ::1.
  const bool is_bracketed =
      address.size() > 2 && address.front() == '[' && address.back() == ']';
  const std::string host =
      is_bracketed ? address.substr(1, address.size() - 2) : address;
  if (getaddrinfo(host.c_str(), number.c_str(), &hints, &found) != 0)
    throw CameraError(CameraExit::kUsage, "--listen: " + address +
                                              " is no numerical address, as "
                                              "0.0.0.0; see --help");
  return std::unique_ptr<addrinfo, FreeAddress>(found);
}

bool IsLoopback(const sockaddr* address) {
  if (address->sa_family == AF_INET6)
    return IN6_IS_ADDR_LOOPBACK(
        &reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr);
  const uint32_t number =
      ntohl(reinterpret_cast<const sockaddr_in*>(address)->sin_addr.s_addr);
  return number >> 24 == IN_LOOPBACKNET;
}

// Nothing where none is asked for.
std::optional<AccessToken> ChooseToken(const PreviewAddress& address,
                                       const sockaddr* parsed) {
  if (!address.token_file.empty()) return AccessToken::Read(address.token_file);
  if (IsLoopback(parsed)) return std::nullopt;
  return AccessToken::MakeRandom();
}

// The value of a field, parameter or cookie; empty where there is none.
std::string ValueOf(MHD_Connection* connection, MHD_ValueKind kind,
                    const char* name) {
  const char* const value = MHD_lookup_connection_value(connection, kind, name);
  return value ? value : "";
}

MHD_Result AnswerText(MHD_Connection* connection, unsigned status,
                      const char* type, const char* text) {
  MHD_Response* const response = MHD_create_response_from_buffer(
      std::strlen(text), const_cast<char*>(text), MHD_RESPMEM_PERSISTENT);
  if (!response) return MHD_NO;
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, type);
  MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
  const MHD_Result queued = MHD_queue_response(connection, status, response);
  MHD_destroy_response(response);
  return queued;
}

// To the page without the token, which the browser keeps from then on.
MHD_Result AnswerWithCookie(MHD_Connection* connection, const char* cookie,
                            const AccessToken& token) {
  MHD_Response* const response =
      MHD_create_response_from_buffer(0, nullptr, MHD_RESPMEM_PERSISTENT);
  if (!response) return MHD_NO;
  const std::string value = std::string(cookie) + "=" + token.text() +
                            "; Path=/; HttpOnly; SameSite=Strict";
  MHD_add_response_header(response, MHD_HTTP_HEADER_SET_COOKIE, value.c_str());
  MHD_add_response_header(response, MHD_HTTP_HEADER_LOCATION, "/");
  MHD_add_response_header(response, "Referrer-Policy", "no-referrer");
  const MHD_Result queued =
      MHD_queue_response(connection, MHD_HTTP_SEE_OTHER, response);
  MHD_destroy_response(response);
  return queued;
}

// Paths are compared as they came: what %00 stands for would end them.
size_t KeepEscapes(void*, MHD_Connection*, char* text) {
  return std::strlen(text);
}

// Rows of all planes to bytes without gaps.
void CopyPlanes(const StreamFormat& format, const rg_image& image,
                std::vector<uint8_t>* bytes) {
  uint8_t* to = bytes->data();
  for (int i = 0; i < format.num_planes; ++i) {
    const PlaneLayout& plane = format.planes[i];
    for (uint32_t row = 0; row < plane.rows; ++row, to += plane.row_bytes)
      std::memcpy(to,
                  image.planes[i].data + size_t{row} * image.planes[i].stride,
                  plane.row_bytes);
  }
}

// One of the two kinds of pictures.
struct View {
  explicit View(const StreamFormat& stream_format)
      : format(stream_format),
        bytes(stream_format.packed_size()),
        encoder(stream_format),
        stream(encoder.max_size()) {}

  void Show() {
    if (!stream.has_clients()) return;
    const size_t size = encoder.Encode(MakePackedImage(format, bytes.data()));
    if (size > 0) stream.Publish(encoder.bytes(), size);
  }

  const StreamFormat format;
  std::vector<uint8_t> bytes;  // a frame's copy
  JpegEncoder encoder;
  PictureStream stream;
};

}  // namespace

class PreviewServer::Impl {
 public:
  Impl(const PreviewAddress& address, const StreamFormat& before,
       const StreamFormat& after);
  ~Impl();
  void OnFrame(const CapturedFrame& before, const UndistortedFrame& after);
  std::string link() const;
  bool has_new_token() const { return token_ && address_.token_file.empty(); }

 private:
  static MHD_Result AnswerOf(void* server, MHD_Connection* connection,
                             const char* path, const char* method,
                             const char* version, const char* body,
                             size_t* body_size, void** state);
  MHD_Result Answer(MHD_Connection* connection, const std::string& path,
                    const std::string& method);
  MHD_Result AnswerPictures(MHD_Connection* connection, PictureStream* stream);
  bool IsAskedByOwnName(MHD_Connection* connection) const;
  bool IsTokenKnown(MHD_Connection* connection) const;
  void Encode();

  View before_, after_;
  const PreviewAddress address_;
  std::string cookie_;  // its name; servers of one machine share cookies
  std::optional<AccessToken> token_;
  ClientPlaces places_{kMaxClients};
  std::unique_ptr<HostNames> names_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_full_ = false, is_stopped_ = false;  // the frames' copies
  MHD_Daemon* daemon_ = nullptr;
  std::thread encoder_;
};

PreviewServer::Impl::Impl(const PreviewAddress& address,
                          const StreamFormat& before, const StreamFormat& after)
    : before_(before),
      after_(after),
      address_(address),
      cookie_("raygrid_" + std::to_string(address.port)) {
  const auto parsed = ParseAddress(address.number, address.port);
  token_ = ChooseToken(address, parsed->ai_addr);
  names_ = std::make_unique<HostNames>(parsed->ai_addr, address.port,
                                       address.more_names);
  unsigned flags =
      MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_POLL | MHD_ALLOW_SUSPEND_RESUME;
  if (parsed->ai_family == AF_INET6) flags |= MHD_USE_IPv6;
  daemon_ = MHD_start_daemon(
      flags, address.port, nullptr, nullptr, &Impl::AnswerOf, this,
      MHD_OPTION_SOCK_ADDR, parsed->ai_addr, MHD_OPTION_CONNECTION_LIMIT,
      kMaxConnections, MHD_OPTION_CONNECTION_MEMORY_LIMIT, kMaxRequest,
      MHD_OPTION_CONNECTION_TIMEOUT, kTimeout_s,
      MHD_OPTION_LISTENING_ADDRESS_REUSE, 1u, MHD_OPTION_NOTIFY_CONNECTION,
      &ClientPlaces::OnConnection, &places_, MHD_OPTION_UNESCAPE_CALLBACK,
      &KeepEscapes, nullptr, MHD_OPTION_END);
  if (!daemon_)
    throw CameraError(CameraExit::kOutput,
                      "--http: " + address.number + ":" +
                          std::to_string(address.port) + " cannot be served (" +
                          std::strerror(errno) + "); choose another port");
  encoder_ = std::thread(&Impl::Encode, this);
}

PreviewServer::Impl::~Impl() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
  }
  changed_.notify_one();
  encoder_.join();
  before_.stream.End();
  after_.stream.End();
  MHD_stop_daemon(daemon_);
}

void PreviewServer::Impl::OnFrame(const CapturedFrame& before,
                                  const UndistortedFrame& after) {
  if (!before_.stream.has_clients() && !after_.stream.has_clients()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_full_) return;  // the encoder has enough to do
  }
  CopyPlanes(before_.format, before.image, &before_.bytes);
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

MHD_Result PreviewServer::Impl::AnswerOf(void* server,
                                         MHD_Connection* connection,
                                         const char* path, const char* method,
                                         const char*, const char*, size_t*,
                                         void**) {
  return static_cast<Impl*>(server)->Answer(connection, path, method);
}

// Every field Host, and at least one, has a name of this server.
bool PreviewServer::Impl::IsAskedByOwnName(MHD_Connection* connection) const {
  struct Fields {
    const HostNames* names;
    sockaddr_storage reached;
    bool is_asked, is_own;
  } fields = {names_.get(), {}, false, true};
  socklen_t size = sizeof(fields.reached);
  getsockname(ClientPlaces::Of(connection)->socket,
              reinterpret_cast<sockaddr*>(&fields.reached), &size);
  MHD_get_connection_values_n(
      connection, MHD_HEADER_KIND,
      [](void* to, MHD_ValueKind, const char* key, size_t, const char* value,
         size_t value_size) {
        Fields* const found = static_cast<Fields*>(to);
        if (strcasecmp(key, MHD_HTTP_HEADER_HOST) != 0) return MHD_YES;
        found->is_asked = true;
        found->is_own &= found->names->IsOwn(
            std::string(value ? value : "", value_size),
            reinterpret_cast<const sockaddr*>(&found->reached));
        return MHD_YES;
      },
      &fields);
  return fields.is_asked && fields.is_own;
}

bool PreviewServer::Impl::IsTokenKnown(MHD_Connection* connection) const {
  const std::string bearer = "Bearer " + token_->text();
  const std::string field =
      ValueOf(connection, MHD_HEADER_KIND, MHD_HTTP_HEADER_AUTHORIZATION);
  return token_->Is(
             ValueOf(connection, MHD_GET_ARGUMENT_KIND, kTokenParameter)) ||
         token_->Is(ValueOf(connection, MHD_COOKIE_KIND, cookie_.c_str())) ||
         (field.size() == bearer.size() &&
          field.compare(0, 7, bearer, 0, 7) == 0 &&
          token_->Is(field.substr(7)));
}

// All addresses are none to ask for: the machine's name is.
std::string PreviewServer::Impl::link() const {
  std::string host = address_.number;
  if (host == "0.0.0.0" || host == "::" || host == "[::]") {
    char name[256] = "";
    gethostname(name, sizeof(name) - 1);
    host = name;
  }
  if (host.find(':') != std::string::npos && host.front() != '[')
    host = "[" + host + "]";
  std::string text =
      "http://" + host + ":" + std::to_string(address_.port) + "/";
  if (has_new_token())
    text += std::string("?") + kTokenParameter + "=" + token_->text();
  return text;
}

MHD_Result PreviewServer::Impl::AnswerPictures(MHD_Connection* connection,
                                               PictureStream* stream) {
  ClientPlaces::Client* const client = ClientPlaces::Of(connection);
  if (!places_.LetWatch(client))
    return AnswerText(connection, MHD_HTTP_SERVICE_UNAVAILABLE, "text/plain",
                      "others watch already; try again later\n");
  return stream->Answer(connection, &client->since);
}

// Paths are compared, never opened; bodies are not read.
MHD_Result PreviewServer::Impl::Answer(MHD_Connection* connection,
                                       const std::string& path,
                                       const std::string& method) {
  if (!IsAskedByOwnName(connection))
    return AnswerText(connection, MHD_HTTP_MISDIRECTED_REQUEST, "text/plain",
                      "not this server's name; raygrid-camera --http-name "
                      "NAME adds one\n");
  if (method != "GET")
    return AnswerText(connection, MHD_HTTP_METHOD_NOT_ALLOWED, "text/plain",
                      "only GET\n");
  if (token_ && !IsTokenKnown(connection))
    return AnswerText(connection, MHD_HTTP_UNAUTHORIZED, "text/plain",
                      "a token is needed; raygrid-camera printed the link "
                      "that has it\n");
  if (token_ && path == "/" &&
      !ValueOf(connection, MHD_GET_ARGUMENT_KIND, kTokenParameter).empty())
    return AnswerWithCookie(connection, cookie_.c_str(), *token_);
  if (path == "/before") return AnswerPictures(connection, &before_.stream);
  if (path == "/after") return AnswerPictures(connection, &after_.stream);
  if (path == "/")
    return AnswerText(connection, MHD_HTTP_OK, "text/html; charset=utf-8",
                      kPreviewPage);
  return AnswerText(connection, MHD_HTTP_NOT_FOUND, "text/plain",
                    "there is /, /before and /after\n");
}

PreviewServer::PreviewServer(const PreviewAddress& address,
                             const StreamFormat& before,
                             const StreamFormat& after)
    : impl_(std::make_unique<Impl>(address, before, after)) {}

PreviewServer::~PreviewServer() = default;

std::string PreviewServer::link() const { return impl_->link(); }
bool PreviewServer::has_new_token() const { return impl_->has_new_token(); }

void PreviewServer::OnFrame(const CapturedFrame& before,
                            const UndistortedFrame& after) {
  impl_->OnFrame(before, after);
}

}  // namespace raygrid
