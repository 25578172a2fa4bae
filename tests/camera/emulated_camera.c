/* A USB camera that is not there: UVC 1.0, YUYV frames or JPEGs of a file again
 * and again over a bulk endpoint, for QEMU's usb-redir on a unix socket.
 *
 *   emulated_camera SOCKET WIDTHxHEIGHT FRAMES_PER_SECOND FILE [UNPLUG_AFTER]
 *
 * For the FILE "-" it plays the newest YUYV picture of standard input, whose
 * orders emulated_frames.h has. It focuses, exposes and balances white by
 * itself until controls end that. It ends when QEMU does, tells how its
 * controls were set, and unplugs itself after UNPLUG_AFTER frames. */
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

#include "emulated_controls.h"
#include "emulated_descriptors.h"
#include "emulated_frames.h"

enum { PAYLOAD_HEADER = 2, MAX_READS = 256 };

/* ---- State --------------------------------------------------------------- */

typedef struct usb_camera {
  struct usbredirparser* parser;
  int socket;
  bytes configuration, probe;
  played_frames frames;
  live_orders orders;
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

  usb_controls controls;
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

static void plug_in(usb_camera* camera) {
  struct usbredirparser* const parser = camera->parser;
  reset_controls(&camera->controls);
  camera->configured = 0;
  camera->is_unplugged = 0;
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

static void on_hello(void* state, struct usb_redir_hello_header* hello) {
  (void)hello;
  plug_in((usb_camera*)state);
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

static int answer_control(usb_camera* camera,
                          const struct usb_redir_control_packet_header* packet,
                          const uint8_t* data, int size, bytes* answer) {
  enum { GET_STATUS = 0, CLEAR_FEATURE = 1, GET_DESCRIPTOR = 6 };
  const unsigned interface = packet->index & 255;
  const unsigned selector = packet->value >> 8; /* 1: probe, 2: commit */
  usb_control* const control = find_control(&camera->controls, packet->index,
                                            packet->value, camera->num_sent);
  switch (packet->requesttype) {
    case 0x80:
      if (packet->request == GET_DESCRIPTOR)
        return answer_descriptor(camera, packet->value, answer);
      if (packet->request == GET_STATUS) add16(answer, 0);
      return packet->request == GET_STATUS;
    case 0xa1:
      if (interface == CONTROL_INTERFACE)
        return get_control(control, packet->request, answer);
      if (interface != STREAM_INTERFACE || selector < 1 || selector > 2)
        return 0;
      return answer_stream(camera, packet->request, answer);
    case 0x21: /* what is set is what there is */
      if (interface == STREAM_INTERFACE && selector == 2) forget_reads(camera);
      if (interface == CONTROL_INTERFACE)
        set_control(&camera->controls, control, data, size);
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
  const size_t index = (size_t)camera->num_sent % camera->frames.num_frames;
  const size_t frame_size =
      camera->frames.starts[index + 1] - camera->frames.starts[index];
  const size_t left = frame_size - camera->sent;
  if (part > left) part = left;
  memcpy(payload + PAYLOAD_HEADER,
         camera->frames.bytes + camera->frames.starts[index] + camera->sent,
         part);
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
  forget_reads(camera);
}

/* A frame is of one picture. */
static void follow_orders(usb_camera* camera) {
  for (;;) {
    read_orders(&camera->orders);
    const int order = whole_order(&camera->orders);
    if (order == 0 || (order == ORDER_PICTURE && camera->sent > 0)) return;
    if (order == ORDER_UNPLUG) unplug(camera);
    if (order == ORDER_PLUG) plug_in(camera);
    end_order(&camera->orders, &camera->frames);
  }
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

/* Waits until something is to be done. An order that waits for the frame's end
 * is no reason. */
static short wait_for_work(const usb_camera* camera) {
  const int is_full = usbredirparser_has_data_to_write(camera->parser) > 0;
  const int takes_orders =
      camera->orders.is_open && whole_order(&camera->orders) == 0;
  struct pollfd ready[2] = {
      {camera->socket, (short)(POLLIN | (is_full ? POLLOUT : 0)), 0},
      {STDIN_FILENO, POLLIN, 0}};
  poll(ready, takes_orders ? 2 : 1, camera->num_reads > 0 ? 2 : 100);
  return ready[0].revents;
}

/* Until QEMU has gone. */
static void serve(usb_camera* camera) {
  for (;;) {
    const short events = wait_for_work(camera);
    if ((events & (POLLIN | POLLHUP)) != 0 &&
        usbredirparser_do_read(camera->parser) != 0)
      return;
    if (camera->orders.is_open) follow_orders(camera);
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
  const size_t frame_size = (size_t)width * height * 2;
  const int is_live = strcmp(argv[4], "-") == 0;
  if (is_live) open_orders(&camera.orders, &camera.frames, frame_size);
  const int is_jpeg =
      !is_live && read_frames(&camera.frames, argv[4], frame_size);
  camera.configuration = make_configuration(is_jpeg, width, height, interval);
  camera.probe = make_probe(width, height, interval);
  camera.interval_s = 1.0 / rate;
  camera.unplug_after = argc == 6 ? atol(argv[5]) : 0;
  camera.socket = wait_for_qemu(argv[1]);
  camera.parser = make_parser(&camera);
  say_hello(&camera);
  serve(&camera);
  printf("%ld frames sent\n", camera.num_sent);
  print_settings(&camera.controls);
  usbredirparser_destroy(camera.parser);
  free(camera.frames.bytes);
  free(camera.orders.bytes);
  return 0;
}
