#ifndef RAYGRID_TESTS_CAPTURE_HTTP_CLIENT_H
#define RAYGRID_TESTS_CAPTURE_HTTP_CLIENT_H

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

namespace raygrid {

/// A connection to a server of this machine, for one request. Nothing that it
/// waits for takes longer than 10 seconds.
class HttpClient {
 public:
  /// fields  of the request, each with its end "\r\n"; "Host: localhost:PORT"
  ///         is added unless there is one
  HttpClient(uint16_t port, const std::string& request,
             const std::string& fields = "", const std::string& body = "")
      : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    const timeval patience = {10, 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    is_open_ = connect(socket_, reinterpret_cast<const sockaddr*>(&address),
                       sizeof(address)) == 0;
    std::string text = request + " HTTP/1.1\r\n" + fields;
    if (fields.find("Host:") == std::string::npos)
      text += "Host: localhost:" + std::to_string(port) + "\r\n";
    if (request.compare(0, 4, "POST") == 0)
      text += "Content-Length: " + std::to_string(body.size()) + "\r\n";
    text += "\r\n" + body;
    send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
  }
  ~HttpClient() { close(socket_); }
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  bool is_open() const { return is_open_; }
  /// 0: there was no answer.
  int Status() {
    ReadHead();
    return head_.size() < 12 ? 0 : std::atoi(head_.c_str() + 9);
  }
  /// The status line and the fields.
  const std::string& Head() {
    ReadHead();
    return head_;
  }
  /// All that follows the head, without the marks of chunks. is_whole is false
  /// where the connection broke off.
  std::string Body(bool* is_whole = nullptr) {
    std::string body;
    const std::string& head = Head();
    const size_t field = head.find("Content-Length: ");
    bool has_end = false;
    if (field != std::string::npos) {
      const size_t size = std::strtoul(head.c_str() + field + 16, nullptr, 10);
      while (bytes_.size() < size && Read()) {
      }
      has_end = bytes_.size() >= size;
      body = bytes_.substr(0, size);
    } else {
      std::string chunk;
      while (NextChunk(&chunk)) body += chunk;
      has_end = is_last_;
    }
    if (is_whole) *is_whole = has_end;
    return body;
  }
  /// The next part of a stream that ends so; what was read before its end.
  std::string Until(const std::string& end) {
    ReadHead();
    std::string chunk;
    for (;;) {
      const size_t at = stream_.find(end);
      if (at != std::string::npos) {
        const std::string part = stream_.substr(0, at);
        stream_.erase(0, at + end.size());
        return part;
      }
      if (!NextChunk(&chunk)) return "";
      stream_ += chunk;
    }
  }
  /// So many bytes of a stream.
  std::string Take(size_t size) {
    std::string chunk;
    while (stream_.size() < size && NextChunk(&chunk)) stream_ += chunk;
    const std::string part = stream_.substr(0, size);
    stream_.erase(0, size);
    return part;
  }

 private:
  bool Read() {
    if (!is_open_) return false;
    std::vector<char> piece(64 * 1024);
    const ssize_t size = recv(socket_, piece.data(), piece.size(), 0);
    if (size <= 0) return is_open_ = false;
    bytes_.append(piece.data(), static_cast<size_t>(size));
    return true;
  }
  void ReadHead() {
    if (!head_.empty()) return;
    size_t end;
    while ((end = bytes_.find("\r\n\r\n")) == std::string::npos)
      if (!Read()) return;
    head_ = bytes_.substr(0, end + 2);
    bytes_.erase(0, end + 4);
  }
  bool NextChunk(std::string* chunk) {
    size_t end;
    while ((end = bytes_.find("\r\n")) == std::string::npos)
      if (!Read()) return false;
    const size_t size = std::strtoul(bytes_.c_str(), nullptr, 16);
    while (bytes_.size() < end + 2 + size + 2)
      if (!Read()) return false;
    *chunk = bytes_.substr(end + 2, size);
    bytes_.erase(0, end + 2 + size + 2);
    is_last_ = size == 0;
    return !is_last_;
  }

  const int socket_;
  bool is_open_ = false, is_last_ = false;
  std::string bytes_, head_, stream_;
};

}  // namespace raygrid

#endif  // RAYGRID_TESTS_CAPTURE_HTTP_CLIENT_H
