/// Under which names a server may be asked.
#ifndef RAYGRID_CAMERA_HOST_NAMES_H
#define RAYGRID_CAMERA_HOST_NAMES_H

#include <sys/socket.h>

#include <cstdint>
#include <string>
#include <vector>

namespace raygrid {

/// A foreign page's name can be made to mean this machine (DNS rebinding); the
/// browser then lets that page read what the server answers, but says the
/// foreign name in the field Host. Own names are: localhost, the machine's name
/// with and without ".local", loopback addresses, the address that is listened
/// at, and the one that the client reached, all with the port (80 may be left
/// out); and those added.
class HostNames {
 public:
  /// address  that is listened at
  /// added    NAME, with the port or without one; or NAME:PORT, as it is
  HostNames(const sockaddr* address, uint16_t port,
            std::vector<std::string> added);

  /// host     the field's value
  /// reached  the connection's own end
  bool IsLocalHost(const std::string& host, const sockaddr* reached) const;

 private:
  bool IsLocalName(const std::string& name, const sockaddr* reached) const;

  const std::string listening_;  // an address's bytes
  const std::string port_;
  const std::vector<std::string> added_;
  std::vector<std::string> names_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_HOST_NAMES_H
