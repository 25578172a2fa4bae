/* Which rows of the source a band of the output needs. */
#include "raygrid.h"
#include "remap_blocks.h"

/* In q12: a row's step is rounded by half, so its 32nd pixel by up to 16, and a
 * pixel between such ends may be rounded the other way. */
#define SLACK 33

/* Rows of the image, [first, end); none while first >= end. */
typedef struct image_rows {
  int32_t first, end;
} image_rows;

/* Adds what a position needs: the image rows of its lattice's rows. */
static void add_position(const rg_remap_job* job, int32_t y_q12) {
  image_rows* const rows = (image_rows*)job->context;
  const uint32_t log2 = job->lattice->log2[1];
  const int32_t scale = 1 << log2;
  int32_t first = (y_q12 - SLACK) >> 12;
  int32_t end = ((y_q12 + SLACK) >> 12) + 2;
  if (first < 0) first = 0;
  if (end > job->size[1]) end = job->size[1];
  if (first * scale < rows->first) rows->first = first * scale;
  if (end * scale > rows->end) rows->end = end * scale;
}

/* Adds what a run's pixels need that have a source. Positions are bilinear in a
 * block: where all have one, those of its corners will do. */
static void add_run(rg_remap_job* job, rg_care care) {
  if (care == RG_CARE_NO_SOURCE) return;
  const rg_run* const run = &job->run;
  const uint32_t last_row = run->num_rows - 1u;
  const uint32_t last_pixel = run->first_pixel + run->num_pixels - 1u;
  for (uint32_t corner = 0; corner < 4; ++corner) {
    rg_block_row row;
    rg_find_block_row(&run->block, run->first_row + (corner < 2 ? 0 : last_row),
                      &row);
    const rg_position p = rg_row_position(
        &row, (corner & 1) == 0 ? run->first_pixel : last_pixel);
    if (care != RG_CARE_PIXEL ||
        (rg_is_in(rg_job_range(job, job->lattice, 0), p.q12[0]) &&
         rg_is_in(rg_job_range(job, job->lattice, 1), p.q12[1])))
      add_position(job, p.q12[1]);
  }
}

static void prepare_block(rg_remap_job* job) {
  rg_lattice_block(job->lattice, &job->run.block);
}

rg_status rg_remap_source_rows(const rg_camera* camera, rg_format format,
                               uint16_t first_row, uint16_t num_rows,
                               uint16_t* first_source, uint16_t* num_source) {
  const uint8_t* const section = camera->remap;
  if (!section) return RG_ERR_NO_REMAP;
  const rg_lattice* lattices = 0;
  const uint32_t num_lattices = rg_format_lattices(format, &lattices);
  if (num_lattices == 0) return RG_ERR_FORMAT;
  const uint32_t end_row = (uint32_t)first_row + num_rows;
  const uint32_t pairs = (1u << lattices[num_lattices - 1].log2[1]) - 1;
  if (end_row > rg_load_u16(section + 2) || ((first_row | num_rows) & pairs))
    return RG_ERR_ROWS;
  image_rows rows = {INT32_MAX, 0};
  rg_remap_job job;
  job.remap_run = add_run;
  job.prepare_block = prepare_block;
  job.context = &rows;
  job.ring_rows = 0;
  job.walk.section = section;
  job.walk.is_clamped = 0;
  job.run.out = 0;
  job.run.out_stride = 0;
  job.run.first_source_row = 0;
  for (uint32_t k = 0; k < num_lattices; ++k) {
    const uint32_t log2 = lattices[k].log2[1];
    job.lattice = &lattices[k];
    job.size[0] = (uint16_t)(camera->width >> lattices[k].log2[0]);
    job.size[1] = job.num_rows = (uint16_t)(camera->height >> log2);
    rg_remap_rows(&job, (uint32_t)first_row >> log2, end_row >> log2);
  }
  if (rows.first >= rows.end) rows.first = rows.end = 0;
  rows.first &= ~(int32_t)pairs;
  rows.end = (rows.end + (int32_t)pairs) & ~(int32_t)pairs;
  *first_source = (uint16_t)rows.first;
  *num_source = (uint16_t)(rows.end - rows.first);
  return RG_OK;
}
