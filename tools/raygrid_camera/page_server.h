/// An HTTP server for a page, with access control by host name and token.
#ifndef RAYGRID_CAMERA_PAGE_SERVER_H
#define RAYGRID_CAMERA_PAGE_SERVER_H

#include <microhttpd.h>

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace raygrid {

class NewestStream;

struct PageAddress {
  std::string number = "127.0.0.1";  // numerical address; default: local only
  uint16_t port = 0;
  std::vector<std::string> more_names;  // see host_names.h
  std::string token_file;               // empty: no file
};

/// Names of the program and its options, for error messages.
struct PageOptionNames {
  std::string program;  ///< such as raygrid-camera
  std::string number = "--listen", port = "--http", name = "--http-name";
};

/// Header fields of an answer, as pairs of name and value.
using AnswerFields = std::initializer_list<std::pair<const char*, const char*>>;

/// text  not copied; must stay valid
MHD_Result AnswerText(MHD_Connection* connection, unsigned status,
                      const char* type, const char* text,
                      AnswerFields fields = {});
MHD_Result AnswerBytes(MHD_Connection* connection, const char* type,
                       const std::vector<uint8_t>& bytes,
                       AnswerFields fields = {});

/// Listens on a port, and passes on authorized requests: with one of the
/// server's host names, with the token if there is one, and, if they change
/// state (POST), not from pages of other sites. A client can make it allocate
/// at most a few kilobytes and one part of a stream, and at most 16 clients can
/// watch streams.
///
/// On an address that other machines can reach, a token is required: from the
/// page's link, in a cookie that the link sets, or as "Authorization: Bearer
/// TOKEN". On loopback it is required only if a token is specified.
class PageServer {
 public:
  /// Called by a single thread. Path and parameter values are not unescaped.
  /// Bodies are not read.
  using Handler = std::function<MHD_Result(
      MHD_Connection* connection, const std::string& path, bool is_post)>;

  /// Port 0 in the address: any free port.
  /// takes_posts  whether POST is allowed in addition to GET
  /// Throws CameraError if the port is in use, or the token is not readable.
  PageServer(const PageAddress& address, const PageOptionNames& words,
             bool takes_posts, Handler handler);
  /// The streams passed to AnswerStream() must have ended.
  ~PageServer();

  uint16_t port() const;
  /// Returns the address of the page, with the token if it is random.
  std::string link() const;
  bool has_new_token() const;

  /// Answers with a stream, or with an error if too many clients watch already.
  MHD_Result AnswerStream(MHD_Connection* connection, NewestStream* stream);

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PAGE_SERVER_H
