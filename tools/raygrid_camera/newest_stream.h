#ifndef RAYGRID_CAMERA_NEWEST_STREAM_H
#define RAYGRID_CAMERA_NEWEST_STREAM_H

#include <microhttpd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <mutex>
#include <string_view>
#include <vector>

namespace raygrid {

/// The newest part of an endless answer, and the clients that see it change.
/// Who is slow misses parts, and who comes gets the newest one.
class NewestStream {
 public:
  /// type      of the answer; stays where it is
  /// first     what each answer begins with; stays where it is
  /// max_size  bytes of a part, for which memory is taken beforehand
  NewestStream(const char* type, std::string_view first, size_t max_size);

  /// Sends a part, in these pieces, to all clients that are ready for one.
  void Publish(std::initializer_list<std::string_view> pieces);
  /// Ends all clients' streams, after the newest part; wakes those that wait.
  void End();
  bool has_clients() const { return num_clients_ > 0; }

  /// The endless answer to a request.
  ///
  /// since  when the part that is being sent was begun; its end of time while
  ///        there is none
  MHD_Result Answer(MHD_Connection* connection,
                    std::chrono::steady_clock::time_point* since);

 private:
  struct Client;
  static ssize_t ReadCallback(void* client, uint64_t position, char* bytes,
                              size_t size);
  static void FreeCallback(void* client);
  ssize_t Read(Client* client, char* bytes, size_t size);
  void WakeAll();

  const char* const type_;
  const std::string_view first_;
  const size_t max_size_;
  std::mutex mutex_;           // of all that follows
  std::vector<uint8_t> part_;  // as sent
  uint64_t number_ = 0;
  bool is_ended_ = false;
  std::vector<Client*> waiting_;
  std::atomic<int> num_clients_{0};
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_NEWEST_STREAM_H
