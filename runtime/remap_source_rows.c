#include "remap_source_rows.h"

#include "remap_blocks.h"

typedef struct row_needs {
  uint16_t first_row, num_rows;      /* of the output */
  uint16_t first_source, end_source; /* [first, end) of the image; 0 twice for
                                        none */
} row_needs;

/* In q12: a row's step is rounded by half, so its 32nd pixel by up to 16, and a
 * pixel between such ends may be rounded the other way. */
#define SLACK 33

/* Adds what a position needs: the image rows of its lattice's rows. */
static void add_position(const rg_remap_job* job, int32_t y_q12,
                         row_needs* needs) {
  const uint32_t log2 = job->lattice->log2[1];
  int32_t first = (y_q12 - SLACK) >> 12;
  int32_t end = ((y_q12 + SLACK) >> 12) + 2;
  if (first < 0) first = 0;
  if (end > job->size[1]) end = job->size[1];
  first *= 1 << log2;
  end *= 1 << log2;
  if (first < needs->first_source) needs->first_source = (uint16_t)first;
  if (end > needs->end_source) needs->end_source = (uint16_t)end;
}

/* Adds what a run's pixels need that have a source. Positions are bilinear in a
 * block: where all have one, those of its corners will do. */
static RG_NOINLINE void add_run(const rg_remap_job* job, rg_care care,
                                row_needs* needs) {
  const rg_run* const run = &job->run;
  if (care == RG_CARE_PIXEL) {
    const rg_position p = job->position;
    if (rg_is_in(rg_job_range(job, job->lattice, 0), p.q12[0]) &&
        rg_is_in(rg_job_range(job, job->lattice, 1), p.q12[1]))
      add_position(job, p.q12[1], needs);
    return;
  }
  for (uint32_t k = 0; k < 2; ++k) {
    const uint32_t r = run->first_row + (k == 0 ? 0 : run->num_rows - 1u);
    rg_block_row row;
    rg_find_block_row(&run->block, r, &row);
    int32_t y_q12 = row.start.q12[1] + row.step.q12[1] * run->first_pixel;
    add_position(job, y_q12, needs);
    y_q12 += row.step.q12[1] * (run->num_pixels - 1);
    add_position(job, y_q12, needs);
  }
}

static RG_INLINE void add_part(rg_remap_job* job, row_needs* needs) {
  rg_bring_to_lattice(job);
  do {
    const rg_care care = rg_next_run(job);
    if (care != RG_CARE_NO_SOURCE) add_run(job, care, needs);
  } while (job->rows_left != 0);
}

/* Not yet rounded. */
static RG_NOINLINE void find_source_rows(const rg_camera* camera,
                                         rg_format format, row_needs* needs) {
  rg_remap_job job;
  job.walk.section = camera->remap;
  job.walk.is_clamped = 0;
  job.run.out = (uint8_t*)needs; /* no byte of it is written */
  job.run.out_stride = 0;
  job.ring_rows = 0;
  job.run.first_source_row = 0;
  needs->first_source = UINT16_MAX;
  needs->end_source = 0;
  for (uint32_t k = rg_format_lattices(format, &job.lattice); k != 0;
       --k, ++job.lattice) {
    job.size[0] = (uint16_t)(camera->width >> job.lattice->log2[0]);
    job.size[1] = (uint16_t)(camera->height >> job.lattice->log2[1]);
    job.num_rows = job.size[1];
    rg_start_rows(&job, needs->first_row, needs->num_rows);
    while (rg_next_part(&job)) add_part(&job, needs);
  }
}

/* 1 where the rows of a format come in pairs; its last lattice tells. */
static uint32_t row_pairs(rg_format format) {
  const rg_lattice* lattices = 0;
  const uint32_t num_lattices = rg_format_lattices(format, &lattices);
  return (1u << lattices[num_lattices - 1].log2[1]) - 1;
}

static RG_NOINLINE void round_rows(rg_format format, row_needs* needs) {
  const uint32_t pairs = row_pairs(format);
  if (needs->first_source >= needs->end_source)
    needs->first_source = needs->end_source = 0;
  needs->first_source = (uint16_t)(needs->first_source & ~pairs);
  needs->end_source = (uint16_t)((needs->end_source + pairs) & ~pairs);
}

static RG_NOINLINE rg_status check_rows(const rg_camera* camera,
                                        rg_format format,
                                        const row_needs* needs) {
  const uint8_t* const section = camera->remap;
  if (!section) return RG_ERR_NO_REMAP;
  if ((uint32_t)format >= RG_NUM_FORMATS) return RG_ERR_FORMAT;
  const uint32_t first = needs->first_row, num_rows = needs->num_rows;
  return first + num_rows > rg_load_u16(section + 2) ||
                 ((first | num_rows) & row_pairs(format)) != 0
             ? RG_ERR_ROWS
             : RG_OK;
}

rg_status rg_remap_source_rows(const rg_camera* camera, rg_format format,
                               uint16_t first_row, uint16_t num_rows,
                               uint16_t* first_source, uint16_t* num_source) {
  row_needs needs = {first_row, num_rows, 0, 0};
  const rg_status status = check_rows(camera, format, &needs);
  if (status != RG_OK) return status;
  find_source_rows(camera, format, &needs);
  round_rows(format, &needs);
  *first_source = needs.first_source;
  *num_source = (uint16_t)(needs.end_source - needs.first_source);
  return RG_OK;
}

rg_status rg_check_ring(const rg_camera* camera, const rg_image* image,
                        const rg_target* target) {
  row_needs needs;
  if (image->num_rows > image->ring_rows) return RG_ERR_ROWS_MISSING;
  needs.first_row = target->first_row;
  needs.num_rows = target->num_rows;
  find_source_rows(camera, image->format, &needs);
  round_rows(image->format, &needs);
  return needs.first_source < needs.end_source &&
                 (needs.first_source < image->first_row ||
                  needs.end_source > image->first_row + image->num_rows)
             ? RG_ERR_ROWS_MISSING
             : RG_OK;
}
