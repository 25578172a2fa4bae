/* A USB camera that is not there: UVC 1.0, YUYV frames or JPEGs of a file again
 * and again over a bulk endpoint, for QEMU's usb-redir on a unix socket.
 *
 *   emulated_camera SOCKET WIDTHxHEIGHT FRAMES_PER_SECOND FILE [UNPLUG_AFTER]
 *
 * It focuses, exposes and balances white by itself until controls end that. It
 * ends when QEMU does, tells how its controls were set, and unplugs itself
 * after UNPLUG_AFTER frames. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>
#include <usbredirparser.h>

enum {
  CONTROL_INTERFACE = 0,
  STREAM_INTERFACE = 1,
  VIDEO_CLASS = 0x0e,
  STREAM_ENDPOINT = 0x81,
  STREAM_PACKET = 512,
  MAX_PAYLOAD = 16384, /* what uvcvideo reads at once */
  PAYLOAD_HEADER = 2,
  PROBE_SIZE = 26, /* of UVC 1.0 */
  MAX_READS = 256,
  MAX_SETTINGS = 64,
  MAX_FRAMES = 1024
};

/* ---- Descriptors --------------------------------------------------------- */

typedef struct bytes {
  uint8_t data[256];
  int size;
} bytes;

static void add8(bytes* to, unsigned value) {
  to->data[to->size++] = (uint8_t)value;
}

static void add16(bytes* to, unsigned value) {
  add8(to, value & 255);
  add8(to, value >> 8 & 255);
}

static void add32(bytes* to, uint32_t value) {
  add16(to, value & 0xffff);
  add16(to, value >> 16);
}

static void add_list(bytes* to, const uint8_t* values, int count) {
  for (int i = 0; i < count; ++i) add8(to, values[i]);
}

#define ADD(to, ...)                           \
  add_list(to, (const uint8_t[]){__VA_ARGS__}, \
           (int)sizeof((const uint8_t[]){__VA_ARGS__}))

static const uint8_t kDevice[18] = {18,   1,  0x00, 0x02, 0xef, 2,
                                    1,    64, 0x09, 0x12, 0x01, 0x00,
                                    0x00, 1,  1,    2,    0,    1};

/* Writes a length over the two bytes at a place. */
static void set16(bytes* to, int place, int value) {
  to->data[place] = (uint8_t)(value & 255);
  to->data[place + 1] = (uint8_t)(value >> 8);
}

/* Camera terminal 1 and processing unit 3 to output terminal 2. */
static void add_control_interface(bytes* to) {
  ADD(to, 9, 4, CONTROL_INTERFACE, 0, 0, VIDEO_CLASS, 1, 0, 0);
  const int start = to->size;
  ADD(to, 13, 0x24, 1, 0x00, 0x01, 0, 0);
  add32(to, 48000000);
  ADD(to, 1, STREAM_INTERFACE);
  /* Its last bytes name the controls that are in kControls. */
  ADD(to, 18, 0x24, 2, 1, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0x2a, 0, 2);
  ADD(to, 11, 0x24, 5, 3, 1, 0, 0, 2, 0x40, 0x12, 0);
  ADD(to, 9, 0x24, 3, 2, 0x01, 0x01, 0, 3, 0);
  set16(to, start + 5, to->size - start);
}

static const uint8_t kYuyv[16] = {'Y',  'U',  'Y',  '2',  0, 0,
                                  0x10, 0,    0x80, 0x00, 0, 0xaa,
                                  0x00, 0x38, 0x9b, 0x71};

/* subtype: 5 of frames of pixels, 7 of JPEGs */
static void add_frame_sizes(bytes* to, uint8_t subtype, unsigned width,
                            unsigned height, unsigned interval) {
  const uint32_t frame_size = width * height * 2;
  const uint32_t bits = frame_size * 8 * (10000000 / interval);
  ADD(to, 30, 0x24, subtype, 1, 0);
  add16(to, width);
  add16(to, height);
  add32(to, bits);
  add32(to, bits);
  add32(to, frame_size);
  add32(to, interval);
  add8(to, 1);
  add32(to, interval);
}

static void add_stream_interface(bytes* to, int is_jpeg, unsigned width,
                                 unsigned height, unsigned interval) {
  ADD(to, 9, 4, STREAM_INTERFACE, 0, 1, VIDEO_CLASS, 2, 0, 0);
  const int start = to->size;
  ADD(to, 14, 0x24, 1, 1, 0, 0, STREAM_ENDPOINT, 0, 2, 0, 0, 0, 1, 0);
  if (is_jpeg) {
    ADD(to, 11, 0x24, 6, 1, 1, 0, 1, 0, 0, 0, 0);
  } else {
    ADD(to, 27, 0x24, 4, 1, 1);
    add_list(to, kYuyv, 16);
    ADD(to, 16, 1, 0, 0, 0, 0);
  }
  add_frame_sizes(to, is_jpeg ? 7 : 5, width, height, interval);
  ADD(to, 6, 0x24, 13, 1, 1, 4);
  set16(to, start + 4, to->size - start);
  ADD(to, 7, 5, STREAM_ENDPOINT, 2, STREAM_PACKET & 255, STREAM_PACKET >> 8, 0);
}

static bytes make_configuration(int is_jpeg, unsigned width, unsigned height,
                                unsigned interval) {
  bytes all = {{0}, 0};
  ADD(&all, 9, 2, 0, 0, 2, 1, 0, 0x80, 50);
  ADD(&all, 8, 11, CONTROL_INTERFACE, 2, VIDEO_CLASS, 3, 0, 0);
  add_control_interface(&all);
  add_stream_interface(&all, is_jpeg, width, height, interval);
  set16(&all, 2, all.size);
  return all;
}

/* The only stream there is, as probe and commit answer it. */
static bytes make_probe(unsigned width, unsigned height, unsigned interval) {
  bytes probe = {{0}, 0};
  ADD(&probe, 1, 0, 1, 1);
  add32(&probe, interval);
  ADD(&probe, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
  add32(&probe, width * height * 2);
  add32(&probe, MAX_PAYLOAD);
  return probe;
}

static bytes make_text(const char* text) {
  bytes result = {{0}, 0};
  ADD(&result, (uint8_t)(2 + 2 * strlen(text)), 3);
  for (; *text; ++text) add16(&result, (uint8_t)*text);
  return result;
}

/* ---- Controls ------------------------------------------------------------ */

enum {
  AE_MODE,
  EXPOSURE,
  FOCUS,
  FOCUS_AUTO,
  GAIN,
  WHITE,
  WHITE_AUTO,
  NUM_CONTROLS,
  AE_MANUAL = 1,
  AE_APERTURE_PRIORITY = 8,
  FOLLOWS = 8 /* in info: the value changes by itself */
};

/* The step of AE_MODE is a mask of the modes that there are, as UVC has it. */
typedef struct usb_control {
  const char* name;
  uint8_t entity, selector, size, info;
  uint16_t minimum, maximum, step, initial, value;
} usb_control;

static const usb_control kControls[NUM_CONTROLS] = {
    [AE_MODE] = {"exposure mode", 1, 2, 1, 3, 1, 8, 9, AE_APERTURE_PRIORITY,
                 AE_APERTURE_PRIORITY},
    [EXPOSURE] = {"exposure", 1, 4, 4, 3, 3, 2047, 1, 100, 100},
    [FOCUS] = {"focus", 1, 6, 2, 3 | FOLLOWS, 0, 250, 1, 40, 40},
    [FOCUS_AUTO] = {"focus mode", 1, 8, 1, 3, 0, 1, 1, 1, 1},
    [GAIN] = {"gain", 3, 4, 2, 3, 0, 255, 1, 64, 64},
    [WHITE] = {"white", 3, 0x0a, 2, 3, 2000, 6500, 1, 4600, 4600},
    [WHITE_AUTO] = {"white mode", 3, 0x0b, 1, 3, 0, 1, 1, 1, 1}};

/* ---- State --------------------------------------------------------------- */

typedef struct usb_camera {
  struct usbredirparser* parser;
  int socket;
  bytes configuration, probe;
  uint8_t* frames;
  size_t starts[MAX_FRAMES + 1]; /* of frames, and the end of the last one */
  size_t num_frames;
  double interval_s;
  long unplug_after; /* 0: never */

  /* Reads of the stream endpoint that wait for data. */
  struct {
    uint64_t id;
    uint32_t size;
  } reads[MAX_READS];
  int num_reads;

  size_t sent;      /* bytes of the frame that is being sent */
  long num_sent;    /* whole frames */
  uint8_t frame_id; /* toggles with each frame */
  double next_s;
  int is_unplugged;
  uint8_t configured;

  usb_control controls[NUM_CONTROLS];
  struct {
    const char* name;
    unsigned value, exposure, focus; /* as it is, and as the camera stands */
  } settings[MAX_SETTINGS];          /* of controls, the first ones */
  int num_settings;
} usb_camera;

static double now_s(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void forget_reads(usb_camera* camera) {
  camera->num_reads = 0;
  camera->sent = 0;
}

/* ---- The parser's callbacks ---------------------------------------------- */

static int read_socket(void* state, uint8_t* data, int size) {
  const ssize_t got = read(((usb_camera*)state)->socket, data, (size_t)size);
  if (got < 0) return errno == EAGAIN ? 0 : -1;
  return got == 0 ? -1 : (int)got;
}

static int write_socket(void* state, uint8_t* data, int size) {
  const ssize_t put = write(((usb_camera*)state)->socket, data, (size_t)size);
  if (put < 0) return errno == EAGAIN ? 0 : -1;
  return (int)put;
}

static void log_message(void* state, int level, const char* message) {
  (void)state;
  if (level <= usbredirparser_warning)
    fprintf(stderr, "emulated_camera: %s\n", message);
}

static void on_hello(void* state, struct usb_redir_hello_header* hello) {
  struct usbredirparser* const parser = ((usb_camera*)state)->parser;
  (void)hello;
  struct usb_redir_interface_info_header interfaces = {.interface_count = 2};
  for (uint8_t i = 0; i < 2; ++i) {
    interfaces.interface[i] = i;
    interfaces.interface_class[i] = VIDEO_CLASS;
    interfaces.interface_subclass[i] = (uint8_t)(i + 1);
  }
  usbredirparser_send_interface_info(parser, &interfaces);
  /* Endpoints 0 out, 0 in at 16, and the stream's, 1 in, at 17. */
  struct usb_redir_ep_info_header endpoints;
  memset(&endpoints, 0, sizeof(endpoints));
  memset(endpoints.type, usb_redir_type_invalid, sizeof(endpoints.type));
  endpoints.type[0] = endpoints.type[16] = usb_redir_type_control;
  endpoints.max_packet_size[0] = endpoints.max_packet_size[16] = 64;
  endpoints.type[17] = usb_redir_type_bulk;
  endpoints.interface[17] = STREAM_INTERFACE;
  endpoints.max_packet_size[17] = STREAM_PACKET;
  usbredirparser_send_ep_info(parser, &endpoints);
  struct usb_redir_device_connect_header device = {
      .speed = usb_redir_speed_high,
      .device_class = kDevice[4],
      .device_subclass = kDevice[5],
      .device_protocol = kDevice[6],
      .vendor_id = 0x1209,
      .product_id = 0x0001};
  usbredirparser_send_device_connect(parser, &device);
}

static void on_reset(void* state) { forget_reads((usb_camera*)state); }

static void send_configuration(usb_camera* camera, uint64_t id) {
  struct usb_redir_configuration_status_header status = {usb_redir_success,
                                                         camera->configured};
  usbredirparser_send_configuration_status(camera->parser, id, &status);
}

static void on_set_configuration(
    void* state, uint64_t id, struct usb_redir_set_configuration_header* set) {
  ((usb_camera*)state)->configured = set->configuration;
  send_configuration((usb_camera*)state, id);
}

static void on_get_configuration(void* state, uint64_t id) {
  send_configuration((usb_camera*)state, id);
}

static void send_alternate(usb_camera* camera, uint64_t id, uint8_t interface,
                           uint8_t alternate) {
  struct usb_redir_alt_setting_status_header status = {usb_redir_success,
                                                       interface, alternate};
  usbredirparser_send_alt_setting_status(camera->parser, id, &status);
}

static void on_set_alternate(void* state, uint64_t id,
                             struct usb_redir_set_alt_setting_header* set) {
  send_alternate((usb_camera*)state, id, set->interface, set->alt);
}

static void on_get_alternate(void* state, uint64_t id,
                             struct usb_redir_get_alt_setting_header* get) {
  send_alternate((usb_camera*)state, id, get->interface, 0);
}

static void on_cancel(void* state, uint64_t id) {
  usb_camera* const camera = (usb_camera*)state;
  for (int i = 0; i < camera->num_reads; ++i) {
    if (camera->reads[i].id != id) continue;
    --camera->num_reads;
    memmove(&camera->reads[i], &camera->reads[i + 1],
            (size_t)(camera->num_reads - i) * sizeof(camera->reads[0]));
    struct usb_redir_bulk_packet_header header = {
        .endpoint = STREAM_ENDPOINT, .status = usb_redir_cancelled};
    usbredirparser_send_bulk_packet(camera->parser, id, &header, NULL, 0);
    return;
  }
}

/* GET_DESCRIPTOR; 0 for one that there is none of. */
static int answer_descriptor(const usb_camera* camera, unsigned value,
                             bytes* answer) {
  static const char* const kTexts[] = {"raygrid", "Emulated camera"};
  const unsigned type = value >> 8, index = value & 255;
  if (type == 1) {
    add_list(answer, kDevice, sizeof(kDevice));
  } else if (type == 2) {
    *answer = camera->configuration;
  } else if (type == 3 && index == 0) {
    ADD(answer, 4, 3, 9, 4);
  } else if (type == 3 && index <= 2) {
    *answer = make_text(kTexts[index - 1]);
  } else {
    return 0;
  }
  return 1;
}

/* Requests to probe or commit the stream. */
static int answer_stream(const usb_camera* camera, unsigned request,
                         bytes* answer) {
  enum { GET_LENGTH = 0x85, GET_INFORMATION = 0x86 };
  if (request == GET_LENGTH)
    add16(answer, PROBE_SIZE);
  else if (request == GET_INFORMATION)
    add8(answer, 3);
  else
    *answer = camera->probe;
  return 1;
}

/* Each frame has a focus and an exposure of its own while they follow. */
static void follow(usb_camera* camera) {
  if (camera->controls[AE_MODE].value != AE_MANUAL)
    camera->controls[EXPOSURE].value = (uint16_t)(100 + camera->num_sent % 50);
  if (camera->controls[FOCUS_AUTO].value != 0)
    camera->controls[FOCUS].value = (uint16_t)(40 + camera->num_sent % 20);
}

static usb_control* find_control(
    usb_camera* camera, const struct usb_redir_control_packet_header* packet) {
  if ((packet->index & 255) != CONTROL_INTERFACE) return NULL;
  follow(camera);
  for (int i = 0; i < NUM_CONTROLS; ++i)
    if (camera->controls[i].entity == packet->index >> 8 &&
        camera->controls[i].selector == packet->value >> 8)
      return &camera->controls[i];
  return NULL;
}

static int get_control(const usb_control* control, unsigned request,
                       bytes* answer) {
  enum { CURRENT = 0x81, MINIMUM, MAXIMUM, STEP, LENGTH, INFORMATION, DEFAULT };
  if (!control) return 0;
  if (request == LENGTH) add16(answer, control->size);
  if (request == INFORMATION) add8(answer, control->info);
  if (request == LENGTH || request == INFORMATION) return 1;
  add32(answer, request == CURRENT   ? control->value
                : request == MINIMUM ? control->minimum
                : request == MAXIMUM ? control->maximum
                : request == STEP    ? control->step
                                     : control->initial);
  answer->size = control->size;
  return 1;
}

static void set_control(usb_camera* camera, usb_control* control,
                        const uint8_t* data, int size) {
  if (!control || size < control->size) return;
  control->value =
      (uint16_t)(control->size == 1 ? data[0] : data[0] | data[1] << 8);
  if (camera->num_settings == MAX_SETTINGS) return;
  const int i = camera->num_settings++;
  camera->settings[i].name = control->name;
  camera->settings[i].value = control->value;
  camera->settings[i].exposure = camera->controls[EXPOSURE].value;
  camera->settings[i].focus = camera->controls[FOCUS].value;
}

static int answer_control(usb_camera* camera,
                          const struct usb_redir_control_packet_header* packet,
                          const uint8_t* data, int size, bytes* answer) {
  enum { GET_STATUS = 0, CLEAR_FEATURE = 1, GET_DESCRIPTOR = 6 };
  const unsigned interface = packet->index & 255;
  const unsigned selector = packet->value >> 8; /* 1: probe, 2: commit */
  switch (packet->requesttype) {
    case 0x80:
      if (packet->request == GET_DESCRIPTOR)
        return answer_descriptor(camera, packet->value, answer);
      if (packet->request == GET_STATUS) add16(answer, 0);
      return packet->request == GET_STATUS;
    case 0xa1:
      if (interface == CONTROL_INTERFACE)
        return get_control(find_control(camera, packet), packet->request,
                           answer);
      if (interface != STREAM_INTERFACE || selector < 1 || selector > 2)
        return 0;
      return answer_stream(camera, packet->request, answer);
    case 0x21: /* what is set is what there is */
      if (interface == STREAM_INTERFACE && selector == 2) forget_reads(camera);
      if (interface == CONTROL_INTERFACE)
        set_control(camera, find_control(camera, packet), data, size);
      return 1;
    case 0x02:
      if (packet->request == CLEAR_FEATURE) forget_reads(camera);
      return 1;
    default:
      return (packet->requesttype & 0x80) == 0;
  }
}

static void on_control(void* state, uint64_t id,
                       struct usb_redir_control_packet_header* packet,
                       uint8_t* data, int size) {
  usb_camera* const camera = (usb_camera*)state;
  bytes answer = {{0}, 0};
  const int is_known = answer_control(camera, packet, data, size, &answer);
  struct usb_redir_control_packet_header header = *packet;
  header.status = is_known ? usb_redir_success : usb_redir_stall;
  const int is_in = (packet->endpoint & 0x80) != 0;
  if (is_in) {
    if (answer.size > packet->length) answer.size = packet->length;
    header.length = (uint16_t)(is_known ? answer.size : 0);
  }
  const int size_in = is_in ? header.length : 0;
  usbredirparser_send_control_packet(camera->parser, id, &header,
                                     size_in > 0 ? answer.data : NULL, size_in);
  usbredirparser_free_packet_data(camera->parser, data);
}

static void on_bulk(void* state, uint64_t id,
                    struct usb_redir_bulk_packet_header* packet, uint8_t* data,
                    int size) {
  usb_camera* const camera = (usb_camera*)state;
  (void)size;
  usbredirparser_free_packet_data(camera->parser, data);
  if (camera->num_reads == MAX_READS) return;
  camera->reads[camera->num_reads].id = id;
  camera->reads[camera->num_reads].size =
      packet->length | (uint32_t)packet->length_high << 16;
  ++camera->num_reads;
}

/* ---- Stream -------------------------------------------------------------- */

/* A payload: the next part of the frame. */
static void answer_read(usb_camera* camera) {
  enum { FRAME_ID = 1, END_OF_FRAME = 2, END_OF_HEADER = 0x80 };
  static uint8_t payload[MAX_PAYLOAD];
  uint32_t size = camera->reads[0].size;
  if (size > MAX_PAYLOAD) size = MAX_PAYLOAD;
  size_t part = size - PAYLOAD_HEADER;
  const size_t index = (size_t)camera->num_sent % camera->num_frames;
  const size_t frame_size = camera->starts[index + 1] - camera->starts[index];
  const size_t left = frame_size - camera->sent;
  if (part > left) part = left;
  memcpy(payload + PAYLOAD_HEADER,
         camera->frames + camera->starts[index] + camera->sent, part);
  camera->sent += part;
  const int is_end = camera->sent == frame_size;
  payload[0] = PAYLOAD_HEADER;
  payload[1] = (uint8_t)(END_OF_HEADER | (is_end ? END_OF_FRAME : 0) |
                         (camera->frame_id ? FRAME_ID : 0));
  const uint32_t length = (uint32_t)part + PAYLOAD_HEADER;
  struct usb_redir_bulk_packet_header header = {
      .endpoint = STREAM_ENDPOINT,
      .status = usb_redir_success,
      .length = (uint16_t)length,
      .length_high = (uint16_t)(length >> 16)};
  usbredirparser_send_bulk_packet(camera->parser, camera->reads[0].id, &header,
                                  payload, (int)length);
  --camera->num_reads;
  memmove(&camera->reads[0], &camera->reads[1],
          (size_t)camera->num_reads * sizeof(camera->reads[0]));
  if (!is_end) return;
  camera->sent = 0;
  camera->frame_id ^= 1;
  ++camera->num_sent;
}

static void unplug(usb_camera* camera) {
  usbredirparser_send_device_disconnect(camera->parser);
  camera->is_unplugged = 1;
  camera->num_reads = 0;
}

static void send_frames(usb_camera* camera) {
  while (camera->num_reads > 0 && !camera->is_unplugged) {
    if (camera->sent == 0) {
      const double now = now_s();
      if (now < camera->next_s) return;
      const int is_late = now - camera->next_s > camera->interval_s;
      camera->next_s = (is_late ? now : camera->next_s) + camera->interval_s;
    }
    answer_read(camera);
    if (camera->unplug_after > 0 && camera->num_sent >= camera->unplug_after)
      unplug(camera);
  }
}

/* ---- Program ------------------------------------------------------------- */

static void fail(const char* what) {
  fprintf(stderr, "emulated_camera: %s\n", what);
  exit(1);
}

/* A JPEG begins with these three bytes, which nothing within it is. */
static int begins_jpeg(const uint8_t* data) {
  return data[0] == 0xff && data[1] == 0xd8 && data[2] == 0xff;
}

/* Returns whether the frames are JPEGs. */
static int find_frames(usb_camera* camera, size_t size, size_t frame_size) {
  const int is_jpeg = size > 3 && begins_jpeg(camera->frames);
  const size_t step = is_jpeg ? 1 : frame_size;
  const size_t least = is_jpeg ? 3 : frame_size;
  for (size_t i = 0; i + least <= size && camera->num_frames < MAX_FRAMES;
       i += step)
    if (!is_jpeg || begins_jpeg(camera->frames + i))
      camera->starts[camera->num_frames++] = i;
  if (camera->num_frames == 0) fail("not a whole frame in the file");
  camera->starts[camera->num_frames] =
      is_jpeg ? size : camera->num_frames * frame_size;
  return is_jpeg;
}

static int read_frames(usb_camera* camera, const char* path,
                       size_t frame_size) {
  FILE* const file = fopen(path, "rb");
  if (!file || fseek(file, 0, SEEK_END) != 0) fail("no file of frames");
  const size_t size = (size_t)ftell(file);
  rewind(file);
  camera->frames = (uint8_t*)malloc(size);
  if (!camera->frames || fread(camera->frames, 1, size, file) != size)
    fail("the frames cannot be read");
  fclose(file);
  return find_frames(camera, size, frame_size);
}

static int wait_for_qemu(const char* path) {
  const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  snprintf(address.sun_path, sizeof(address.sun_path), "%s", path);
  unlink(path);
  if (bind(listener, (const struct sockaddr*)&address, sizeof(address)) != 0 ||
      listen(listener, 1) != 0)
    fail("no socket can be made");
  printf("ready\n");
  fflush(stdout);
  const int connected = accept(listener, NULL, NULL);
  if (connected < 0 || fcntl(connected, F_SETFL, O_NONBLOCK) != 0)
    fail("QEMU does not connect");
  close(listener);
  return connected;
}

static struct usbredirparser* make_parser(usb_camera* camera) {
  struct usbredirparser* const parser = usbredirparser_create();
  if (!parser) fail("not enough memory");
  parser->priv = camera;
  parser->log_func = log_message;
  parser->read_func = read_socket;
  parser->write_func = write_socket;
  parser->hello_func = on_hello;
  parser->reset_func = on_reset;
  parser->set_configuration_func = on_set_configuration;
  parser->get_configuration_func = on_get_configuration;
  parser->set_alt_setting_func = on_set_alternate;
  parser->get_alt_setting_func = on_get_alternate;
  parser->cancel_data_packet_func = on_cancel;
  parser->control_packet_func = on_control;
  parser->bulk_packet_func = on_bulk;
  return parser;
}

static void say_hello(usb_camera* camera) {
  uint32_t abilities[USB_REDIR_CAPS_SIZE] = {0};
  usbredirparser_caps_set_cap(abilities, usb_redir_cap_connect_device_version);
  usbredirparser_caps_set_cap(abilities, usb_redir_cap_ep_info_max_packet_size);
  usbredirparser_caps_set_cap(abilities, usb_redir_cap_64bits_ids);
  usbredirparser_caps_set_cap(abilities, usb_redir_cap_32bits_bulk_length);
  usbredirparser_init(camera->parser, "raygrid", abilities, USB_REDIR_CAPS_SIZE,
                      usbredirparser_fl_usb_host);
}

/* Until QEMU has gone. */
static void serve(usb_camera* camera) {
  for (;;) {
    const int is_full = usbredirparser_has_data_to_write(camera->parser) > 0;
    struct pollfd ready = {camera->socket,
                           (short)(POLLIN | (is_full ? POLLOUT : 0)), 0};
    poll(&ready, 1, camera->num_reads > 0 ? 2 : 100);
    if ((ready.revents & (POLLIN | POLLHUP)) != 0 &&
        usbredirparser_do_read(camera->parser) != 0)
      return;
    send_frames(camera);
    if (usbredirparser_has_data_to_write(camera->parser) > 0 &&
        usbredirparser_do_write(camera->parser) != 0)
      return;
  }
}

int main(int argc, char** argv) {
  unsigned width = 0, height = 0, rate = 0;
  if ((argc != 5 && argc != 6) ||
      sscanf(argv[2], "%ux%u", &width, &height) != 2 ||
      sscanf(argv[3], "%u", &rate) != 1 || rate == 0)
    fail("usage: SOCKET WIDTHxHEIGHT FRAMES_PER_SECOND FILE [UNPLUG_AFTER]");
  static usb_camera camera;
  const unsigned interval = 10000000 / rate; /* 100 ns */
  const int is_jpeg = read_frames(&camera, argv[4], (size_t)width * height * 2);
  camera.configuration = make_configuration(is_jpeg, width, height, interval);
  camera.probe = make_probe(width, height, interval);
  memcpy(camera.controls, kControls, sizeof(kControls));
  camera.interval_s = 1.0 / rate;
  camera.unplug_after = argc == 6 ? atol(argv[5]) : 0;
  camera.socket = wait_for_qemu(argv[1]);
  camera.parser = make_parser(&camera);
  say_hello(&camera);
  serve(&camera);
  printf("%ld frames sent\n", camera.num_sent);
  for (int i = 0; i < camera.num_settings; ++i)
    printf("%s %u, exposure %u, focus %u\n", camera.settings[i].name,
           camera.settings[i].value, camera.settings[i].exposure,
           camera.settings[i].focus);
  usbredirparser_destroy(camera.parser);
  free(camera.frames);
  return 0;
}
