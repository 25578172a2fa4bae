#ifndef RAYGRID_CAPTURE_WHOLE_PLOTS_H
#define RAYGRID_CAPTURE_WHOLE_PLOTS_H

#include <microhttpd.h>

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "capture_page.h"

namespace raygrid {

/// Kept frames in full size, read and encoded on request, one at a time in a
/// separate thread.
class FullSizeImages {
 public:
  explicit FullSizeImages(CapturePage::KeptFrameReader read);
  ~FullSizeImages() { End(); }

  /// Answers a request; if the frame cannot be read, closes the connection.
  MHD_Result Answer(MHD_Connection* connection, const std::string& name);
  /// Ends all waiting requests.
  void End();

 private:
  struct Job;
  static ssize_t ReadCallback(void* asked, uint64_t position, char* bytes,
                              size_t size);
  static void FreeCallback(void* asked);
  void Work();

  const CapturePage::KeptFrameReader read_;
  std::mutex mutex_;  // guards all members below and the state of each job
  std::condition_variable changed_;
  std::deque<std::shared_ptr<Job>> waiting_;
  bool is_stopped_ = false;
  std::thread worker_;
};

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_WHOLE_PLOTS_H
