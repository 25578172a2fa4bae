/* Rows in and out of stream_bands.c: the functions that the board gives, and
 * the one that it calls. */
#ifndef RAYGRID_STREAM_BANDS_H
#define RAYGRID_STREAM_BANDS_H

#include <stdint.h>

#include "raygrid.h"

#define SENSOR_WIDTH 320u
#define RING_ROWS 40u /* of the sensor that are kept */
#define BAND_ROWS 2u  /* of the output that are made at once */

/* Waits for the sensor's next row; they come from the top. */
void board_receive_row(uint8_t* pixels);

/* Gives a row of the undistorted frame on. */
void board_send_row(const uint8_t* pixels, uint32_t num_pixels);

/* Undistorts one frame; the output is at most SENSOR_WIDTH wide. */
rg_status stream_frame(const rg_camera* camera);

#endif /* RAYGRID_STREAM_BANDS_H */
