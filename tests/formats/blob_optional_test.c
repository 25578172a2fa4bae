/* The optional sections since version 1.1: their fields, and each fault of them
 * refused with its own status. */
#include <string.h>

#include "blob_edit.h"
#include "bytes.h"
#include "golden_blobs.h"
#include "rg_blob.h"
#include "unit_test.h"

static uint8_t edited[sizeof(kStackBlob)] __attribute__((aligned(16)));

/* Stand for the type of a remap: of one with a view, and of one of a mode. */
#define VIEW 100u
#define MODE_TABLE 101u

/* Bytes from a sample of the stack, and its value, to the next one. */
#define KNOT_SIZE 1448u

/* A value of a field of the section of that type: in kNarrowBlob for the grid,
 * in kBentBlob for a remap, in kViewsBlob for one with a view, in kModesBlob
 * for one of a mode, otherwise in kWideBlob or the first that has it. */
typedef struct field_value {
  const char* what;
  uint32_t type, offset, num_bytes, value;
  rg_status status;
} field_value;

static const field_value kValues[] = {
    {"left of the chart", 10, 0, 4, (uint32_t)-0x20000001, RG_ERR_AREA},
    {"above the chart", 10, 4, 4, 0x80000000, RG_ERR_AREA},
    {"right of the chart", 10, 8, 4, 0x20000001, RG_ERR_AREA},
    {"below the chart", 10, 12, 4, 0x7fffffff, RG_ERR_AREA},
    {"no width", 10, 8, 4, 0xe0000000, RG_ERR_AREA},
    {"three columns", 10, 16, 2, 3, RG_ERR_GRID_SIZE},
    {"1028 rows", 10, 18, 2, 1028, RG_ERR_GRID_SIZE},
    {"columns against the scale", 10, 16, 2, 13, RG_ERR_GRID_SCALE},
    {"horizontal scale 0", 10, 20, 4, 0, RG_ERR_GRID_SCALE},
    {"vertical scale too high", 10, 24, 4, 0xffffffff, RG_ERR_GRID_SCALE},
    {"unknown chart", 10, 28, 2, 2, RG_ERR_GRID_CHART},
    {"pixels in q1", 10, 30, 2, 13, RG_ERR_GRID_CHART},
    {"pixels of 32 bits", 10, 30, 2, 29, RG_ERR_GRID_CHART},
    {"pixels in the fields", 10, 32, 4, 36, RG_ERR_DATA_OFFSET},
    {"pixels at an odd place", 10, 32, 4, 42, RG_ERR_DATA_OFFSET},
    {"pixels end too late", 10, 32, 4, 44, RG_ERR_SECTION_SIZE},
    {"pixels so far that the end wraps", 10, 32, 4, 0xfffffffc,
     RG_ERR_SECTION_SIZE},
    {"any cosine", 10, 36, 4, 0x80000000, RG_OK},
    {"pixels too far right", 10, 40, 4, 0x7f000000, RG_ERR_CONTROL_POINT},
    {"rows lead too far down", 10, 60, 4, 0x80000000, RG_ERR_CONTROL_POINT},
    {"any residual", 10, 64, 4, 0x80008000, RG_OK},

    {"residuals in q13", 2, 30, 2, 13, RG_ERR_GRID_CHART},
    {"residuals in q30", 2, 30, 2, 30, RG_ERR_GRID_CHART},
    {"wide control points in a narrow grid", 2, 30, 2, 29, RG_ERR_SECTION_SIZE},
    {"residuals end too late", 2, 32, 4, 44, RG_ERR_SECTION_SIZE},
    {"origin too far right", 2, 40, 4, 0x7f000000, RG_ERR_CONTROL_POINT},
    {"origin too far up", 2, 44, 4, 0x81000000, RG_ERR_CONTROL_POINT},
    {"columns lead too far", 2, 48, 4, 0x10000000, RG_ERR_CONTROL_POINT},
    {"rows lead too far", 2, 60, 4, 0x80000000, RG_ERR_CONTROL_POINT},
    {"largest residual", 2, 64, 2, 0x7fff, RG_OK},

    {"bent blocks of 8", 3, 8, 1, 3, RG_ERR_REMAP_BLOCK},
    {"bent blocks of 128", 3, 8, 1, 7, RG_ERR_REMAP_BLOCK},
    {"bent blocks of 16 against the vertices", 3, 8, 1, 4, RG_ERR_REMAP_BLOCK},
    {"parts of 4", 3, 10, 1, 2, RG_ERR_REMAP_BLOCK},
    {"parts of 16", 3, 10, 1, 4, RG_OK},
    {"parts as large as blocks", 3, 10, 1, 5, RG_ERR_REMAP_BLOCK},
    {"parts larger than blocks", 3, 10, 1, 255, RG_ERR_REMAP_BLOCK},
    {"shift of no bends", 3, 10, 1, 0, RG_ERR_RESERVED},
    {"bends of a table without", 3, 10, 2, 0, RG_ERR_SECTION_SIZE},
    {"bend shift 10", 3, 11, 1, 10, RG_OK},
    {"bend shift 11", 3, 11, 1, 11, RG_ERR_REMAP_SHIFT},
    {"any bends", 3, 84, 4, 0x807f807f, RG_OK},

    {"view that is skipped", VIEW, 11, 1, 0, RG_OK},
    {"bend shift without bends", VIEW, 11, 1, 0x81, RG_ERR_RESERVED},
    {"bit 4 of the bend shift", VIEW, 11, 1, 0x90, RG_ERR_REMAP_SHIFT},
    {"bit 6 of the bend shift", VIEW, 11, 1, 0xc0, RG_ERR_REMAP_SHIFT},
    {"vertices in the fields of the view", VIEW, 76, 4, 120,
     RG_ERR_DATA_OFFSET},
    {"last projection", VIEW, 80, 1, 4, RG_OK},
    {"projection beyond the last", VIEW, 80, 1, 5, RG_ERR_REMAP_CAMERA},
    {"mode of a blob without modes", VIEW, 81, 1, 1, RG_ERR_MODE},
    {"unknown direction", VIEW, 82, 1, 2, RG_ERR_RESERVED},
    {"real frames of the view's size", VIEW, 82, 1, 1, RG_ERR_REMAP_SIZE},
    {"reserved field of the view", VIEW, 83, 1, 1, RG_ERR_RESERVED},
    {"source wider than the camera's image", VIEW, 120, 2, 321,
     RG_ERR_REMAP_SIZE},
    {"source narrower than its rectangle", VIEW, 120, 2, 319,
     RG_ERR_REMAP_SOURCE},
    {"source of one row", VIEW, 122, 2, 1, RG_ERR_REMAP_SIZE},
    {"source of 8193 rows", VIEW, 122, 2, 8193, RG_ERR_REMAP_SIZE},
    {"rotation with a number above 1", VIEW, 84, 4, 0x40000001,
     RG_ERR_REMAP_CAMERA},
    {"rotation with a number below -1", VIEW, 116, 4, 0xbfffffff,
     RG_ERR_REMAP_CAMERA},
    {"rotation whose first row is short", VIEW, 84, 4, 0, RG_ERR_REMAP_CAMERA},
    {"rotation whose last row leans", VIEW, 112, 4, 0, RG_ERR_REMAP_CAMERA},

    {"mode behind the last", MODE_TABLE, 81, 1, 4, RG_ERR_MODE},
    {"last number of a mode", MODE_TABLE, 81, 1, 255, RG_ERR_MODE},
    {"mode of another size", MODE_TABLE, 81, 1, 2, RG_ERR_REMAP_SIZE},
    {"no mode, but its size", MODE_TABLE, 81, 1, 0, RG_ERR_REMAP_SIZE},

    {"mode of no width", 8, 0, 2, 0, RG_ERR_MODE},
    {"mode of 16385 rows", 8, 2, 2, 16385, RG_ERR_MODE},
    {"mode wider than its table's source", 8, 0, 2, 121, RG_ERR_REMAP_SIZE},
    {"mode 16384 px to the right", 8, 4, 4, 0x40000000, RG_ERR_MODE},
    {"mode 16384 px above", 8, 8, 4, 0xc0000000, RG_ERR_MODE},
    {"mode just below the limit", 8, 4, 4, 0x3fffffff, RG_OK},
    {"smallest scale", 8, 12, 4, 1024, RG_OK},
    {"scale below 1/64", 8, 12, 4, 1023, RG_ERR_MODE},
    {"scale above 64", 8, 16, 4, (64u << 16) + 1, RG_ERR_MODE},
    {"flip of 2", 8, 20, 1, 2, RG_ERR_MODE},
    {"flipped mode", 8, 21, 1, 1, RG_OK},
    {"first reserved field of a mode", 8, 22, 2, 1, RG_ERR_RESERVED},
    {"second reserved field of a mode", 8, 24, 4, 1, RG_ERR_RESERVED},
    {"last reserved field of a mode", 8, 28, 4, 0x80000000, RG_ERR_RESERVED},
    {"name of a mode without an end", 8, 63, 1, 1, RG_ERR_TEXT},
    {"last mode of no height", 8, 130, 2, 0, RG_ERR_MODE},

    {"points in q29", 5, 0, 2, 29, RG_ERR_LINE_POINT},
    {"reserved field of the points", 5, 2, 2, 1, RG_ERR_RESERVED},
    {"points in the fields", 5, 4, 4, 4, RG_ERR_DATA_OFFSET},
    {"points end too late", 5, 4, 4, 12, RG_ERR_SECTION_SIZE},
    {"first point too far", 5, 8, 4, 0x7f000001, RG_ERR_LINE_POINT},
    {"last point too near", 5, 196, 4, 0x80ffffff, RG_ERR_LINE_POINT},
    {"point at the limit", 5, 8, 4, 0x81000000, RG_OK},

    {"a column of cells too few", 6, 0, 2, 9, RG_ERR_MASK},
    {"a row of cells too many", 6, 2, 2, 9, RG_ERR_MASK},
    {"cells of 2", 6, 4, 1, 1, RG_ERR_MASK},
    {"cells of 512", 6, 4, 1, 9, RG_ERR_MASK},
    {"cells of 64 against the counts", 6, 4, 1, 6, RG_ERR_MASK},
    {"first reserved field of the mask", 6, 5, 1, 1, RG_ERR_RESERVED},
    {"second reserved field of the mask", 6, 6, 2, 256, RG_ERR_RESERVED},
    {"bits in the fields", 6, 8, 4, 8, RG_ERR_DATA_OFFSET},
    {"bits end too late", 6, 8, 4, 16, RG_ERR_SECTION_SIZE},
    {"no valid cell", 6, 12, 4, 0, RG_OK},

    {"one column of uncertainties", 7, 0, 2, 1, RG_ERR_UNCERTAINTY},
    {"66 rows of uncertainties", 7, 2, 2, 66, RG_ERR_UNCERTAINTY},
    {"columns against the scale", 7, 0, 2, 6, RG_ERR_UNCERTAINTY},
    {"rows against the scale", 7, 8, 4, 1, RG_ERR_UNCERTAINTY},
    {"values in the fields", 7, 12, 4, 12, RG_ERR_DATA_OFFSET},
    {"values end too late", 7, 12, 4, 20, RG_ERR_SECTION_SIZE},
    {"largest value", 7, 16, 2, 65534, RG_OK},

    {"farthest lens position", 11, 0, 4, 1024u << 16, RG_OK},
    {"lens position beyond", 11, 0, 4, (1024u << 16) + 1, RG_ERR_CAPTURE},
    {"lens position below", 11, 0, 4, 0xfbffffff, RG_ERR_CAPTURE},
    {"smallest number as lens position", 11, 0, 4, 0x80000000, RG_ERR_CAPTURE},
    {"no tolerance of the lens", 11, 4, 4, 0, RG_OK},
    {"tolerance beyond", 11, 4, 4, (1024u << 16) + 1, RG_ERR_CAPTURE},
    {"crop far to the left", 11, 8, 4, (uint32_t)-65536, RG_OK},
    {"crop farther to the left", 11, 8, 4, (uint32_t)-65537, RG_ERR_CAPTURE},
    {"crop far below", 11, 12, 4, 65537, RG_ERR_CAPTURE},
    {"smallest number as the crop's edge", 11, 8, 4, 0x80000000,
     RG_ERR_CAPTURE},
    {"crop of no width", 11, 16, 4, 0, RG_ERR_CAPTURE},
    {"crop of no height", 11, 20, 4, 0, RG_ERR_CAPTURE},
    {"crop of a pixel", 11, 16, 4, 1, RG_OK},
    {"widest crop of the image's 64 pixels", 11, 16, 4, 4096, RG_OK},
    {"wider crop", 11, 16, 4, 4097, RG_ERR_CAPTURE},
    {"crop wider than sensors", 11, 16, 4, 0xffffffff, RG_ERR_CAPTURE},
    {"crop whose width wraps", 11, 20, 4, 0x04000001, RG_ERR_CAPTURE},
    {"no zoom", 11, 24, 4, 65536, RG_OK},
    {"zoom below 1", 11, 24, 4, 65535, RG_ERR_CAPTURE},
    {"zoom above 1024", 11, 24, 4, (1024u << 16) + 1, RG_ERR_CAPTURE},
    {"nothing known", 11, 28, 1, 0, RG_ERR_CAPTURE},
    {"lens position that is not known", 11, 28, 1, 126, RG_ERR_CAPTURE},
    {"crop that is not known", 11, 28, 1, 125, RG_ERR_CAPTURE},
    {"zoom that is not known", 11, 28, 1, 123, RG_ERR_CAPTURE},
    {"orientation that is not known", 11, 28, 1, 119, RG_ERR_CAPTURE},
    {"temperature that is not known", 11, 28, 1, 111, RG_ERR_CAPTURE},
    {"exposure that is not known", 11, 28, 1, 95, RG_ERR_CAPTURE},
    {"gain that is not known", 11, 28, 1, 63, RG_ERR_CAPTURE},
    {"what later versions may know", 11, 28, 1, 255, RG_ERR_CAPTURE},
    {"orientation 0", 11, 29, 1, 0, RG_ERR_CAPTURE},
    {"orientation 8", 11, 29, 1, 8, RG_OK},
    {"orientation 9", 11, 29, 1, 9, RG_ERR_CAPTURE},
    {"other condition", 12, 0, 2, 2, RG_OK},
    {"no condition", 12, 0, 2, 0, RG_ERR_STACK},
    {"unknown condition", 12, 0, 2, 3, RG_ERR_STACK},
    {"one knot", 12, 2, 2, 1, RG_ERR_STACK},
    {"65 knots", 12, 2, 2, 65, RG_ERR_STACK},
    {"fewer knots", 12, 2, 2, 2, RG_ERR_SECTION_SIZE},
    {"most knots", 12, 2, 2, 64, RG_ERR_SECTION_SIZE},
    {"lowest value", 12, KNOT_SIZE, 4, 0xfc000000, RG_OK},
    {"value below", 12, KNOT_SIZE, 4, 0xfbffffff, RG_ERR_STACK},
    {"smallest number as value", 12, KNOT_SIZE, 4, 0x80000000, RG_ERR_STACK},
    {"value twice", 12, 2 * KNOT_SIZE, 4, 0xffff8000, RG_ERR_STACK},
    {"value in reverse", 12, 2 * KNOT_SIZE, 4, 0xffff0000, RG_ERR_STACK},
    {"next value", 12, 2 * KNOT_SIZE, 4, 0xffff8001, RG_OK},
    {"highest value", 12, 3 * KNOT_SIZE, 4, 1024u << 16, RG_OK},
    {"value above", 12, 3 * KNOT_SIZE, 4, (1024u << 16) + 1, RG_ERR_STACK},

    {"reserved field of the capture", 11, 30, 2, 1, RG_ERR_RESERVED},
    {"coldest sensor", 11, 32, 4, 0xfc000000, RG_OK},
    {"colder sensor", 11, 32, 4, 0xfbffffff, RG_ERR_CAPTURE},
    {"smallest number as temperature", 11, 32, 4, 0x80000000, RG_ERR_CAPTURE},
    {"hotter sensor", 11, 32, 4, (1024u << 16) + 1, RG_ERR_CAPTURE},
    {"no exposure", 11, 36, 4, 0, RG_ERR_CAPTURE},
    {"longest exposure", 11, 36, 4, 1u << 30, RG_OK},
    {"longer exposure", 11, 36, 4, (1u << 30) + 1, RG_ERR_CAPTURE},
    {"no gain", 11, 40, 4, 0, RG_ERR_CAPTURE},
    {"smallest gain", 11, 40, 4, 1, RG_OK},
    {"gain beyond", 11, 40, 4, (1024u << 16) + 1, RG_ERR_CAPTURE},

    {"longest row time", 13, 0, 4, 1u << 30, RG_OK},
    {"longer row time", 13, 0, 4, (1u << 30) + 1, RG_ERR_ROW_TIME},
    {"longest row time from below", 13, 0, 4, 0xc0000000, RG_OK},
    {"longer row time from below", 13, 0, 4, 0xbfffffff, RG_ERR_ROW_TIME},
    {"smallest number as row time", 13, 0, 4, 0x80000000, RG_ERR_ROW_TIME},
    {"no row time", 13, 0, 4, 0, RG_OK},
    {"no deviation", 13, 4, 4, 0, RG_OK},
    {"largest deviation", 13, 4, 4, 1u << 30, RG_OK},
    {"larger deviation", 13, 4, 4, (1u << 30) + 1, RG_ERR_ROW_TIME},
    {"largest number as deviation", 13, 4, 4, 0xffffffff, RG_ERR_ROW_TIME},
};

/* Where the entry of a type is in a blob, or 0. */
static uint32_t find_entry(const golden_blob* blob, uint32_t type) {
  uint32_t entry = RG_HEADER_SIZE;
  const uint32_t num = rg_load_u16(blob->bytes + RG_HEADER_SECTION_COUNT);
  for (uint32_t k = 0; k < num; ++k, entry += RG_SECTION_ENTRY_SIZE)
    if (rg_load_u16(blob->bytes + entry) == type) return entry;
  return 0;
}

#define BLOB(name) \
  (golden_blob) { (name), sizeof(name) }

/* Of the others kWideBlob or, if it lacks the section, the first that has it.
 */
static golden_blob golden_blob_with(uint32_t type) {
  if (type == RG_SECTION_CENTRAL_GRID) return BLOB(kNarrowBlob);
  if (type == RG_SECTION_REMAP) return BLOB(kBentBlob);
  if (type == VIEW) return BLOB(kViewsBlob);
  if (type == MODE_TABLE) return BLOB(kModesBlob);
  golden_blob blob = BLOB(kWideBlob);
  for (uint32_t k = 0; !find_entry(&blob, type); ++k) {
    assert_true(k < NUM_GOLDEN_BLOBS);
    blob = kGoldenBlobs[k];
  }
  return blob;
}

static const uint8_t* blob_with(uint32_t type) {
  return golden_blob_with(type).bytes;
}

static uint32_t size_of_blob_with(uint32_t type) {
  return golden_blob_with(type).size;
}

static uint32_t entry_of_type(uint32_t type) {
  const golden_blob blob = golden_blob_with(type);
  return find_entry(&blob, type >= VIEW ? RG_SECTION_REMAP : type);
}

static void store(uint8_t* p, uint32_t num_bytes, uint32_t value) {
  for (uint32_t i = 0; i < num_bytes; ++i) p[i] = (uint8_t)(value >> 8 * i);
}

static void each_fault_has_its_own_status(void** state) {
  (void)state;
  for (size_t i = 0; i < sizeof(kValues) / sizeof(kValues[0]); ++i) {
    const field_value* value = &kValues[i];
    const uint8_t* blob = blob_with(value->type);
    const uint32_t size = size_of_blob_with(value->type);
    memcpy(edited, blob, size);
    const uint32_t section = rg_load_u32(blob + entry_of_type(value->type) + 4);
    store(edited + section + value->offset, value->num_bytes, value->value);
    repair_crcs(edited, size);
    const rg_status status = open_copy(edited, size);
    if (status != value->status) print_error("%s\n", value->what);
    assert_int_equal(status, value->status);
  }
}

/* Numbers of a rotation's row with the other sign; of two rows it is a rotation
 * again. */
static rg_status open_with_negated_rows(uint32_t num_rows) {
  memcpy(edited, kViewsBlob, sizeof(kViewsBlob));
  uint8_t* const rotation =
      edited + rg_load_u32(edited + entry_of_type(VIEW) + 4) + RG_VIEW_ROTATION;
  for (uint32_t k = 0; k < 3 * num_rows; ++k)
    rg_store_i32(rotation + 4 * k, -rg_load_i32(rotation + 4 * k));
  repair_crcs(edited, sizeof(kViewsBlob));
  return open_copy(edited, sizeof(kViewsBlob));
}

static void mirrors_are_no_rotations(void** state) {
  (void)state;
  assert_int_equal(open_with_negated_rows(0), RG_OK);
  assert_int_equal(open_with_negated_rows(1), RG_ERR_REMAP_CAMERA);
  assert_int_equal(open_with_negated_rows(2), RG_OK);
  assert_int_equal(open_with_negated_rows(3), RG_ERR_REMAP_CAMERA);
}

/* The last one, the stack, does not stand without tables. */
static const uint16_t kTypes[] = {5, 6, 7, 10, 11, 13, 12};
#define NUM_TYPES (sizeof(kTypes) / sizeof(kTypes[0]))
#define NUM_LONE_TYPES (NUM_TYPES - 1)

static void only_line_points_are_critical(void** state) {
  (void)state;
  for (size_t i = 0; i < NUM_TYPES; ++i) {
    const uint32_t size = size_of_blob_with(kTypes[i]);
    memcpy(edited, blob_with(kTypes[i]), size);
    edited[entry_of_type(kTypes[i]) + 2] ^= RG_SECTION_CRITICAL;
    repair_crcs(edited, size);
    /* On opening boards do not know captures, stacks and row times. */
    assert_int_equal(open_copy(edited, size), kTypes[i] >= RG_NUM_SECTION_TYPES
                                                  ? RG_ERR_SECTION_UNKNOWN
                                                  : RG_ERR_SECTION_FLAGS);
  }
}

/* Opens a blob of the camera, the grid, and num_copies copies of the section of
 * a type; size: of the first copy, if not 0. */
static rg_status open_with_copies(uint32_t type, uint32_t num_copies,
                                  uint32_t size) {
  static uint8_t bytes[2 * sizeof(kWideBlob)] __attribute__((aligned(4)));
  const uint8_t* blob = blob_with(type);
  const uint32_t k = (entry_of_type(type) - RG_HEADER_SIZE) / 16;
  blob_section sections[4] = {section_of(blob, 0), section_of(blob, 1),
                              section_of(blob, k), section_of(blob, k)};
  if (size != 0) sections[2].size = size;
  return open_copy(bytes, assemble_blob(sections, 2 + num_copies, bytes));
}

static void duplicate_sections_are_refused(void** state) {
  (void)state;
  for (size_t i = 0; i < NUM_LONE_TYPES; ++i) {
    assert_int_equal(open_with_copies(kTypes[i], 1, 0), RG_OK);
    assert_int_equal(open_with_copies(kTypes[i], 2, 0),
                     RG_ERR_SECTION_DUPLICATE);
  }
}

static void short_sections_are_refused(void** state) {
  (void)state;
  for (size_t i = 0; i < NUM_LONE_TYPES; ++i) {
    const uint32_t size =
        rg_load_u32(blob_with(kTypes[i]) + entry_of_type(kTypes[i]) + 8);
    for (uint32_t length = 4; length < size; length += 4)
      assert_int_equal(open_with_copies(kTypes[i], 1, length),
                       RG_ERR_SECTION_SIZE);
  }
}

static void narrow_grid_is_read(void** state) {
  (void)state;
  rg_blob blob;
  assert_int_equal(rg_blob_open(kNarrowBlob, sizeof(kNarrowBlob), &blob),
                   RG_OK);
  rg_grid_section grid;
  rg_blob_grid(&blob, &grid);
  const uint8_t* const data = grid.control_points;
  const uint32_t bits = rg_load_u16(kNarrowBlob + blob.grid + 30);
  assert_in_range(bits, RG_NARROW_MIN_BITS, RG_NARROW_MAX_BITS);
  for (uint32_t k = 0; k < (uint32_t)grid.columns * grid.rows; ++k) {
    int32_t point_q29[2];
    rg_blob_control_point(&blob, k % grid.columns, k / grid.columns, point_q29);
    for (uint32_t c = 0; c < 2; ++c) {
      const int64_t expected =
          rg_load_i32(data + 4 * c) +
          (int64_t)(k % grid.columns) * rg_load_i32(data + 8 + 4 * c) +
          (int64_t)(k / grid.columns) * rg_load_i32(data + 16 + 4 * c) +
          rg_load_i16(data + 24 + 4 * k + 2 * c) * (INT64_C(1) << (29 - bits));
      assert_true(point_q29[c] == expected);
    }
  }
}

static void inverse_grid_is_read(void** state) {
  (void)state;
  rg_blob blob;
  rg_inverse_section inverse;
  assert_int_equal(rg_blob_open(kWideBlob, sizeof(kWideBlob), &blob), RG_OK);
  rg_blob_inverse(&blob, &inverse);
  assert_int_equal(inverse.columns, 17);
  assert_int_equal(inverse.rows, 14);
  assert_true(inverse.a0_q27 < 0 && inverse.a1_q27 > 0);
  assert_true(inverse.b0_q27 < 0 && inverse.b1_q27 > 0);
  assert_int_equal(
      inverse.scale_a_q21,
      rg_grid_scale_q32(14, (uint32_t)(inverse.a1_q27 - inverse.a0_q27)));
  assert_int_equal(
      inverse.scale_b_q21,
      rg_grid_scale_q32(11, (uint32_t)(inverse.b1_q27 - inverse.b0_q27)));
  assert_true(inverse.cos_limit_q30 < 0);
}

/* Until version 1.2 a section of type 9 held a start for projection. */
static void start_of_older_versions_is_skipped(void** state) {
  (void)state;
  static const uint8_t start[36] = {1, 2, 3};
  static uint8_t bytes[sizeof(kWideBlob)] __attribute__((aligned(4)));
  blob_section sections[3] = {
      section_of(kWideBlob, 0), section_of(kWideBlob, 1), {9, 0, start, 36}};
  const uint32_t size = assemble_blob(sections, 3, bytes);
  for (uint16_t minor = 1; minor <= 2; ++minor) {
    rg_store_u16(bytes + 10, minor);
    repair_crcs(bytes, size);
    assert_int_equal(open_copy(bytes, size), RG_OK);
  }
}

static void mask_and_uncertainty_are_read(void** state) {
  (void)state;
  rg_blob blob;
  rg_mask_section mask;
  rg_uncertainty_section uncertainty;
  assert_int_equal(rg_blob_open(kWideBlob, sizeof(kWideBlob), &blob), RG_OK);
  rg_blob_mask(&blob, &mask);
  assert_int_equal(mask.columns, 10);
  assert_int_equal(mask.rows, 8);
  assert_int_equal(mask.cell_log2, 5);
  assert_ptr_equal(mask.bits, kWideBlob + blob.mask + 12);
  rg_blob_uncertainty(&blob, &uncertainty);
  assert_int_equal(uncertainty.columns, 5);
  assert_int_equal(uncertainty.rows, 3);
  assert_int_equal(uncertainty.scale_x_q32, rg_grid_scale_q32(4, 319u << 16));
  assert_int_equal(uncertainty.scale_y_q32, rg_grid_scale_q32(2, 239u << 16));
  assert_ptr_equal(uncertainty.values, kWideBlob + blob.uncertainty + 16);
}

static void capture_is_read(void** state) {
  (void)state;
  rg_blob blob;
  rg_capture_section capture;
  assert_int_equal(rg_blob_open(kCaptureBlob, sizeof(kCaptureBlob), &blob),
                   RG_OK);
  rg_blob_capture(&blob, &capture);
  assert_int_equal(capture.known, 127);
  assert_int_equal(capture.lens_position_q16, 2 << 16);
  assert_int_equal(capture.lens_tolerance_q16, 6553);
  assert_int_equal(capture.crop_x, 4);
  assert_int_equal(capture.crop_y, 4);
  assert_int_equal(capture.crop_width, 256);
  assert_int_equal(capture.crop_height, 192);
  assert_int_equal(capture.zoom_q16, 66191);
  assert_int_equal(capture.orientation, 3);
  assert_int_equal(capture.temperature_q16, -5 * 65536);
  assert_int_equal(capture.exposure_us, 8333);
  assert_int_equal(capture.analogue_gain_q16, 98304);
  assert_int_equal(rg_blob_open(kWideBlob, sizeof(kWideBlob), &blob), RG_OK);
  assert_int_equal(blob.capture, 0);
}

static void row_time_is_read(void** state) {
  (void)state;
  rg_blob blob;
  rg_row_time_section row_time;
  assert_int_equal(rg_blob_open(kRowTimeBlob, sizeof(kRowTimeBlob), &blob),
                   RG_OK);
  rg_blob_row_time(&blob, &row_time);
  assert_int_equal(row_time.row_time_ns_q10, -20000 * 1024);
  assert_int_equal(row_time.stddev_ns_q10, 31 * 1024);
  assert_int_equal(rg_blob_open(kWideBlob, sizeof(kWideBlob), &blob), RG_OK);
  assert_int_equal(blob.row_time, 0);
}

/* Nothing is known but one thing, and the rest is 0. */
static void capture_of_one_thing_is_read(void** state) {
  (void)state;
  const uint32_t section =
      rg_load_u32(kCaptureBlob + entry_of_type(RG_SECTION_CAPTURE) + 4);
  static const uint8_t kBytes[7][2] = {{0, 8},   {8, 24},  {24, 28}, {29, 30},
                                       {32, 36}, {36, 40}, {40, 44}};
  for (uint32_t k = 0; k < 7; ++k) {
    const uint32_t size = sizeof(kCaptureBlob);
    memcpy(edited, kCaptureBlob, size);
    memset(edited + section, 0, RG_CAPTURE_SIZE);
    memcpy(edited + section + kBytes[k][0],
           kCaptureBlob + section + kBytes[k][0],
           (size_t)(kBytes[k][1] - kBytes[k][0]));
    edited[section + RG_CAPTURE_KNOWN] = (uint8_t)(1u << k);
    repair_crcs(edited, size);
    assert_int_equal(open_copy(edited, size), RG_OK);
  }
}

/* Fields that later versions may add. */
static void longer_capture_is_read(void** state) {
  (void)state;
  static uint8_t bytes[RG_CAPTURE_SIZE + 8];
  const uint32_t k = (entry_of_type(RG_SECTION_CAPTURE) - RG_HEADER_SIZE) / 16;
  blob_section sections[3] = {section_of(kCaptureBlob, 0),
                              section_of(kCaptureBlob, 1),
                              section_of(kCaptureBlob, k)};
  memcpy(bytes, sections[2].bytes, RG_CAPTURE_SIZE);
  bytes[RG_CAPTURE_SIZE + 3] = 7;
  sections[2].bytes = bytes;
  sections[2].size = sizeof(bytes);
  assert_int_equal(open_copy(edited, assemble_blob(sections, 3, edited)),
                   RG_OK);
}

/* The grid's fields are not looked at before its size. */
static void line_points_before_a_short_grid_are_refused(void** state) {
  (void)state;
  const uint32_t k =
      (entry_of_type(RG_SECTION_LINE_POINTS) - RG_HEADER_SIZE) / 16;
  blob_section sections[3] = {section_of(kLinesBlob, 0),
                              section_of(kLinesBlob, k),
                              section_of(kLinesBlob, 1)};
  assert_int_equal(open_copy(edited, assemble_blob(sections, 3, edited)),
                   RG_OK);
  sections[2].size = 4;
  assert_int_equal(open_copy(edited, assemble_blob(sections, 3, edited)),
                   RG_ERR_SECTION_SIZE);
}

static void every_flipped_bit_is_refused(void** state) {
  (void)state;
  memcpy(edited, kWideBlob, sizeof(kWideBlob));
  rg_blob blob;
  for (uint32_t bit = 0; bit < 8 * sizeof(kWideBlob); bit += 5) {
    edited[bit / 8] ^= (uint8_t)(1u << bit % 8);
    assert_int_not_equal(rg_blob_open(edited, sizeof(kWideBlob), &blob), RG_OK);
    edited[bit / 8] ^= (uint8_t)(1u << bit % 8);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_fault_has_its_own_status),
      cmocka_unit_test(mirrors_are_no_rotations),
      cmocka_unit_test(only_line_points_are_critical),
      cmocka_unit_test(duplicate_sections_are_refused),
      cmocka_unit_test(short_sections_are_refused),
      cmocka_unit_test(narrow_grid_is_read),
      cmocka_unit_test(inverse_grid_is_read),
      cmocka_unit_test(start_of_older_versions_is_skipped),
      cmocka_unit_test(mask_and_uncertainty_are_read),
      cmocka_unit_test(capture_is_read),
      cmocka_unit_test(row_time_is_read),
      cmocka_unit_test(capture_of_one_thing_is_read),
      cmocka_unit_test(longer_capture_is_read),
      cmocka_unit_test(line_points_before_a_short_grid_are_refused),
      cmocka_unit_test(every_flipped_bit_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
