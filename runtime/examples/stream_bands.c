/* Undistorts a grey frame while the sensor sends it, on a Cortex-M with memory
 * for a ring buffer of rows, but not for a frame. */
#include "stream_bands.h"

static uint8_t ring[RING_ROWS * SENSOR_WIDTH];
static uint8_t band[BAND_ROWS * SENSOR_WIDTH];

/* Receives rows until the ring's last row is end_row - 1. */
static void receive_up_to(uint32_t end_row, rg_image* image) {
  uint32_t row = (uint32_t)image->first_row + image->num_rows;
  for (; row < end_row; ++row)
    board_receive_row(ring + row % RING_ROWS * SENSOR_WIDTH);
  image->first_row = (uint16_t)(row < RING_ROWS ? 0 : row - RING_ROWS);
  image->num_rows = (uint16_t)(row - image->first_row);
}

static rg_status stream_band(const rg_camera* camera, rg_image* image,
                             const rg_target* target, uint32_t width) {
  uint16_t first_source, num_source;
  rg_status status =
      rg_remap_source_rows(camera, image->format, target->first_row,
                           target->num_rows, &first_source, &num_source);
  if (status != RG_OK) return status;
  receive_up_to((uint32_t)first_source + num_source, image);
  /* RG_ERR_ROWS_MISSING if the distortion requires a larger ring. */
  status = rg_remap(camera, image, target);
  if (status != RG_OK) return status;
  for (uint32_t k = 0; k < target->num_rows; ++k)
    board_send_row(band + k * SENSOR_WIDTH, width);
  return RG_OK;
}

rg_status stream_frame(const rg_camera* camera) {
  uint16_t width, height, frame_width, frame_height;
  rg_frame_size(camera, &frame_width, &frame_height);
  rg_status status = rg_remap_size(camera, &width, &height);
  if (status != RG_OK) return status;
  rg_image image = {.format = RG_FORMAT_GREY8,
                    .width = frame_width,
                    .height = frame_height,
                    .ring_rows = RING_ROWS,
                    .planes = {{ring, SENSOR_WIDTH}}};
  rg_target target = {.planes = {{band, SENSOR_WIDTH}},
                      .border = RG_BORDER_VALUE}; /* black */
  for (uint32_t row = 0; row < height; row += BAND_ROWS) {
    target.first_row = (uint16_t)row;
    target.num_rows =
        (uint16_t)(height - row < BAND_ROWS ? height - row : BAND_ROWS);
    status = stream_band(camera, &image, &target, width);
    if (status != RG_OK) return status;
  }
  receive_up_to(frame_height, &image); /* unused remaining rows */
  return RG_OK;
}
