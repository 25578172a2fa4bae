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

/// An endless HTTP response of parts, each of which replaces the previous one.
/// New clients start with the newest part, and slow clients skip parts.
class NewestStream {
 public:
  /// type      content type; must outlive this object
  /// first     beginning of each answer; must outlive this object
  /// max_size  maximum bytes of a part, allocated at construction
  NewestStream(const char* type, std::string_view first, size_t max_size);

  /// Sends a part, concatenated from pieces, to all clients ready for one.
  void Publish(std::initializer_list<std::string_view> pieces);
  /// Ends all streams after the newest part, and wakes waiting clients.
  void End();
  bool has_clients() const { return num_clients_ > 0; }

  /// Starts an endless answer to a request.
  ///
  /// since  set to the time at which the current part was started; to max()
  ///        while no part is being sent
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
  std::mutex mutex_;           // guards all members below
  std::vector<uint8_t> part_;  // newest part
  uint64_t number_ = 0;
  bool is_ended_ = false;
  std::vector<Client*> waiting_;
  std::atomic<int> num_clients_{0};
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_NEWEST_STREAM_H
