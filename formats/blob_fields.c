/* Reads the sections' fields into structures; see SPEC.md, "Sections". */
#include "blob_checks.h"
#include "bytes.h"
#include "rg_blob.h"

void rg_blob_camera(const rg_blob* blob, rg_camera_section* camera) {
  const uint8_t* section = blob->bytes + blob->camera;
  camera->width = rg_load_u16(section + RG_CAMERA_WIDTH);
  camera->height = rg_load_u16(section + RG_CAMERA_HEIGHT);
  camera->name = (const char*)(section + RG_CAMERA_NAME);
  camera->serial = (const char*)(section + RG_CAMERA_SERIAL);
}

void rg_blob_grid(const rg_blob* blob, rg_grid_section* grid) {
  const uint8_t* section = blob->bytes + blob->grid;
  grid->x0_q16 = rg_load_i32(section + RG_GRID_X0);
  grid->y0_q16 = rg_load_i32(section + RG_GRID_Y0);
  grid->x1_q16 = rg_load_i32(section + RG_GRID_X1);
  grid->y1_q16 = rg_load_i32(section + RG_GRID_Y1);
  grid->columns = rg_load_u16(section + RG_GRID_COLUMNS);
  grid->rows = rg_load_u16(section + RG_GRID_ROWS);
  grid->scale_x_q32 = rg_load_u32(section + RG_GRID_SCALE_X);
  grid->scale_y_q32 = rg_load_u32(section + RG_GRID_SCALE_Y);
  grid->control_points = section + rg_load_u32(section + RG_GRID_DATA_OFFSET);
}

void rg_blob_control_point(const rg_blob* blob, uint32_t column, uint32_t row,
                           int32_t point_q29[2]) {
  const uint8_t* const section = blob->bytes + blob->grid;
  const uint8_t* const data =
      section + rg_load_u32(section + RG_GRID_DATA_OFFSET);
  const uint32_t k = row * rg_load_u16(section + RG_GRID_COLUMNS) + column;
  const uint32_t bits = rg_load_u16(section + RG_GRID_FRACTION_BITS);
  for (uint32_t c = 0; c < 2; ++c) {
    if (bits == RG_CONTROL_POINT_BITS) {
      point_q29[c] = rg_load_i32(data + RG_CONTROL_POINT_SIZE * k + 4 * c);
      continue;
    }
    const uint8_t* const plane = data + 4 * c;
    const uint8_t* const residual =
        data + RG_NARROW_PLANE_SIZE + RG_NARROW_POINT_SIZE * k + 2 * c;
    point_q29[c] =
        (int32_t)(rg_load_u32(plane + RG_PLANE_ORIGIN) +
                  column * rg_load_u32(plane + RG_PLANE_COLUMN_STEP) +
                  row * rg_load_u32(plane + RG_PLANE_ROW_STEP) +
                  ((uint32_t)rg_load_i16(residual)
                   << (RG_CONTROL_POINT_BITS - bits)));
  }
}

void rg_read_remap(const uint8_t* section, rg_remap_section* remap) {
  remap->width = rg_load_u16(section + RG_REMAP_WIDTH);
  remap->height = rg_load_u16(section + RG_REMAP_HEIGHT);
  remap->columns = rg_load_u16(section + RG_REMAP_COLUMNS);
  remap->rows = rg_load_u16(section + RG_REMAP_ROWS);
  remap->block_log2 = section[RG_REMAP_BLOCK_LOG2];
  remap->residual_shift = section[RG_REMAP_RESIDUAL_SHIFT];
  remap->part_log2 = section[RG_REMAP_PART_LOG2];
  remap->bend_shift = (uint8_t)rg_bend_shift(section);
  remap->min_x_q12 = rg_load_i32(section + RG_REMAP_MIN_X);
  remap->min_y_q12 = rg_load_i32(section + RG_REMAP_MIN_Y);
  remap->max_x_q12 = rg_load_i32(section + RG_REMAP_MAX_X);
  remap->max_y_q12 = rg_load_i32(section + RG_REMAP_MAX_Y);
  remap->origin_x_q12 = rg_load_i32(section + RG_REMAP_ORIGIN);
  remap->origin_y_q12 = rg_load_i32(section + RG_REMAP_ORIGIN + 4);
  remap->column_step_x_q12 = rg_load_i32(section + RG_REMAP_COLUMN_STEP);
  remap->column_step_y_q12 = rg_load_i32(section + RG_REMAP_COLUMN_STEP + 4);
  remap->row_step_x_q12 = rg_load_i32(section + RG_REMAP_ROW_STEP);
  remap->row_step_y_q12 = rg_load_i32(section + RG_REMAP_ROW_STEP + 4);
  remap->fx_q16 = rg_load_u32(section + RG_REMAP_FX);
  remap->fy_q16 = rg_load_u32(section + RG_REMAP_FY);
  remap->cx_q16 = rg_load_i32(section + RG_REMAP_CX);
  remap->cy_q16 = rg_load_i32(section + RG_REMAP_CY);
  remap->bound_upx = rg_load_u32(section + RG_REMAP_BOUND_UPX);
  remap->max_error_upx = rg_load_u32(section + RG_REMAP_MAX_ERROR_UPX);
  remap->has_view = (uint8_t)rg_has_view(section);
  remap->projection = RG_PROJECTION_PINHOLE;
  remap->mode = 0;
  remap->direction = RG_UNDISTORT;
  remap->source_width = remap->source_height = 0;
  if (remap->has_view) {
    remap->projection = section[RG_VIEW_PROJECTION];
    remap->mode = section[RG_VIEW_MODE];
    remap->direction = section[RG_VIEW_DIRECTION];
    remap->source_width = rg_load_u16(section + RG_VIEW_SOURCE_WIDTH);
    remap->source_height = rg_load_u16(section + RG_VIEW_SOURCE_HEIGHT);
  }
  for (uint32_t k = 0; k < 9; ++k)
    remap->rotation_q30[k] =
        remap->has_view ? rg_load_i32(section + RG_VIEW_ROTATION + 4 * k)
                        : (int32_t)(k % 4 == 0) * (INT32_C(1) << 30);
  remap->vertices = section + rg_load_u32(section + RG_REMAP_DATA_OFFSET);
  remap->bends = 0;
  remap->empty_blocks =
      remap->vertices +
      (remap->part_log2 != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE) *
          remap->columns * remap->rows;
}

void rg_blob_quality(const rg_blob* blob, rg_quality_section* quality) {
  const uint8_t* section = blob->bytes + blob->quality;
  quality->training_median_upx =
      rg_load_u32(section + RG_QUALITY_TRAINING_MEDIAN_UPX);
  quality->training_rms_upx =
      rg_load_u32(section + RG_QUALITY_TRAINING_RMS_UPX);
  quality->training_max_upx =
      rg_load_u32(section + RG_QUALITY_TRAINING_MAX_UPX);
  quality->training_count = rg_load_u32(section + RG_QUALITY_TRAINING_COUNT);
  quality->held_out_median_upx =
      rg_load_u32(section + RG_QUALITY_HELD_OUT_MEDIAN_UPX);
  quality->held_out_rms_upx =
      rg_load_u32(section + RG_QUALITY_HELD_OUT_RMS_UPX);
  quality->held_out_max_upx =
      rg_load_u32(section + RG_QUALITY_HELD_OUT_MAX_UPX);
  quality->held_out_count = rg_load_u32(section + RG_QUALITY_HELD_OUT_COUNT);
  quality->packing_error_npx =
      rg_load_u32(section + RG_QUALITY_PACKING_ERROR_NPX);
  quality->packing_error_prad =
      rg_load_u32(section + RG_QUALITY_PACKING_ERROR_PRAD);
}

void rg_blob_inverse(const rg_blob* blob, rg_inverse_section* inverse) {
  const uint8_t* section = blob->bytes + blob->inverse;
  inverse->a0_q27 = rg_load_i32(section + RG_INVERSE_A0);
  inverse->b0_q27 = rg_load_i32(section + RG_INVERSE_B0);
  inverse->a1_q27 = rg_load_i32(section + RG_INVERSE_A1);
  inverse->b1_q27 = rg_load_i32(section + RG_INVERSE_B1);
  inverse->columns = rg_load_u16(section + RG_INVERSE_COLUMNS);
  inverse->rows = rg_load_u16(section + RG_INVERSE_ROWS);
  inverse->scale_a_q21 = rg_load_u32(section + RG_INVERSE_SCALE_A);
  inverse->scale_b_q21 = rg_load_u32(section + RG_INVERSE_SCALE_B);
  inverse->cos_limit_q30 = rg_load_i32(section + RG_INVERSE_COS_LIMIT);
}

const uint8_t* rg_blob_line_points(const rg_blob* blob) {
  const uint8_t* const section = blob->bytes + blob->line_points;
  return section + rg_load_u32(section + RG_LINE_POINTS_DATA_OFFSET);
}

void rg_blob_mask(const rg_blob* blob, rg_mask_section* mask) {
  const uint8_t* const section = blob->bytes + blob->mask;
  mask->columns = rg_load_u16(section + RG_MASK_COLUMNS);
  mask->rows = rg_load_u16(section + RG_MASK_ROWS);
  mask->cell_log2 = section[RG_MASK_CELL_LOG2];
  mask->bits = section + rg_load_u32(section + RG_MASK_DATA_OFFSET);
}

uint32_t rg_blob_num_modes(const rg_blob* blob) {
  const uint8_t* const entry = rg_find_entry(blob->bytes, RG_SECTION_MODES, 0);
  return entry ? rg_load_u32(entry + RG_ENTRY_SIZE) / RG_MODE_SIZE : 0;
}

void rg_blob_mode(const rg_blob* blob, uint32_t index, rg_mode_section* mode) {
  const uint8_t* const section =
      blob->bytes + blob->modes + index * RG_MODE_SIZE;
  mode->width = rg_load_u16(section + RG_MODE_WIDTH);
  mode->height = rg_load_u16(section + RG_MODE_HEIGHT);
  mode->offset_x_q16 = rg_load_i32(section + RG_MODE_OFFSET_X);
  mode->offset_y_q16 = rg_load_i32(section + RG_MODE_OFFSET_Y);
  mode->scale_x_q16 = rg_load_u32(section + RG_MODE_SCALE_X);
  mode->scale_y_q16 = rg_load_u32(section + RG_MODE_SCALE_Y);
  mode->flip_x = section[RG_MODE_FLIP_X];
  mode->flip_y = section[RG_MODE_FLIP_Y];
  mode->name = (const char*)(section + RG_MODE_NAME);
}

void rg_blob_uncertainty(const rg_blob* blob,
                         rg_uncertainty_section* uncertainty) {
  const uint8_t* const section = blob->bytes + blob->uncertainty;
  uncertainty->columns = rg_load_u16(section + RG_UNCERTAINTY_COLUMNS);
  uncertainty->rows = rg_load_u16(section + RG_UNCERTAINTY_ROWS);
  uncertainty->scale_x_q32 = rg_load_u32(section + RG_UNCERTAINTY_SCALE_X);
  uncertainty->scale_y_q32 = rg_load_u32(section + RG_UNCERTAINTY_SCALE_Y);
  uncertainty->values =
      section + rg_load_u32(section + RG_UNCERTAINTY_DATA_OFFSET);
}

void rg_blob_row_time(const rg_blob* blob, rg_row_time_section* row_time) {
  const uint8_t* const section = blob->bytes + blob->row_time;
  row_time->row_time_ns_q10 = rg_load_i32(section + RG_ROW_TIME_ROW_TIME);
  row_time->stddev_ns_q10 = rg_load_u32(section + RG_ROW_TIME_DEVIATION);
}

void rg_blob_capture(const rg_blob* blob, rg_capture_section* capture) {
  const uint8_t* const section = blob->bytes + blob->capture;
  capture->known = section[RG_CAPTURE_KNOWN];
  capture->lens_position_q16 = rg_load_i32(section + RG_CAPTURE_LENS_POSITION);
  capture->lens_tolerance_q16 =
      rg_load_u32(section + RG_CAPTURE_LENS_TOLERANCE);
  capture->crop_x = rg_load_i32(section + RG_CAPTURE_CROP_X);
  capture->crop_y = rg_load_i32(section + RG_CAPTURE_CROP_Y);
  capture->crop_width = rg_load_u32(section + RG_CAPTURE_CROP_WIDTH);
  capture->crop_height = rg_load_u32(section + RG_CAPTURE_CROP_HEIGHT);
  capture->zoom_q16 = rg_load_u32(section + RG_CAPTURE_ZOOM);
  capture->orientation = section[RG_CAPTURE_ORIENTATION];
  capture->temperature_q16 = rg_load_i32(section + RG_CAPTURE_TEMPERATURE);
  capture->exposure_us = rg_load_u32(section + RG_CAPTURE_EXPOSURE);
  capture->analogue_gain_q16 = rg_load_u32(section + RG_CAPTURE_ANALOGUE_GAIN);
}
