#define _POSIX_C_SOURCE 200809L
#include "emulated_frames.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void fail(const char* what) {
  fprintf(stderr, "emulated_camera: %s\n", what);
  exit(1);
}

/* A JPEG begins with these three bytes, which nothing within it is. */
static int begins_jpeg(const uint8_t* data) {
  return data[0] == 0xff && data[1] == 0xd8 && data[2] == 0xff;
}

/* Returns whether the frames are JPEGs. */
static int find_frames(played_frames* frames, size_t size, size_t frame_size) {
  const int is_jpeg = size > 3 && begins_jpeg(frames->bytes);
  const size_t step = is_jpeg ? 1 : frame_size;
  const size_t least = is_jpeg ? 3 : frame_size;
  for (size_t i = 0; i + least <= size && frames->num_frames < MAX_FRAMES;
       i += step)
    if (!is_jpeg || begins_jpeg(frames->bytes + i))
      frames->starts[frames->num_frames++] = i;
  if (frames->num_frames == 0) fail("not a whole frame in the file");
  frames->starts[frames->num_frames] =
      is_jpeg ? size : frames->num_frames * frame_size;
  return is_jpeg;
}

int read_frames(played_frames* frames, const char* path, size_t frame_size) {
  FILE* const file = fopen(path, "rb");
  if (!file || fseek(file, 0, SEEK_END) != 0) fail("no file of frames");
  const size_t size = (size_t)ftell(file);
  rewind(file);
  frames->bytes = (uint8_t*)malloc(size);
  if (!frames->bytes || fread(frames->bytes, 1, size, file) != size)
    fail("the frames cannot be read");
  fclose(file);
  return find_frames(frames, size, frame_size);
}

void open_orders(live_orders* orders, played_frames* frames,
                 size_t frame_size) {
  orders->frame_size = frame_size;
  orders->bytes = (uint8_t*)malloc(1 + frame_size);
  frames->bytes = (uint8_t*)malloc(frame_size);
  if (!orders->bytes || !frames->bytes ||
      fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK) != 0)
    fail("standard input gives no pictures");
  memset(frames->bytes, 128, frame_size);
  frames->starts[1] = frame_size;
  frames->num_frames = 1;
  orders->is_open = 1;
}

static size_t order_size(const live_orders* orders) {
  if (orders->filled == 0) return 1;
  return orders->bytes[0] == ORDER_PICTURE ? 1 + orders->frame_size : 1;
}

void read_orders(live_orders* orders) {
  while (orders->filled < order_size(orders)) {
    const ssize_t got = read(STDIN_FILENO, orders->bytes + orders->filled,
                             order_size(orders) - orders->filled);
    if (got == 0) orders->is_open = 0;
    if (got <= 0) return;
    orders->filled += (size_t)got;
  }
}

int whole_order(const live_orders* orders) {
  const int is_whole =
      orders->filled > 0 && orders->filled == order_size(orders);
  return is_whole ? orders->bytes[0] : 0;
}

void end_order(live_orders* orders, played_frames* frames) {
  if (whole_order(orders) == ORDER_PICTURE)
    memcpy(frames->bytes, orders->bytes + 1, orders->frame_size);
  orders->filled = 0;
}
