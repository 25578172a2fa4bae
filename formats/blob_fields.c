/* The sections' fields as structures. The offsets are those of SPEC.md,
 * "Sections". */
#include "bytes.h"
#include "rg_blob.h"

void rg_blob_camera(const rg_blob* blob, rg_camera_section* camera) {
  const uint8_t* section = blob->bytes + blob->camera;
  camera->width = rg_load_u16(section);
  camera->height = rg_load_u16(section + 2);
  camera->name = (const char*)(section + 8);
  camera->serial = (const char*)(section + 40);
}

void rg_blob_grid(const rg_blob* blob, rg_grid_section* grid) {
  const uint8_t* section = blob->bytes + blob->grid;
  grid->x0_q16 = rg_load_i32(section);
  grid->y0_q16 = rg_load_i32(section + 4);
  grid->x1_q16 = rg_load_i32(section + 8);
  grid->y1_q16 = rg_load_i32(section + 12);
  grid->columns = rg_load_u16(section + 16);
  grid->rows = rg_load_u16(section + 18);
  grid->scale_x_q32 = rg_load_u32(section + 20);
  grid->scale_y_q32 = rg_load_u32(section + 24);
  grid->control_points = section + rg_load_u32(section + 32);
}

void rg_blob_control_point(const rg_blob* blob, uint32_t column, uint32_t row,
                           int32_t point_q29[2]) {
  const uint8_t* const section = blob->bytes + blob->grid;
  const uint8_t* const data = section + rg_load_u32(section + 32);
  const uint32_t k = row * rg_load_u16(section + 16) + column;
  const uint32_t bits = rg_load_u16(section + 30);
  for (uint32_t c = 0; c < 2; ++c) {
    if (bits == RG_CONTROL_POINT_BITS) {
      point_q29[c] = rg_load_i32(data + 8 * k + 4 * c);
      continue;
    }
    const uint8_t* const plane = data + 4 * c;
    const uint8_t* const residual = data + RG_NARROW_PLANE_SIZE + 4 * k + 2 * c;
    point_q29[c] =
        (int32_t)(rg_load_u32(plane) + column * rg_load_u32(plane + 8) +
                  row * rg_load_u32(plane + 16) +
                  ((uint32_t)rg_load_i16(residual)
                   << (RG_CONTROL_POINT_BITS - bits)));
  }
}

void rg_read_remap(const uint8_t* section, rg_remap_section* remap) {
  remap->width = rg_load_u16(section);
  remap->height = rg_load_u16(section + 2);
  remap->columns = rg_load_u16(section + 4);
  remap->rows = rg_load_u16(section + 6);
  remap->block_log2 = section[8];
  remap->residual_shift = section[9];
  remap->part_log2 = section[10];
  remap->bend_shift = section[11];
  remap->min_x_q12 = rg_load_i32(section + 12);
  remap->min_y_q12 = rg_load_i32(section + 16);
  remap->max_x_q12 = rg_load_i32(section + 20);
  remap->max_y_q12 = rg_load_i32(section + 24);
  remap->origin_x_q12 = rg_load_i32(section + 28);
  remap->origin_y_q12 = rg_load_i32(section + 32);
  remap->column_step_x_q12 = rg_load_i32(section + 36);
  remap->column_step_y_q12 = rg_load_i32(section + 40);
  remap->row_step_x_q12 = rg_load_i32(section + 44);
  remap->row_step_y_q12 = rg_load_i32(section + 48);
  remap->fx_q16 = rg_load_u32(section + 52);
  remap->fy_q16 = rg_load_u32(section + 56);
  remap->cx_q16 = rg_load_i32(section + 60);
  remap->cy_q16 = rg_load_i32(section + 64);
  remap->bound_upx = rg_load_u32(section + 68);
  remap->max_error_upx = rg_load_u32(section + 72);
  remap->vertices = section + rg_load_u32(section + 76);
  remap->bends = 0;
  remap->empty_blocks =
      remap->vertices +
      (remap->part_log2 != 0 ? RG_BENT_VERTEX_SIZE : RG_VERTEX_SIZE) *
          remap->columns * remap->rows;
}

void rg_blob_quality(const rg_blob* blob, rg_quality_section* quality) {
  const uint8_t* section = blob->bytes + blob->quality;
  quality->training_median_upx = rg_load_u32(section);
  quality->training_rms_upx = rg_load_u32(section + 4);
  quality->training_max_upx = rg_load_u32(section + 8);
  quality->training_count = rg_load_u32(section + 12);
  quality->held_out_median_upx = rg_load_u32(section + 16);
  quality->held_out_rms_upx = rg_load_u32(section + 20);
  quality->held_out_max_upx = rg_load_u32(section + 24);
  quality->held_out_count = rg_load_u32(section + 28);
  quality->packing_error_npx = rg_load_u32(section + 32);
  quality->packing_error_prad = rg_load_u32(section + 36);
}

void rg_blob_inverse(const rg_blob* blob, rg_inverse_section* inverse) {
  const uint8_t* section = blob->bytes + blob->inverse;
  inverse->a0_q27 = rg_load_i32(section);
  inverse->b0_q27 = rg_load_i32(section + 4);
  inverse->a1_q27 = rg_load_i32(section + 8);
  inverse->b1_q27 = rg_load_i32(section + 12);
  inverse->columns = rg_load_u16(section + 16);
  inverse->rows = rg_load_u16(section + 18);
  inverse->scale_a_q21 = rg_load_u32(section + 20);
  inverse->scale_b_q21 = rg_load_u32(section + 24);
  inverse->cos_limit_q30 = rg_load_i32(section + 36);
}

const uint8_t* rg_blob_line_points(const rg_blob* blob) {
  const uint8_t* const section = blob->bytes + blob->line_points;
  return section + rg_load_u32(section + 4);
}

void rg_blob_mask(const rg_blob* blob, rg_mask_section* mask) {
  const uint8_t* const section = blob->bytes + blob->mask;
  mask->columns = rg_load_u16(section);
  mask->rows = rg_load_u16(section + 2);
  mask->cell_log2 = section[4];
  mask->bits = section + rg_load_u32(section + 8);
}

void rg_blob_uncertainty(const rg_blob* blob,
                         rg_uncertainty_section* uncertainty) {
  const uint8_t* const section = blob->bytes + blob->uncertainty;
  uncertainty->columns = rg_load_u16(section);
  uncertainty->rows = rg_load_u16(section + 2);
  uncertainty->scale_x_q32 = rg_load_u32(section + 4);
  uncertainty->scale_y_q32 = rg_load_u32(section + 8);
  uncertainty->values = section + rg_load_u32(section + 12);
}
