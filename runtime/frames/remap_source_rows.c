#include "frames/remap_source_rows.h"

/* All that is kept meanwhile is in one place: that takes less stack. */
typedef struct row_search {
  rg_lattice_job whole;
  const rg_camera* camera;
  rg_format format;
  uint8_t next_lattice;
  uint16_t first_row, num_rows;      /* of the output */
  uint16_t first_source, end_source; /* [first, end) of the image */
} row_search;

/* In q12: a row's step is rounded by half, so its 32nd pixel by up to 16, and a
 * pixel between such ends may be rounded the other way. */
#define SLACK 33

/* Adds what a position needs: the image rows of its lattice's rows. */
static RG_NOINLINE void add_position(row_search* search, int32_t y_q12) {
  const uint32_t log2 = search->whole.lattice.log2[1];
  int32_t first = (y_q12 - SLACK) >> 12;
  int32_t end = ((y_q12 + SLACK) >> 12) + 2;
  if (first < 0) first = 0;
  if (end > search->whole.job.size[1]) end = search->whole.job.size[1];
  first *= 1 << log2;
  end *= 1 << log2;
  if (first < search->first_source) search->first_source = (uint16_t)first;
  if (end > search->end_source) search->end_source = (uint16_t)end;
}

/* Adds what a run's pixels need that have a source. Positions are bilinear in a
 * block: where all have one, those of the run's corners will do. */
static RG_NOINLINE void add_run(rg_remap_job* job, rg_care care) {
  row_search* const search = (row_search*)job;
  const rg_run* const run = &job->run;
  if (care == RG_CARE_NO_SOURCE) return;
  uint32_t r = run->first_row;
  for (uint32_t k = 0; k < 2; ++k, r += run->num_rows - 1u) {
    rg_block_row row;
    rg_find_block_row(&run->block, r, &row);
    const int32_t first_pixel = RG_KEEP_LINES ? run->first_pixel : 0;
    const int32_t y_q12 = row.start.q12[1] + row.step.q12[1] * first_pixel;
    add_position(search, y_q12);
    add_position(search, y_q12 + row.step.q12[1] * (run->num_pixels - 1));
  }
}

static void add_pixel(rg_remap_job* job, const rg_position* position,
                      uint32_t out_pixel) {
  (void)out_pixel;
  if (rg_has_source(job, position))
    add_position((row_search*)job, position->q12[1]);
}

void rg_start_lattice(rg_remap_job* job, const rg_camera* camera,
                      uint32_t first_row, uint32_t num_rows) {
  /* A lattice has no pixels if the table is too narrow for it. */
  if (rg_load_u16(job->walk.section) >> rg_lattice_of(job)->log2[0] == 0)
    num_rows = 0;
  rg_set_source(job, camera->width, camera->height);
  rg_start_rows(job, rg_lattice_of(job), first_row, num_rows);
}

/* 0 if there is none. */
static RG_NOINLINE int start_next_lattice(row_search* search) {
  rg_remap_job* const job = &search->whole.job;
  if (!rg_find_lattice(search->format, search->next_lattice++,
                       &search->whole.lattice))
    return 0;
  rg_start_lattice(job, search->camera, search->first_row, search->num_rows);
#if !RG_KEEP_LINES
  rg_set_ranges(&search->whole);
#endif
  return 1;
}

static RG_NOINLINE int32_t round_rows(const row_search* search) {
  const uint32_t pairs = rg_row_pairs(search->format);
  const uint32_t first = search->first_source & ~pairs;
  const uint32_t end = (search->end_source + pairs) & ~pairs;
  return end == 0 ? 0 : (int32_t)(first | (end - first) << 16);
}

rg_status rg_check_rows(const rg_camera* camera, rg_format format,
                        uint32_t first_row, uint32_t num_rows) {
  if (!camera->remap) return RG_ERR_NO_REMAP;
  if ((uint32_t)format >= RG_NUM_FORMATS) return RG_ERR_FORMAT;
  const uint32_t pairs = rg_row_pairs(format);
  const uint32_t height = rg_load_u16(camera->remap + 2);
  if (((first_row | num_rows) & pairs) != 0 || first_row + num_rows > height)
    return RG_ERR_ROWS;
  return ((camera->height | height) & pairs) != 0 ? RG_ERR_FRAME_SIZE : RG_OK;
}

static RG_NOINLINE rg_status check_search(const row_search* search) {
  return rg_check_rows(search->camera, search->format, search->first_row,
                       search->num_rows);
}

int32_t rg_find_source_rows(const rg_camera* camera, rg_format format,
                            uint32_t first_row, uint32_t num_rows) {
  row_search search;
  search.camera = camera;
  search.format = format;
  search.first_row = (uint16_t)first_row;
  search.num_rows = (uint16_t)num_rows;
  search.first_source = UINT16_MAX;
  search.end_source = search.next_lattice = 0;
  search.whole.job.walk.section = camera->remap;
#if RG_KEEP_LINES
  search.whole.job.lattice = &search.whole.lattice;
  search.whole.job.walk.is_clamped = 0;
#endif
  search.whole.job.ring_rows = 0;
  search.whole.job.run.out = (uint8_t*)&search; /* no byte of it is written */
  search.whole.job.run.out_stride = 0;
  const rg_status status = check_search(&search);
  if (status != RG_OK) return status;
  while (start_next_lattice(&search)) {
    while (rg_next_part(&search.whole.job)) {
      rg_bring_to_lattice(&search.whole.job);
      rg_do_part(&search.whole.job, add_run, add_pixel);
    }
  }
  return round_rows(&search);
}

rg_status rg_remap_source_rows(const rg_camera* camera, rg_format format,
                               uint16_t first_row, uint16_t num_rows,
                               uint16_t* first_source, uint16_t* num_source) {
  const int32_t rows = rg_find_source_rows(camera, format, first_row, num_rows);
  if (rows < 0) return (rg_status)rows;
  *first_source = (uint16_t)rows;
  *num_source = (uint16_t)(rows >> 16);
  return RG_OK;
}
