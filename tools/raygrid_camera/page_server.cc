#include "page_server.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <strings.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <mutex>
#include <optional>

#include "access_token.h"
#include "camera_error.h"
#include "client_slots.h"
#include "host_names.h"
#include "newest_stream.h"

namespace raygrid {
namespace {

constexpr size_t kMaxClients = 16;         // streaming or requesting
constexpr unsigned kMaxConnections = 48;   // including rejected clients
constexpr size_t kMaxRequest = 16 * 1024;  // per connection
constexpr unsigned kTimeout_s = 10;
constexpr char kTokenParameter[] = "token";

struct FreeAddress {
  void operator()(addrinfo* address) const { freeaddrinfo(address); }
};

std::unique_ptr<addrinfo, FreeAddress> ParseAddress(
    const std::string& address, uint16_t port, const PageOptionNames& words) {
  addrinfo hints = {};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string number = std::to_string(port);
  // An IPv6 address in brackets.
  const bool is_bracketed =
      address.size() > 2 && address.front() == '[' && address.back() == ']';
  const std::string host =
      is_bracketed ? address.substr(1, address.size() - 2) : address;
  if (getaddrinfo(host.c_str(), number.c_str(), &hints, &found) != 0)
    throw CameraError(CameraExit::kUsage,
                      words.number + ": " + address +
                          " is not a numerical address, such as 0.0.0.0");
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

// Returns the access token; nullopt if none is required.
std::optional<AccessToken> ChooseToken(const PageAddress& address,
                                       const sockaddr* parsed) {
  if (!address.token_file.empty()) return AccessToken::Read(address.token_file);
  if (IsLoopback(parsed)) return std::nullopt;
  return AccessToken::MakeRandom();
}

// Returns the value of a header field, parameter or cookie; empty if it is
// missing.
std::string GetHeaderValue(MHD_Connection* connection, MHD_ValueKind kind,
                           const char* name) {
  const char* const value = MHD_lookup_connection_value(connection, kind, name);
  return value ? value : "";
}

// Redirects to the page without the token, which the browser then stores as a
// cookie.
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

// Paths are compared without decoding escapes, since %00 would terminate them.
size_t KeepEscapes(void*, MHD_Connection*, char* text) {
  return std::strlen(text);
}

void AddFields(MHD_Response* response, AnswerFields fields) {
  MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
  for (const auto& [name, value] : fields)
    MHD_add_response_header(response, name, value);
}

// Calls a function for each value of a header field of the request.
template <typename Function>
void ForEachField(MHD_Connection* connection, const char* name,
                  Function function) {
  struct Visit {
    const char* name;
    Function* function;
  } visit = {name, &function};
  MHD_get_connection_values_n(
      connection, MHD_HEADER_KIND,
      [](void* to, MHD_ValueKind, const char* key, size_t, const char* value,
         size_t size) {
        const Visit* const found = static_cast<Visit*>(to);
        if (strcasecmp(key, found->name) == 0)
          (*found->function)(std::string(value ? value : "", size));
        return MHD_YES;
      },
      &visit);
}

}  // namespace

MHD_Result AnswerText(MHD_Connection* connection, unsigned status,
                      const char* type, const char* text, AnswerFields fields) {
  MHD_Response* const response = MHD_create_response_from_buffer(
      std::strlen(text), const_cast<char*>(text), MHD_RESPMEM_PERSISTENT);
  if (!response) return MHD_NO;
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, type);
  AddFields(response, fields);
  const MHD_Result queued = MHD_queue_response(connection, status, response);
  MHD_destroy_response(response);
  return queued;
}

MHD_Result AnswerBytes(MHD_Connection* connection, const char* type,
                       const std::vector<uint8_t>& bytes, AnswerFields fields) {
  MHD_Response* const response = MHD_create_response_from_buffer(
      bytes.size(), const_cast<uint8_t*>(bytes.data()), MHD_RESPMEM_MUST_COPY);
  if (!response) return MHD_NO;
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, type);
  AddFields(response, fields);
  const MHD_Result queued =
      MHD_queue_response(connection, MHD_HTTP_OK, response);
  MHD_destroy_response(response);
  return queued;
}

class PageServer::Impl {
 public:
  Impl(const PageAddress& address, const PageOptionNames& words,
       bool takes_posts, Handler handler);
  ~Impl() { MHD_stop_daemon(daemon_); }
  uint16_t port() const { return port_; }
  std::string link() const;
  bool has_new_token() const { return token_ && address_.token_file.empty(); }
  MHD_Result AnswerStream(MHD_Connection* connection, NewestStream* stream);

 private:
  static MHD_Result HandleRequest(void* server, MHD_Connection* connection,
                                  const char* path, const char* method,
                                  const char* version, const char* body,
                                  size_t* body_size, void** state);
  MHD_Result Answer(MHD_Connection* connection, const std::string& path,
                    const std::string& method);
  sockaddr_storage ReachedAddress(MHD_Connection* connection) const;
  bool HasOwnHostName(MHD_Connection* connection) const;
  bool HasOwnOrigin(MHD_Connection* connection) const;
  bool IsTokenKnown(MHD_Connection* connection) const;

  const PageAddress address_;
  const bool accepts_posts_;
  const std::string foreign_name_, no_token_;  // responses
  const Handler handler_;
  std::optional<AccessToken> token_;
  ClientSlots places_{kMaxClients};
  std::mutex opening_;  // locked until the members below are initialized
  uint16_t port_;
  std::string cookie_;  // the name, since servers of one host share cookies
  std::unique_ptr<HostNames> names_;
  MHD_Daemon* daemon_ = nullptr;
};

PageServer::Impl::Impl(const PageAddress& address, const PageOptionNames& words,
                       bool takes_posts, Handler handler)
    : address_(address),
      accepts_posts_(takes_posts),
      foreign_name_("unknown host name; " + words.program + " " + words.name +
                    " NAME adds one\n"),
      no_token_("token required; " + words.program +
                " printed the link that contains it\n"),
      handler_(std::move(handler)),
      port_(address.port) {
  const auto parsed = ParseAddress(address.number, address.port, words);
  token_ = ChooseToken(address, parsed->ai_addr);
  unsigned flags =
      MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_POLL | MHD_ALLOW_SUSPEND_RESUME;
  if (parsed->ai_family == AF_INET6) flags |= MHD_USE_IPv6;
  const std::lock_guard<std::mutex> lock(opening_);
  daemon_ = MHD_start_daemon(
      flags, address.port, nullptr, nullptr, &Impl::HandleRequest, this,
      MHD_OPTION_SOCK_ADDR, parsed->ai_addr, MHD_OPTION_CONNECTION_LIMIT,
      kMaxConnections, MHD_OPTION_CONNECTION_MEMORY_LIMIT, kMaxRequest,
      MHD_OPTION_CONNECTION_TIMEOUT, kTimeout_s, MHD_OPTION_NOTIFY_CONNECTION,
      &ClientSlots::OnConnection, &places_, MHD_OPTION_UNESCAPE_CALLBACK,
      &KeepEscapes, nullptr, MHD_OPTION_END);
  if (!daemon_)
    throw CameraError(CameraExit::kOutput,
                      words.port + ": " + address.number + ":" +
                          std::to_string(address.port) + " cannot listen (" +
                          std::strerror(errno) + "); choose another port");
  if (port_ == 0)
    port_ = MHD_get_daemon_info(daemon_, MHD_DAEMON_INFO_BIND_PORT)->port;
  cookie_ = "raygrid_" + std::to_string(port_);
  names_ =
      std::make_unique<HostNames>(parsed->ai_addr, port_, address.more_names);
}

MHD_Result PageServer::Impl::HandleRequest(void* server,
                                           MHD_Connection* connection,
                                           const char* path, const char* method,
                                           const char*, const char*, size_t*,
                                           void**) {
  Impl* const self = static_cast<Impl*>(server);
  { const std::lock_guard<std::mutex> lock(self->opening_); }
  return self->Answer(connection, path, method);
}

sockaddr_storage PageServer::Impl::ReachedAddress(
    MHD_Connection* connection) const {
  sockaddr_storage reached = {};
  socklen_t size = sizeof(reached);
  getsockname(ClientSlots::Of(connection)->socket,
              reinterpret_cast<sockaddr*>(&reached), &size);
  return reached;
}

// Whether the request has at least one Host field, and each contains a name of
// this server.
bool PageServer::Impl::HasOwnHostName(MHD_Connection* connection) const {
  const sockaddr_storage reached = ReachedAddress(connection);
  bool has_host = false, is_own = true;
  ForEachField(connection, MHD_HTTP_HEADER_HOST, [&](const std::string& host) {
    has_host = true;
    is_own &=
        names_->IsLocalHost(host, reinterpret_cast<const sockaddr*>(&reached));
  });
  return has_host && is_own;
}

// Whether the request was not caused by a page of another site, as stated by
// browsers' header fields. Other programs do not send these.
bool PageServer::Impl::HasOwnOrigin(MHD_Connection* connection) const {
  constexpr char kScheme[] = "http://", kSecureScheme[] = "https://";
  const sockaddr_storage reached = ReachedAddress(connection);
  bool is_own = true;
  ForEachField(connection, "Sec-Fetch-Site", [&](const std::string& site) {
    is_own &= site == "same-origin";
  });
  ForEachField(
      connection, MHD_HTTP_HEADER_ORIGIN, [&](const std::string& site) {
        size_t size = 0;
        for (const std::string scheme : {kScheme, kSecureScheme})
          if (site.compare(0, scheme.size(), scheme) == 0) size = scheme.size();
        is_own &= size > 0 && names_->IsLocalHost(
                                  site.substr(size),
                                  reinterpret_cast<const sockaddr*>(&reached));
      });
  return is_own;
}

bool PageServer::Impl::IsTokenKnown(MHD_Connection* connection) const {
  const std::string bearer = "Bearer " + token_->text();
  const std::string field = GetHeaderValue(connection, MHD_HEADER_KIND,
                                           MHD_HTTP_HEADER_AUTHORIZATION);
  return token_->Is(GetHeaderValue(connection, MHD_GET_ARGUMENT_KIND,
                                   kTokenParameter)) ||
         token_->Is(
             GetHeaderValue(connection, MHD_COOKIE_KIND, cookie_.c_str())) ||
         (field.size() == bearer.size() &&
          field.compare(0, 7, bearer, 0, 7) == 0 &&
          token_->Is(field.substr(7)));
}

// The link contains the host name if the server listens on all addresses.
std::string PageServer::Impl::link() const {
  std::string host = address_.number;
  if (host == "0.0.0.0" || host == "::" || host == "[::]") {
    char name[256] = "";
    gethostname(name, sizeof(name) - 1);
    host = name;
  }
  if (host.find(':') != std::string::npos && host.front() != '[')
    host = "[" + host + "]";
  std::string text = "http://" + host + ":" + std::to_string(port_) + "/";
  if (has_new_token())
    text += std::string("?") + kTokenParameter + "=" + token_->text();
  return text;
}

MHD_Result PageServer::Impl::AnswerStream(MHD_Connection* connection,
                                          NewestStream* stream) {
  ClientSlots::Client* const client = ClientSlots::Of(connection);
  if (!places_.AdmitViewer(client))
    return AnswerText(connection, MHD_HTTP_SERVICE_UNAVAILABLE, "text/plain",
                      "too many viewers; try again later\n");
  return stream->Answer(connection, &client->since);
}

MHD_Result PageServer::Impl::Answer(MHD_Connection* connection,
                                    const std::string& path,
                                    const std::string& method) {
  const bool is_post = accepts_posts_ && method == "POST";
  if (!HasOwnHostName(connection))
    return AnswerText(connection, MHD_HTTP_MISDIRECTED_REQUEST, "text/plain",
                      foreign_name_.c_str());
  if (method != "GET" && !is_post)
    return AnswerText(connection, MHD_HTTP_METHOD_NOT_ALLOWED, "text/plain",
                      accepts_posts_ ? "only GET and POST are supported\n"
                                     : "only GET is supported\n");
  if (token_ && !IsTokenKnown(connection))
    return AnswerText(connection, MHD_HTTP_UNAUTHORIZED, "text/plain",
                      no_token_.c_str());
  if (is_post && !HasOwnOrigin(connection))
    return AnswerText(connection, MHD_HTTP_FORBIDDEN, "text/plain",
                      "only this server's own page may send commands\n");
  if (token_ && !is_post && path == "/" &&
      !GetHeaderValue(connection, MHD_GET_ARGUMENT_KIND, kTokenParameter)
           .empty())
    return AnswerWithCookie(connection, cookie_.c_str(), *token_);
  return handler_(connection, path, is_post);
}

PageServer::PageServer(const PageAddress& address, const PageOptionNames& words,
                       bool takes_posts, Handler handler)
    : impl_(std::make_unique<Impl>(address, words, takes_posts,
                                   std::move(handler))) {}

PageServer::~PageServer() = default;

uint16_t PageServer::port() const { return impl_->port(); }
std::string PageServer::link() const { return impl_->link(); }
bool PageServer::has_new_token() const { return impl_->has_new_token(); }

MHD_Result PageServer::AnswerStream(MHD_Connection* connection,
                                    NewestStream* stream) {
  return impl_->AnswerStream(connection, stream);
}

}  // namespace raygrid
