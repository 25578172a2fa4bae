#include "band_remap.h"

#include <algorithm>

namespace raygrid {
namespace {

// Rows of the smallest band: what each call of rg_remap() costs is then less
// than a hundredth.
constexpr uint32_t kLeastRows = 32;
// Bands for each thread, so that one which is interrupted delays little.
constexpr uint32_t kBandsPerThread = 4;

uint32_t BandRows(uint32_t rows, uint32_t num_threads) {
  if (num_threads == 1) return rows;
  const uint32_t bands = num_threads * kBandsPerThread;
  const uint32_t even_rows = ((rows + bands - 1) / bands + 1) / 2 * 2;
  return std::max(even_rows, kLeastRows);
}

}  // namespace

BandRemap::BandRemap(unsigned num_threads) {
  if (num_threads == 0)
    num_threads = std::max(1u, std::thread::hardware_concurrency());
  for (unsigned k = 1; k < num_threads; ++k)
    threads_.emplace_back(&BandRemap::Serve, this);
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
  job_ = {&camera, &image, &format, &target,
          BandRows(format.height, num_threads())};
  next_row_ = 0;
  status_ = RG_OK;
  if (!threads_.empty()) has_work_.notify_all();
  WorkOn(&lock);
  is_done_.wait(lock, [this] { return num_open_ == 0; });
  return status_;
}

void BandRemap::Serve() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!is_stopped_) {
    WorkOn(&lock);
    has_work_.wait(lock, [this] {
      return is_stopped_ || (job_.format && next_row_ < job_.format->height);
    });
  }
}

void BandRemap::WorkOn(std::unique_lock<std::mutex>* lock) {
  while (job_.format && next_row_ < job_.format->height) {
    const Job job = job_;
    const uint32_t row = next_row_;
    next_row_ += job.band_rows;
    ++num_open_;
    lock->unlock();
    const rg_status status = RemapBand(job, row);
    lock->lock();
    if (status != RG_OK && (status_ == RG_OK || row < failed_row_)) {
      status_ = status;
      failed_row_ = row;
    }
    --num_open_;
  }
  if (num_open_ == 0) {
    job_.format = nullptr;
    is_done_.notify_all();
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
