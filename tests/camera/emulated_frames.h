/* The frames that the emulated camera plays: a file's again and again, or the
 * newest picture of standard input, which also unplugs the camera. */
#ifndef RAYGRID_TESTS_CAMERA_EMULATED_FRAMES_H
#define RAYGRID_TESTS_CAMERA_EMULATED_FRAMES_H

#include <stddef.h>
#include <stdint.h>

enum { MAX_FRAMES = 1024 };

typedef struct played_frames {
  uint8_t* bytes;
  size_t starts[MAX_FRAMES + 1]; /* of frames, and the end of the last one */
  size_t num_frames;
} played_frames;

/* An order is a letter, and the bytes of the picture behind ORDER_PICTURE. */
enum { ORDER_PICTURE = 'f', ORDER_UNPLUG = 'u', ORDER_PLUG = 'p' };

typedef struct live_orders {
  uint8_t* bytes; /* of the order that is being read */
  size_t frame_size, filled;
  int is_open;
} live_orders;

/* Says what is wrong, and ends the program. */
void fail(const char* what);

/* Returns whether the frames are JPEGs. */
int read_frames(played_frames* frames, const char* path, size_t frame_size);

/* Grey frames, until standard input has a picture. */
void open_orders(live_orders* orders, played_frames* frames, size_t frame_size);
/* Reads what there is. */
void read_orders(live_orders* orders);
/* The order that is whole; 0: there is none. */
int whole_order(const live_orders* orders);
/* Ends it. A picture is played from now on. */
void end_order(live_orders* orders, played_frames* frames);

#endif
