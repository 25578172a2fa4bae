/* Undistortion of frames while a DMA writes them band by band: for boards with
 * memory for a ring buffer of bands, but not for a frame.
 *
 * The DMA writes each band of rows into the next slot of the ring buffer, with
 * an interrupt after each. Meanwhile the processor undistorts the output rows
 * whose source rows are complete, so that a band is sent with minimum latency.
 *
 *   dma_stream_check()       once for each camera
 *   dma_stream_begin()       before the DMA starts a frame
 *   dma_stream_filled()      in the interrupt handler, for each band
 *   dma_stream_undistort()   undistorts the frame */
#ifndef RAYGRID_DMA_STREAM_H
#define RAYGRID_DMA_STREAM_H

#include <stdint.h>

#include "raygrid.h"

typedef struct dma_stream {
  rg_format format;
  uint16_t width, height; /* size of the sensor's frames */
  uint8_t pixel_bytes;
  uint8_t band_rows_log2; /* log2 of the rows per DMA band; the height must be a
                             multiple */
  uint8_t num_slots_log2; /* log2 of the bands in the ring buffer */
  uint8_t out_rows;       /* rows per output band */
  uint8_t* ring;          /* written by the DMA, read by the processor */
  uint8_t* out[2];        /* one is written while the other one is sent */
  uint32_t num_sent;      /* output bands, total over all frames */
  uint32_t num_seen;      /* bands of this frame that may be read */
  volatile uint32_t num_filled; /* bands of this frame, set by the handler */
  volatile uint32_t has_failed; /* set by a handler: the frame is incomplete */
} dma_stream;

/* ---- Implemented by the board ------------------------------------------- */

/* Disables interrupts and returns their state; restores the state. */
uint32_t board_lock(void);
void board_unlock(uint32_t state);

/* Sleeps until an interrupt is pending, even if it is disabled. */
void board_sleep(void);

/* Invalidates the cache of memory that a DMA has written. No effect without a
 * cache. */
void board_invalidate(const void* begin, uint32_t num_bytes);

/* Cleans the cache of memory that a DMA will read: writes it back. */
void board_clean(const void* begin, uint32_t num_bytes);

/* Waits until the previous buffer is sent, then starts sending this one. */
void board_send(const uint8_t* bytes, uint32_t num_bytes);

/* ---- Called by the board ------------------------------------------------ */

/* Returns the slot of a band, 0-based from the top of the frame. */
uint8_t* dma_stream_slot(const dma_stream* stream, uint32_t band);

/* Returns RG_ERR_FRAME_SIZE if the selected table has another source size than
 * the sensor, or its output is wider; RG_ERR_ROWS_MISSING if the ring buffer
 * has too few slots for the distortion of rows. */
rg_status dma_stream_check(const dma_stream* stream, const rg_camera* camera);

void dma_stream_begin(dma_stream* stream);
void dma_stream_filled(dma_stream* stream);
void dma_stream_fail(dma_stream* stream);

/* Undistorts the frame and sends it. Returns when the last band of the frame is
 * received. RG_ERR_ROWS_MISSING if the DMA failed, or overwrote rows in use;
 * the rest of the frame is then not sent. */
rg_status dma_stream_undistort(dma_stream* stream, const rg_camera* camera);

#endif /* RAYGRID_DMA_STREAM_H */
