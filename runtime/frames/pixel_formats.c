#include "frames/pixel_formats.h"

#include <stddef.h>

#include "frames/pixel_format_list.h"

/* A component packed into a word: three bits per field, after the kind, from
 * the low bits up in the reversed order of rg_component. A field that does not
 * fit is a compile-time error. */
#define FIELD(digit, value)           \
  ((uint32_t)(value) << 3 * (digit) | \
   (uint32_t)(0 * sizeof(char[(value) < 8 ? 1 : -1])))
#define RG_COMPONENT(plane, first, step, channels, lx, ly, hx, hy, row,     \
                     row_step)                                              \
  FIELD(9, plane) | FIELD(8, first) | FIELD(7, step) | FIELD(6, channels) | \
      FIELD(5, lx) | FIELD(4, ly) | FIELD(3, hx) | FIELD(2, hy) |           \
      FIELD(1, row) | FIELD(0, row_step),
#define NUM_FIELDS 10u

static const uint32_t kComponents[] = {RG_COMPONENTS};
#define NUM_COMPONENTS (sizeof(kComponents) / sizeof(kComponents[0]))

/* A format in 16 bits. */
#define FORMAT_ROW_PAIRS 1u /* its rows come in pairs */
#define RG_PIXEL_FORMAT(name, kind, first_lattice, num_components, row_pairs, \
                        ...)                                                  \
  ((kind) << 11 | (first_lattice) << 4 | ((num_components)-1) << 1 |          \
   ((row_pairs) ? FORMAT_ROW_PAIRS : 0u)),
#define KIND_OF(format) ((uint32_t)(format) >> 11)
#define FIRST_OF(format) ((uint32_t)(format) >> 4 & 127)
#define LAST_OF(format) ((uint32_t)(format) >> 1 & 7)

static const uint16_t kFormats[] = {RG_PIXEL_FORMATS};

/* Compile-time check that tables are complete and indices fit. */
#define ASSERT_COMPONENTS(name, condition) \
  typedef char(name)[(condition) ? 1 : -1]
ASSERT_COMPONENTS(every_format_has_an_entry,
                  sizeof(kFormats) / sizeof(kFormats[0]) == RG_NUM_FORMATS);
ASSERT_COMPONENTS(components_fit_their_index, NUM_COMPONENTS <= 128);
ASSERT_COMPONENTS(kinds_fit_their_field, RG_SAMPLE_565 < 32);
ASSERT_COMPONENTS(fields_are_all_between_kind_and_index,
                  offsetof(rg_component, kind) == 0 &&
                      offsetof(rg_component, plane) == 1 &&
                      offsetof(rg_component, index) == NUM_FIELDS + 1);

int rg_get_component(rg_format format, uint32_t index,
                     rg_component* component) {
  if ((uint32_t)format >= RG_NUM_FORMATS) return 0;
  const uint32_t found = kFormats[format];
  if (index > LAST_OF(found)) return 0;
  uint32_t fields = kComponents[FIRST_OF(found) + index];
  uint8_t* const digits = (uint8_t*)component;
  for (uint32_t k = NUM_FIELDS; k != 0; --k, fields >>= 3)
    digits[k] = fields & 7;
  component->kind = (uint8_t)KIND_OF(found);
  component->index = (uint8_t)index;
  return 1;
}

uint32_t rg_row_pairs(rg_format format) {
  return kFormats[format] & FORMAT_ROW_PAIRS;
}

/* The bits of a sample of each kind; for RGB565, a quarter of a word. */
#define RG_SAMPLE_KIND(kind, bits) [kind] = (bits),
static const uint8_t kSampleBits[RG_SAMPLE_565 + 1] = {RG_SAMPLE_KINDS};

uint32_t rg_plane_row_bytes(const rg_component* component, uint32_t width) {
  const uint32_t num_pixels = width >> component->log2[0];
  const uint32_t num_bits =
      num_pixels * component->sample_step * kSampleBits[component->kind];
  const int is_whole =
      num_pixels << component->log2[0] == width && num_bits % 8 == 0;
  return is_whole ? num_bits / 8 : 0;
}
