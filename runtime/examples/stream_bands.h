/* Input and output of rows for stream_bands.c: functions that the board
 * implements, and the function that it calls. */
#ifndef RAYGRID_STREAM_BANDS_H
#define RAYGRID_STREAM_BANDS_H

#include <stdint.h>

#include "raygrid.h"

#define SENSOR_WIDTH 320u
#define RING_ROWS 40u /* rows of the ring buffer */
#define BAND_ROWS 2u  /* rows per output band */

/* Waits for the next row of the sensor, in order from the top. */
void board_receive_row(uint8_t* pixels);

/* Sends a row of the undistorted frame. */
void board_send_row(const uint8_t* pixels, uint32_t num_pixels);

/* Undistorts one frame, whose output is at most SENSOR_WIDTH wide. */
rg_status stream_frame(const rg_camera* camera);

#endif /* RAYGRID_STREAM_BANDS_H */
