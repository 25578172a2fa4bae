/// The port of a page: who may ask there, and by which names.
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
  std::string number = "127.0.0.1";  // numerical; that is this machine only
  uint16_t port = 0;
  std::vector<std::string> more_names;  // see host_names.h
  std::string token_file;               // empty: none
};

/// The program and its options, as errors name them.
struct PageWords {
  std::string program;  ///< such as raygrid-camera
  std::string number = "--listen", port = "--http", name = "--http-name";
};

/// Fields of an answer, in pairs of name and value.
using AnswerFields = std::initializer_list<std::pair<const char*, const char*>>;

/// text  stays where it is
MHD_Result AnswerText(MHD_Connection* connection, unsigned status,
                      const char* type, const char* text,
                      AnswerFields fields = {});
MHD_Result AnswerBytes(MHD_Connection* connection, const char* type,
                       const std::vector<uint8_t>& bytes,
                       AnswerFields fields = {});

/// Opens a port, and hands requests on that may be asked: under one of the
/// server's own names, with the token where there is one, and, if they change
/// something (POST), by no other site's page. No client can make it keep more
/// than a few kilobytes and one part of a stream, and there are at most 16 that
/// watch streams.
///
/// Who asks at an address that other machines reach must know a token: as the
/// page's link has it, in a cookie that the link sets, or as
/// "Authorization: Bearer TOKEN". So it is at loopback if the token is told.
class PageServer {
 public:
  /// Called by one thread. The path is as it came, with its escapes; so are the
  /// values of its parameters. Bodies are not read.
  using Handler = std::function<MHD_Result(
      MHD_Connection* connection, const std::string& path, bool is_post)>;

  /// port 0 of the address: any that is free.
  /// takes_posts  else there is only GET
  /// Throws CameraError where the port is taken, or the token cannot be had.
  PageServer(const PageAddress& address, const PageWords& words,
             bool takes_posts, Handler handler);
  /// Streams that it answers with must have ended.
  ~PageServer();

  uint16_t port() const;
  /// The address of the page, with the token if that was made just now.
  std::string link() const;
  bool has_new_token() const;

  /// The parts of a stream, or that too many watch already.
  MHD_Result AnswerStream(MHD_Connection* connection, NewestStream* stream);

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PAGE_SERVER_H
