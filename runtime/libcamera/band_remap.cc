#include "band_remap.h"

#include <algorithm>
#include <chrono>

namespace raygrid {
namespace {

// Minimum rows per band: the overhead of each rg_remap() call is then below one
// per cent.
constexpr uint32_t kMinRows = 32;
// Bands per thread, so that a late or interrupted thread causes little delay.
// All bands must fit in one word, a bit each.
constexpr uint32_t kBandsPerThread = 3, kMaxBands = 64;
constexpr std::chrono::microseconds kAwake{100};

uint32_t BandRows(uint32_t rows, uint32_t num_threads) {
  if (num_threads == 1) return rows;
  const uint32_t bands = std::min(num_threads * kBandsPerThread, kMaxBands);
  const uint32_t even_rows = ((rows + bands - 1) / bands + 1) / 2 * 2;
  return std::max(even_rows, kMinRows);
}

// Busy-waits, yielding to others, until a condition holds or time is over.
template <typename Condition>
void SpinUntil(const Condition& is_so) {
  const auto end = std::chrono::steady_clock::now() + kAwake;
  while (!is_so() && std::chrono::steady_clock::now() < end)
    std::this_thread::yield();
}

}  // namespace

BandRemap::BandRemap(unsigned num_threads) {
  if (num_threads == 0)
    num_threads = std::max(1u, std::thread::hardware_concurrency());
  for (unsigned k = 1; k < num_threads; ++k)
    threads_.emplace_back(&BandRemap::RunWorker, this, k);
}

BandRemap::~BandRemap() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
  }
  has_work_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

rg_status BandRemap::Remap(const rg_camera& camera, const rg_image& image,
                           const StreamFormat& format,
                           const rg_target& target) {
  std::unique_lock<std::mutex> lock(mutex_);
  const uint32_t band_rows = BandRows(format.height, num_threads());
  const uint32_t num_bands = (format.height + band_rows - 1) / band_rows;
  job_ = {&camera, &image, &format, &target, band_rows, num_bands};
  status_ = RG_OK;
  num_undone_ = num_bands;
  free_bands_ = ~uint64_t{0} >> (kMaxBands - num_bands);
  if (!threads_.empty()) has_work_.notify_all();
  RemapBands(0, &lock);
  lock.unlock();
  SpinUntil([this] { return num_undone_ == 0; });
  lock.lock();
  is_done_.wait(lock, [this] { return num_undone_ == 0; });
  return status_;
}

void BandRemap::RunWorker(unsigned thread) {
  const auto is_called = [this] { return is_stopped_ || free_bands_ != 0; };
  std::unique_lock<std::mutex> lock(mutex_);
  while (!is_stopped_) {
    RemapBands(thread, &lock);
    lock.unlock();
    SpinUntil(is_called);
    lock.lock();
    has_work_.wait(lock, is_called);
  }
}

// A thread's own bands are adjacent, and the same in every frame: their rows
// are in its processor's cache.
uint32_t BandRemap::ClaimBand(unsigned thread) {
  uint32_t band = thread * job_.num_bands / num_threads();
  while ((free_bands_ >> band & 1) == 0)
    band = band + 1 == job_.num_bands ? 0 : band + 1;
  free_bands_ &= ~(uint64_t{1} << band);
  return band;
}

void BandRemap::RemapBands(unsigned thread,
                           std::unique_lock<std::mutex>* lock) {
  while (free_bands_ != 0) {
    const Job job = job_;
    const uint32_t band = ClaimBand(thread);
    lock->unlock();
    const rg_status status = RemapBand(job, band * job.band_rows);
    lock->lock();
    if (status != RG_OK && (status_ == RG_OK || band < failed_band_)) {
      status_ = status;
      failed_band_ = band;
    }
    if (--num_undone_ == 0) is_done_.notify_all();
  }
}

rg_status BandRemap::RemapBand(const Job& job, uint32_t first_row) const {
  rg_target band = *job.target;
  const uint32_t height = job.format->height;
  band.first_row = static_cast<uint16_t>(first_row);
  band.num_rows =
      static_cast<uint16_t>(std::min(job.band_rows, height - first_row));
  for (int i = 0; i < job.format->num_planes; ++i)
    band.planes[i].data += size_t{band.planes[i].stride} * first_row *
                           job.format->planes[i].rows / height;
  return rg_remap(job.camera, job.image, &band);
}

}  // namespace raygrid
