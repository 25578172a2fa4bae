#ifndef RAYGRID_CAMERA_PICTURE_STREAM_H
#define RAYGRID_CAMERA_PICTURE_STREAM_H

#include <microhttpd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <vector>

namespace raygrid {

/// The newest JPEG of one kind, and the clients that see it change.
class PictureStream {
 public:
  explicit PictureStream(size_t max_size);

  /// Shows a picture to all clients that are ready for one.
  void Publish(const uint8_t* jpeg, size_t size);
  /// Ends all clients' streams; wakes those that wait.
  void End();
  bool has_clients() const { return num_clients_ > 0; }

  /// The endless answer to a request.
  ///
  /// since  when the picture that is being sent was begun; its end of time
  /// while
  ///        there is none
  MHD_Result Answer(MHD_Connection* connection,
                    std::chrono::steady_clock::time_point* since);

 private:
  struct Client;
  static ssize_t ReadOf(void* client, uint64_t position, char* bytes,
                        size_t size);
  static void FreeOf(void* client);
  ssize_t Read(Client* client, char* bytes, size_t size);
  void WakeAll();

  const size_t max_size_;
  std::mutex mutex_;           // of all that follows
  std::vector<uint8_t> part_;  // header and picture, as sent
  uint64_t number_ = 0;
  bool is_ended_ = false;
  std::vector<Client*> waiting_;
  std::atomic<int> num_clients_{0};
};

}  // namespace raygrid

#endif  // RAYGRID_CAMERA_PICTURE_STREAM_H
