/* Where the pixels of a block's row come from: formats/SPEC.md, "Remap
 * arithmetic". All positions are q12 source pixels. */
#ifndef RAYGRID_REMAP_TABLE_H
#define RAYGRID_REMAP_TABLE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* x, y */
typedef struct rg_position {
  int32_t q12[2];
} rg_position;

/* The corners of a block: top left, top right, bottom left, bottom right. */
typedef struct rg_block {
  rg_position corners[4];
} rg_block;

/* Block (i, j) of a remap section, which must be one that rg_blob_open()
 * accepted. */
void rg_remap_block(const uint8_t* section, uint32_t i, uint32_t j,
                    rg_block* block);

/* A row of a block. Its pixels lie in segments of RG_SEGMENT_SIZE; from one to
 * the next inside a segment is step. */
typedef struct rg_block_row {
  rg_position left, right;
  rg_position step;
} rg_block_row;

#define RG_SEGMENT_SIZE 8u

/* Row r, 0 to block size - 1, of a block of the section. */
void rg_remap_block_row(const uint8_t* section, const rg_block* block,
                        uint32_t r, rg_block_row* row);

/* The mean of two rows, for samples half-way between them. */
void rg_remap_average_rows(const uint8_t* section, const rg_block_row* other,
                           rg_block_row* row);

/* Source position of the segment that begins at pixel k of the row. */
rg_position rg_remap_segment(const uint8_t* section, const rg_block_row* row,
                             uint32_t k);

/* 1 if the table says that no pixel of block (i, j) has a source. */
int rg_remap_is_empty(const uint8_t* section, uint32_t i, uint32_t j);

#ifdef __cplusplus
}
#endif

#endif /* RAYGRID_REMAP_TABLE_H */
