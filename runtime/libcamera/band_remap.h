/// rg_remap() by several threads.
#ifndef RAYGRID_LIBCAMERA_BAND_REMAP_H
#define RAYGRID_LIBCAMERA_BAND_REMAP_H

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "raygrid.h"
#include "stream_format.h"

namespace raygrid {

/// Threads that undistort bands of rows of one frame, each as it comes free.
/// The bytes are those of one rg_remap() of the whole frame.
class BandRemap {
 public:
  /// num_threads  with the one that calls Remap(); 0: one for each processor
  explicit BandRemap(unsigned num_threads);
  ~BandRemap();
  BandRemap(const BandRemap&) = delete;
  BandRemap& operator=(const BandRemap&) = delete;

  unsigned num_threads() const {
    return static_cast<unsigned>(threads_.size()) + 1;
  }

  /// All rows of the target, whose planes lie as format says but for their
  /// strides, which are the target's own. What the first band that fails
  /// returns, or RG_OK. By one thread at a time.
  rg_status Remap(const rg_camera& camera, const rg_image& image,
                  const StreamFormat& format, const rg_target& target);

 private:
  struct Job {
    const rg_camera* camera = nullptr;
    const rg_image* image = nullptr;
    const StreamFormat* format = nullptr;
    const rg_target* target = nullptr;
    uint32_t band_rows = 0;
  };

  void Serve();
  // Bands until none is left; the lock is held before and after.
  void WorkOn(std::unique_lock<std::mutex>* lock);
  rg_status RemapBand(const Job& job, uint32_t first_row) const;

  std::vector<std::thread> threads_;
  std::mutex mutex_;  // of all below
  std::condition_variable has_work_, is_done_;
  Job job_;
  uint32_t next_row_ = 0, num_open_ = 0;  // bands that are being worked on
  rg_status status_ = RG_OK;
  uint32_t failed_row_ = 0;
  bool is_stopped_ = false;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_BAND_REMAP_H
