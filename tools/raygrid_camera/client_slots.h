/// Places for clients, which those lose who hold others up.
#ifndef RAYGRID_CAMERA_CLIENT_SLOTS_H
#define RAYGRID_CAMERA_CLIENT_SLOTS_H

#include <microhttpd.h>

#include <chrono>
#include <cstddef>
#include <list>

namespace raygrid {

/// A client that asks, or whose request has not come as a whole, takes one of
/// some places, one that watches pictures one of as many others. Where all are
/// taken, those go that have left already; else the one that has asked for
/// longest, or one that has taken one picture for 5 seconds, if one has. Used
/// by libmicrohttpd's thread only.
class ClientSlots {
 public:
  using Clock = std::chrono::steady_clock;

  struct Client {
    MHD_socket socket;
    bool is_watching = false;
    bool is_sent_away = false;
    /// When it began to ask, or its picture to be sent; kIdle: neither.
    Clock::time_point since;
  };
  static constexpr Clock::time_point kIdle = Clock::time_point::max();

  explicit ClientSlots(size_t max_clients) : max_clients_(max_clients) {}

  /// MHD_OPTION_NOTIFY_CONNECTION, with the places.
  static void OnConnection(void* places, MHD_Connection* connection,
                           void** client, MHD_ConnectionNotificationCode what);

  static Client* Of(MHD_Connection* connection);

  /// The client's answer is pictures from now on; false: there is no place.
  bool AdmitViewer(Client* client);

 private:
  static void Disconnect(Client* client);
  /// False: all such clients stay.
  bool EvictClient(bool is_watching, Clock::duration patience);

  const size_t max_clients_;
  std::list<Client> clients_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_CLIENT_SLOTS_H
