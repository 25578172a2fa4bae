#include "host_names.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <strings.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <utility>

namespace raygrid {
namespace {

std::string Bytes(const void* first, size_t size) {
  return std::string(static_cast<const char*>(first), size);
}

// Returns the 4 or 16 bytes of an IP address; empty for other address families.
std::string AddressBytes(const sockaddr* address) {
  if (address->sa_family == AF_INET) {
    const auto* const v4 = reinterpret_cast<const sockaddr_in*>(address);
    return Bytes(&v4->sin_addr, sizeof(v4->sin_addr));
  }
  if (address->sa_family == AF_INET6) {
    const auto* const v6 = reinterpret_cast<const sockaddr_in6*>(address);
    return Bytes(&v6->sin6_addr, sizeof(v6->sin6_addr));
  }
  return {};
}

std::string AddressBytes(const std::string& text) {
  in_addr v4;
  if (inet_pton(AF_INET, text.c_str(), &v4) == 1) return Bytes(&v4, sizeof(v4));
  in6_addr v6;
  const bool is_bracketed =
      text.size() > 2 && text.front() == '[' && text.back() == ']';
  if (is_bracketed &&
      inet_pton(AF_INET6, text.substr(1, text.size() - 2).c_str(), &v6) == 1)
    return Bytes(&v6, sizeof(v6));
  return {};
}

bool IsLoopback(const std::string& address) {
  if (address.size() == sizeof(in_addr)) return address[0] == 127;
  return address == Bytes(&in6addr_loopback, sizeof(in6addr_loopback));
}

bool AreSame(const std::string& a, const std::string& b) {
  return strcasecmp(a.c_str(), b.c_str()) == 0;
}

}  // namespace

HostNames::HostNames(const sockaddr* address, uint16_t port,
                     std::vector<std::string> added)
    : listening_(AddressBytes(address)),
      port_(std::to_string(port)),
      added_(std::move(added)),
      names_({"localhost"}) {
  char name[HOST_NAME_MAX + 1] = "";
  if (gethostname(name, sizeof(name)) != 0 || name[0] == 0) return;
  name[HOST_NAME_MAX] = 0;
  names_.push_back(name);
  names_.push_back(std::string(name) + ".local");
}

bool HostNames::IsLocalName(const std::string& name,
                            const sockaddr* reached) const {
  const auto is_name = [&name](const std::string& own) {
    return AreSame(name, own);
  };
  if (std::any_of(names_.begin(), names_.end(), is_name)) return true;
  const std::string address = AddressBytes(name);
  return !address.empty() && (IsLoopback(address) || address == listening_ ||
                              address == AddressBytes(reached));
}

bool HostNames::IsLocalHost(const std::string& host,
                            const sockaddr* reached) const {
  // Characters after a zero would not be compared.
  if (host.find('\0') != std::string::npos) return false;
  const auto is_host = [this, &host](const std::string& own) {
    return AreSame(host, own) || AreSame(host, own + ":" + port_);
  };
  if (std::any_of(added_.begin(), added_.end(), is_host)) return true;
  const size_t colon = host.find(':', host.rfind(']') + 1);
  const bool has_port = colon != std::string::npos;
  if ((has_port ? host.substr(colon + 1) : "80") != port_) return false;
  return IsLocalName(host.substr(0, colon), reached);
}

}  // namespace raygrid
