#include "client_slots.h"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <vector>

namespace raygrid {
namespace {

constexpr std::chrono::seconds kRoomPatience(5);

// Whether the client has disconnected; libmicrohttpd does not notice this while
// a client waits for a picture.
bool HasLeft(MHD_socket socket) {
  char byte;
  const ssize_t size = recv(socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
  return size == 0 || (size < 0 && errno != EAGAIN && errno != EINTR);
}

}  // namespace

void ClientSlots::Disconnect(Client* client) {
  // libmicrohttpd closes the socket when it detects the shutdown.
  shutdown(client->socket, SHUT_RDWR);
  client->is_sent_away = true;
}

bool ClientSlots::EvictClient(bool is_watching, Clock::duration patience) {
  std::vector<Client*> others;
  for (Client& client : clients_)
    if (client.is_watching == is_watching && !client.is_sent_away)
      others.push_back(&client);
  if (others.size() < max_clients_) return true;
  bool has_room = false;
  for (Client* const client : others) {
    if (!HasLeft(client->socket)) continue;
    Disconnect(client);
    has_room = true;
  }
  if (has_room) return true;
  Client* const slowest = *std::min_element(
      others.begin(), others.end(),
      [](const Client* a, const Client* b) { return a->since < b->since; });
  if (slowest->since == kIdle || Clock::now() - slowest->since < patience)
    return false;
  Disconnect(slowest);
  return true;
}

void ClientSlots::OnConnection(void* places, MHD_Connection* connection,
                               void** client,
                               MHD_ConnectionNotificationCode what) {
  ClientSlots* const self = static_cast<ClientSlots*>(places);
  if (what == MHD_CONNECTION_NOTIFY_STARTED) {
    self->EvictClient(false, Clock::duration::zero());
    const auto* const info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    self->clients_.push_back({info->connect_fd, false, false, Clock::now()});
    *client = &self->clients_.back();
  } else {
    self->clients_.remove_if(
        [client](const Client& other) { return &other == *client; });
  }
}

ClientSlots::Client* ClientSlots::Of(MHD_Connection* connection) {
  return static_cast<Client*>(
      MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT)
          ->socket_context);
}

bool ClientSlots::AdmitViewer(Client* client) {
  if (!EvictClient(true, kRoomPatience)) return false;
  client->is_watching = true;
  client->since = kIdle;
  return true;
}

}  // namespace raygrid
