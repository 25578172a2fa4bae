/* Undistorts frames while a DMA writes them band by band. */
#include "dma_stream.h"

static uint32_t band_bytes(const dma_stream* stream) {
  return ((uint32_t)stream->width * stream->pixel_bytes)
         << stream->band_rows_log2;
}

uint8_t* dma_stream_slot(const dma_stream* stream, uint32_t band) {
  const uint32_t slot = band & ((1u << stream->num_slots_log2) - 1);
  return stream->ring + slot * band_bytes(stream);
}

/* The bands [first, end) that rows of the output require; empty if these rows
 * have no source. At most one less than the number of slots, since the DMA is
 * filling the remaining slot. */
static rg_status find_bands(const dma_stream* stream, const rg_camera* camera,
                            const rg_target* target, uint32_t* first,
                            uint32_t* end) {
  uint16_t first_row, num_rows;
  const rg_status status =
      rg_remap_source_rows(camera, stream->format, target->first_row,
                           target->num_rows, &first_row, &num_rows);
  if (status != RG_OK) return status;
  *first = *end = 0;
  if (num_rows == 0) return RG_OK;
  *first = (uint32_t)first_row >> stream->band_rows_log2;
  *end = (((uint32_t)first_row + num_rows - 1) >> stream->band_rows_log2) + 1;
  return *end - *first < 1u << stream->num_slots_log2 ? RG_OK
                                                      : RG_ERR_ROWS_MISSING;
}

/* Advances target to the next rows of the output; 0 after the last row. */
static int next_rows(const dma_stream* stream, uint16_t height,
                     rg_target* target) {
  const uint32_t row = (uint32_t)target->first_row + target->num_rows;
  target->first_row = (uint16_t)row;
  target->num_rows =
      (uint16_t)(height - row < stream->out_rows ? height - row
                                                 : stream->out_rows);
  return target->num_rows > 0;
}

rg_status dma_stream_check(const dma_stream* stream, const rg_camera* camera) {
  uint16_t width, height, frame_width, frame_height;
  rg_status status = rg_remap_size(camera, &width, &height);
  if (status != RG_OK) return status;
  rg_frame_size(camera, &frame_width, &frame_height);
  if (frame_width != stream->width || frame_height != stream->height ||
      width > stream->width)
    return RG_ERR_FRAME_SIZE;
  rg_target target = {.num_rows = 0};
  while (status == RG_OK && next_rows(stream, height, &target)) {
    uint32_t first, end;
    status = find_bands(stream, camera, &target, &first, &end);
  }
  return status;
}

void dma_stream_begin(dma_stream* stream) {
  stream->num_seen = stream->num_filled = stream->has_failed = 0;
  /* Cache maintenance before the DMA starts: dirty lines of the ring, for
   * example from zeroing by start-up code, would be evicted later and overwrite
   * DMA data. */
  board_invalidate(stream->ring, band_bytes(stream) << stream->num_slots_log2);
}

void dma_stream_filled(dma_stream* stream) {
  stream->num_filled = stream->num_filled + 1;
}

void dma_stream_fail(dma_stream* stream) { stream->has_failed = 1; }

/* Waits for the first num_bands bands of the frame. */
static rg_status wait_for_bands(dma_stream* stream, uint32_t num_bands) {
  for (int is_there = 0; !is_there;) {
    /* Interrupts are masked: an interrupt between the check and the sleep would
     * otherwise be missed. */
    const uint32_t state = board_lock();
    is_there = stream->num_filled >= num_bands || stream->has_failed;
    if (!is_there) board_sleep();
    board_unlock(state);
  }
  if (stream->has_failed) return RG_ERR_ROWS_MISSING;
  /* Cache maintenance after the DMA has completed a band and before its first
   * pixel is read: lines may contain the slot's previous band, or may have been
   * prefetched speculatively during the DMA. Once per band suffices, since it
   * is not written again until the ring wraps around. */
  for (; stream->num_seen < num_bands; ++stream->num_seen)
    board_invalidate(dma_stream_slot(stream, stream->num_seen),
                     band_bytes(stream));
  return RG_OK;
}

/* Whether the DMA has started to overwrite a band. */
static int is_overtaken(const dma_stream* stream, uint32_t band) {
  return stream->num_filled >= band + (1u << stream->num_slots_log2);
}

static rg_status undistort_rows(dma_stream* stream, const rg_camera* camera,
                                const rg_target* target) {
  uint32_t first, end;
  rg_status status = find_bands(stream, camera, target, &first, &end);
  if (status == RG_OK && end > 0) status = wait_for_bands(stream, end);
  if (status != RG_OK) return status;
  const rg_image image = {
      .format = stream->format,
      .width = stream->width,
      .height = stream->height,
      .ring_rows =
          (uint16_t)(1u << (stream->band_rows_log2 + stream->num_slots_log2)),
      .first_row = (uint16_t)(first << stream->band_rows_log2),
      .num_rows = (uint16_t)((end - first) << stream->band_rows_log2),
      .planes = {
          {stream->ring, (uint32_t)stream->width * stream->pixel_bytes}}};
  status = rg_remap(camera, &image, target);
  /* Checked after remapping, since the band may have been overwritten
   * meanwhile. */
  if (status == RG_OK && end > 0 && is_overtaken(stream, first))
    status = RG_ERR_ROWS_MISSING;
  return status;
}

rg_status dma_stream_undistort(dma_stream* stream, const rg_camera* camera) {
  uint16_t width, height;
  rg_status status = rg_remap_size(camera, &width, &height);
  if (status != RG_OK) return status;
  const uint32_t stride = (uint32_t)width * stream->pixel_bytes;
  rg_target target = {.border = RG_BORDER_VALUE}; /* black */
  if (stream->format == RG_FORMAT_YUYV) {
    target.border_values[0] = 16;
    target.border_values[1] = target.border_values[2] = 128;
  }
  while (next_rows(stream, height, &target)) {
    /* Two buffers suffice: a band is sent only after the previous one has been
     * sent completely, so its buffer is free again. */
    uint8_t* const out = stream->out[stream->num_sent & 1];
    target.planes[0].data = out;
    target.planes[0].stride = stride;
    status = undistort_rows(stream, camera, &target);
    if (status != RG_OK) return status;
    /* Cache maintenance after the last pixel is written and before the DMA
     * reads. */
    board_clean(out, target.num_rows * stride);
    board_send(out, target.num_rows * stride);
    ++stream->num_sent;
  }
  return wait_for_bands(stream,
                        (uint32_t)stream->height >> stream->band_rows_log2);
}
