/// Host names under which a server accepts requests.
#ifndef RAYGRID_CAMERA_HOST_NAMES_H
#define RAYGRID_CAMERA_HOST_NAMES_H

#include <sys/socket.h>

#include <cstdint>
#include <string>
#include <vector>

namespace raygrid {

/// Protection against DNS rebinding: the name of a foreign page may resolve to
/// this machine, whose answers the browser then lets that page read; but the
/// Host field contains the foreign name. Accepted names are localhost, the
/// machine's name with and without ".local", loopback addresses, the listening
/// address, and the address that the client connected to, all with the port (80
/// may be omitted); and additional names.
class HostNames {
 public:
  /// address  listening address
  /// added    NAME, accepted with the port or without; or NAME:PORT
  HostNames(const sockaddr* address, uint16_t port,
            std::vector<std::string> added);

  /// host     value of the Host field
  /// reached  local address of the connection
  bool IsLocalHost(const std::string& host, const sockaddr* reached) const;

 private:
  bool IsLocalName(const std::string& name, const sockaddr* reached) const;

  const std::string listening_;  // bytes of the address
  const std::string port_;
  const std::vector<std::string> added_;
  std::vector<std::string> names_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_HOST_NAMES_H
