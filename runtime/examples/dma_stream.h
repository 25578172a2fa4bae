/* Frames that a DMA writes band by band, undistorted while they come: for
 * boards with room for a ring of bands, and none for a frame.
 *
 * The DMA fills a band of rows after the other, each into the next slot of the
 * ring, and interrupts after each. Meanwhile the processor undistorts what has
 * all its rows. So a band of output leaves as soon as its last row is in.
 *
 *   dma_stream_check()       once, for a camera
 *   dma_stream_begin()       before the DMA starts with a frame
 *   dma_stream_filled()      by the interrupt handler, for each band
 *   dma_stream_undistort()   the frame */
#ifndef RAYGRID_DMA_STREAM_H
#define RAYGRID_DMA_STREAM_H

#include <stdint.h>

#include "raygrid.h"

typedef struct dma_stream {
  rg_format format;
  uint16_t width, height; /* of the sensor */
  uint8_t pixel_bytes;
  uint8_t band_rows_log2; /* rows of a band the DMA fills; height has whole
                             bands */
  uint8_t num_slots_log2; /* bands in the ring */
  uint8_t out_rows;       /* of the output that are made at once */
  uint8_t* ring;          /* the DMA writes it, the processor only reads */
  uint8_t* out[2];        /* the one is made while the other one is sent */
  uint32_t num_sent;      /* bands of the output, of all frames */
  uint32_t num_seen;      /* bands of this frame that may be read */
  volatile uint32_t num_filled; /* by the handler: bands of this frame */
  volatile uint32_t has_failed; /* by a handler: the frame is spoiled */
} dma_stream;

/* ---- What a board gives ------------------------------------------------- */

/* Holds interrupts back, and lets them through again. */
uint32_t board_lock(void);
void board_unlock(uint32_t state);

/* Sleeps until there is an interrupt, also one that is held back. */
void board_sleep(void);

/* Makes the processor forget what its cache holds of memory that a DMA has
 * written. Nothing where there is no cache. */
void board_invalidate(const void* begin, uint32_t num_bytes);

/* Writes what the cache holds to memory that a DMA will read. */
void board_clean(const void* begin, uint32_t num_bytes);

/* Waits until what was sent before has left its buffer, then sends. */
void board_send(const uint8_t* bytes, uint32_t num_bytes);

/* ---- What a board calls ------------------------------------------------- */

/* The slot of a band, counted from the top of the frame. */
uint8_t* dma_stream_slot(const dma_stream* stream, uint32_t band);

/* RG_ERR_FRAME_SIZE where the camera's table is not for this sensor, or its
 * output is wider than the sensor. RG_ERR_ROWS_MISSING where the lens bends
 * rows so much that the ring has too few slots. */
rg_status dma_stream_check(const dma_stream* stream, const rg_camera* camera);

void dma_stream_begin(dma_stream* stream);
void dma_stream_filled(dma_stream* stream);
void dma_stream_fail(dma_stream* stream);

/* Undistorts the frame and sends it. Returns when the last band of the frame
 * is in. RG_ERR_ROWS_MISSING where the DMA failed, or was so far ahead that it
 * wrote over rows in use: then the frame is cut off before them. */
rg_status dma_stream_undistort(dma_stream* stream, const rg_camera* camera);

#endif /* RAYGRID_DMA_STREAM_H */
