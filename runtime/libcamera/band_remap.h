/// Multithreaded rg_remap().
#ifndef RAYGRID_LIBCAMERA_BAND_REMAP_H
#define RAYGRID_LIBCAMERA_BAND_REMAP_H

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "raygrid.h"
#include "stream_format.h"

namespace raygrid {

/// A pool of threads that undistort a frame in bands of rows, each thread its
/// own bands first. The output is identical to one rg_remap() of the frame.
///
/// Waking a thread costs a tenth of the time of a grey frame of 1280 x 800. An
/// idle thread therefore polls for work for a tenth of a millisecond before it
/// sleeps, so that it is still awake if frames follow quickly.
class BandRemap {
 public:
  /// num_threads: including the thread that calls Remap(); 0: one per processor
  explicit BandRemap(unsigned num_threads);
  ~BandRemap();
  BandRemap(const BandRemap&) = delete;
  BandRemap& operator=(const BandRemap&) = delete;

  unsigned num_threads() const {
    return static_cast<unsigned>(threads_.size()) + 1;
  }

  /// Undistorts all rows of the target, whose planes are laid out as in format,
  /// but with the strides of the target. Returns the status of the first band
  /// that fails, or RG_OK. Not reentrant.
  rg_status Remap(const rg_camera& camera, const rg_image& image,
                  const StreamFormat& format, const rg_target& target);

 private:
  struct Job {
    const rg_camera* camera = nullptr;
    const rg_image* image = nullptr;
    const StreamFormat* format = nullptr;
    const rg_target* target = nullptr;
    uint32_t band_rows = 0, num_bands = 0;
  };

  void RunWorker(unsigned thread);
  // Processes bands until none is free; the lock is held before and after.
  void RemapBands(unsigned thread, std::unique_lock<std::mutex>* lock);
  uint32_t ClaimBand(unsigned thread);
  rg_status RemapBand(const Job& job, uint32_t first_row) const;

  std::vector<std::thread> threads_;
  std::mutex mutex_;  // guards all members below; atomics are also read without
                      // it
  std::condition_variable has_work_, is_done_;
  Job job_;
  std::atomic<uint64_t> free_bands_{0};  // one bit per band
  std::atomic<uint32_t> num_undone_{0};
  std::atomic<bool> is_stopped_{false};
  rg_status status_ = RG_OK;
  uint32_t failed_band_ = 0;
};

}  // namespace raygrid

#endif  // RAYGRID_LIBCAMERA_BAND_REMAP_H
