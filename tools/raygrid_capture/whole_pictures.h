#ifndef RAYGRID_CAPTURE_WHOLE_PICTURES_H
#define RAYGRID_CAPTURE_WHOLE_PICTURES_H

#include <microhttpd.h>

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "capture_page.h"

namespace raygrid {

/// Kept frames of their full size, read and encoded when asked for, by a thread
/// of its own, one after the other.
class WholePictures {
 public:
  explicit WholePictures(CapturePage::ReadKept read);
  ~WholePictures() { End(); }

  /// A frame that cannot be read closes the connection.
  MHD_Result Answer(MHD_Connection* connection, const std::string& name);
  /// Nobody waits after.
  void End();

 private:
  struct Job;
  static ssize_t ReadCallback(void* asked, uint64_t position, char* bytes,
                              size_t size);
  static void FreeCallback(void* asked);
  void Work();

  const CapturePage::ReadKept read_;
  std::mutex mutex_;  // of all that follows, and of the jobs
  std::condition_variable changed_;
  std::deque<std::shared_ptr<Job>> waiting_;
  bool is_stopped_ = false;
  std::thread worker_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_WHOLE_PICTURES_H
