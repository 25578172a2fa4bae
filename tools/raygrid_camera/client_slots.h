/// Connection slots of a server; clients that block others lose them.
#ifndef RAYGRID_CAMERA_CLIENT_SLOTS_H
#define RAYGRID_CAMERA_CLIENT_SLOTS_H

#include <microhttpd.h>

#include <chrono>
#include <cstddef>
#include <list>

namespace raygrid {

/// Clients with a pending request occupy one of max_clients slots, viewers of
/// pictures one of max_clients others. If all are occupied, closed connections
/// are evicted first; then the client whose request is pending longest, or a
/// viewer that has been receiving one picture for 5 seconds, if any. Used by
/// libmicrohttpd's thread only.
class ClientSlots {
 public:
  using Clock = std::chrono::steady_clock;

  struct Client {
    MHD_socket socket;
    bool is_watching = false;
    bool is_sent_away = false;
    /// Start of the request, or of the picture being sent; kIdle: neither.
    Clock::time_point since;
  };
  static constexpr Clock::time_point kIdle = Clock::time_point::max();

  explicit ClientSlots(size_t max_clients) : max_clients_(max_clients) {}

  /// Callback of MHD_OPTION_NOTIFY_CONNECTION; places: the ClientSlots.
  static void OnConnection(void* places, MHD_Connection* connection,
                           void** client, MHD_ConnectionNotificationCode what);

  static Client* Of(MHD_Connection* connection);

  /// Makes the client a viewer of pictures; false if no slot is free.
  bool AdmitViewer(Client* client);

 private:
  static void Disconnect(Client* client);
  /// Returns false if no such client can be evicted.
  bool EvictClient(bool is_watching, Clock::duration patience);

  const size_t max_clients_;
  std::list<Client> clients_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CLIENT_SLOTS_H
