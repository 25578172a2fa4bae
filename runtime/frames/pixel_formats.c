#include "frames/pixel_formats.h"

#include <stddef.h>

/* A lattice in a word: three bits a field, behind the kind, from the low bits
 * up in the reversed order of rg_lattice. A field that is not named is 0, and
 * one that does not fit fails to compile. */
#define FIELD(digit, value)           \
  ((uint32_t)(value) << 3 * (digit) | \
   (uint32_t)(0 * sizeof(char[(value) < 8 ? 1 : -1])))
#define PLANE(plane) FIELD(9, plane)
#define SAMPLES(first, step) (FIELD(8, first) | FIELD(7, step))
#define CHANNELS(count) FIELD(6, count)
#define LOG2(x, y) (FIELD(5, x) | FIELD(4, y))
#define HALF(x, y) (FIELD(3, x) | FIELD(2, y))
#define ROWS(first, step) (FIELD(1, first) | FIELD(0, step))
#define NUM_FIELDS 10u

#define EVERY_PIXEL ROWS(0, 1)
#define HALF_WIDTH (LOG2(1, 0) | HALF(1, 0) | ROWS(0, 1))
#define HALF_SIZE (LOG2(1, 1) | HALF(1, 1) | ROWS(0, 1))
#define COLOUR(x, y)                                                   \
  (SAMPLES(x, 2) | CHANNELS(1) | LOG2(1, 1) | HALF(2 * (x), 2 * (y)) | \
   ROWS(y, 2))

/* The first lattice of each kind of format. */
enum first_lattice {
  THREE_SAMPLES,
  FOUR_SAMPLES,
  YUYV,
  UYVY = YUYV + 3,
  NV12 = UYVY + 3,
  YUV420 = NV12 + 2,
  ONE_SAMPLE = YUV420, /* Y */
  BAYER = YUV420 + 3,
  RGB565 = BAYER + 4,
  NUM_LATTICES = RGB565 + 3
};

static const uint32_t kLattices[] = {
    SAMPLES(0, 3) | CHANNELS(3) | EVERY_PIXEL, /* THREE_SAMPLES */
    SAMPLES(0, 4) | CHANNELS(4) | EVERY_PIXEL, /* FOUR_SAMPLES */
    SAMPLES(0, 2) | CHANNELS(1) | EVERY_PIXEL, /* YUYV */
    SAMPLES(1, 4) | CHANNELS(1) | HALF_WIDTH,
    SAMPLES(3, 4) | CHANNELS(1) | HALF_WIDTH,
    SAMPLES(1, 2) | CHANNELS(1) | EVERY_PIXEL, /* UYVY */
    SAMPLES(0, 4) | CHANNELS(1) | HALF_WIDTH,
    SAMPLES(2, 4) | CHANNELS(1) | HALF_WIDTH,
    SAMPLES(0, 1) | CHANNELS(1) | EVERY_PIXEL, /* NV12 */
    PLANE(1) | SAMPLES(0, 2) | CHANNELS(2) | HALF_SIZE,
    SAMPLES(0, 1) | CHANNELS(1) | EVERY_PIXEL, /* YUV420 */
    PLANE(1) | SAMPLES(0, 1) | CHANNELS(1) | HALF_SIZE,
    PLANE(2) | SAMPLES(0, 1) | CHANNELS(1) | HALF_SIZE,
    COLOUR(0, 0), /* BAYER */
    COLOUR(1, 0),
    COLOUR(0, 1),
    COLOUR(1, 1),
    SAMPLES(0, 4) | CHANNELS(1) | EVERY_PIXEL, /* RGB565 */
    SAMPLES(1, 4) | CHANNELS(1) | EVERY_PIXEL,
    SAMPLES(2, 4) | CHANNELS(1) | EVERY_PIXEL};

/* A format in 16 bits. */
#define FORMAT_ROW_PAIRS 1u /* its rows come in pairs */
#define FORMAT(kind, first_lattice, num_lattices, row_pairs)       \
  ((kind) << 11 | (first_lattice) << 4 | ((num_lattices)-1) << 1 | \
   ((row_pairs) ? FORMAT_ROW_PAIRS : 0u))
#define KIND_OF(format) ((uint32_t)(format) >> 11)
#define FIRST_OF(format) ((uint32_t)(format) >> 4 & 127)
#define LAST_OF(format) ((uint32_t)(format) >> 1 & 7)

static const uint16_t kFormats[] = {FORMAT(RG_SAMPLE_8, ONE_SAMPLE, 1, 0),
                                    FORMAT(RG_SAMPLE_16, ONE_SAMPLE, 1, 0),
                                    FORMAT(RG_SAMPLE_10P, ONE_SAMPLE, 1, 0),
                                    FORMAT(RG_SAMPLE_12P, ONE_SAMPLE, 1, 0),
                                    FORMAT(RG_SAMPLE_8, THREE_SAMPLES, 1, 0),
                                    FORMAT(RG_SAMPLE_8, FOUR_SAMPLES, 1, 0),
                                    FORMAT(RG_SAMPLE_8, YUYV, 3, 0),
                                    FORMAT(RG_SAMPLE_8, UYVY, 3, 0),
                                    FORMAT(RG_SAMPLE_8, NV12, 2, 1),
                                    FORMAT(RG_SAMPLE_8, YUV420, 3, 1),
                                    FORMAT(RG_SAMPLE_8, BAYER, 4, 1),
                                    FORMAT(RG_SAMPLE_16, BAYER, 4, 1),
                                    FORMAT(RG_SAMPLE_10P, BAYER, 4, 1),
                                    FORMAT(RG_SAMPLE_12P, BAYER, 4, 1),
                                    FORMAT(RG_SAMPLE_565, RGB565, 3, 0)};

/* Fails to compile where a table lacks an entry, or an index does not fit. */
#define ASSERT_LATTICES(name, condition) \
  typedef char(name)[(condition) ? 1 : -1]
ASSERT_LATTICES(every_format_has_an_entry,
                sizeof(kFormats) / sizeof(kFormats[0]) == RG_NUM_FORMATS);
ASSERT_LATTICES(every_lattice_has_its_place,
                sizeof(kLattices) / sizeof(kLattices[0]) == NUM_LATTICES);
ASSERT_LATTICES(lattices_fit_their_index, NUM_LATTICES <= 128);
ASSERT_LATTICES(kinds_fit_their_field, RG_SAMPLE_565 < 32);
ASSERT_LATTICES(fields_are_all_between_kind_and_index,
                offsetof(rg_lattice, kind) == 0 &&
                    offsetof(rg_lattice, plane) == 1 &&
                    offsetof(rg_lattice, index) == NUM_FIELDS + 1);

int rg_find_lattice(rg_format format, uint32_t index, rg_lattice* lattice) {
  if ((uint32_t)format >= RG_NUM_FORMATS) return 0;
  const uint32_t found = kFormats[format];
  if (index > LAST_OF(found)) return 0;
  uint32_t fields = kLattices[FIRST_OF(found) + index];
  uint8_t* const digits = (uint8_t*)lattice;
  for (uint32_t k = NUM_FIELDS; k != 0; --k, fields >>= 3)
    digits[k] = fields & 7;
  lattice->kind = (uint8_t)KIND_OF(found);
  lattice->index = (uint8_t)index;
  return 1;
}

uint32_t rg_row_pairs(rg_format format) {
  return kFormats[format] & FORMAT_ROW_PAIRS;
}

/* Bits of a sample of each kind; of RGB565, a fourth of a word. */
static const uint8_t kSampleBits[] = {8, 12, 10, 16, 4};
ASSERT_LATTICES(every_kind_has_its_bits,
                sizeof(kSampleBits) == RG_SAMPLE_565 + 1);

uint32_t rg_plane_row_bytes(const rg_lattice* lattice, uint32_t width) {
  const uint32_t num_pixels = width >> lattice->log2[0];
  const uint32_t num_bits =
      num_pixels * lattice->sample_step * kSampleBits[lattice->kind];
  const int is_whole =
      num_pixels << lattice->log2[0] == width && num_bits % 8 == 0;
  return is_whole ? num_bits / 8 : 0;
}
