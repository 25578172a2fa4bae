/* Start and system calls of programs for Xtensa in QEMU's machine "sim", whose
 * picolibc has neither: standard streams, files and arguments by SIMCALL. */
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum {
  SIM_EXIT = 1,
  SIM_READ = 3,
  SIM_WRITE = 4,
  SIM_OPEN = 5,
  SIM_CLOSE = 6,
  SIM_SEEK = 19,
  SIM_NUM_ARGUMENTS = 1000,
  SIM_ARGUMENT_BYTES = 1001,
  SIM_ARGUMENTS = 1002
};

static int call_sim(int call, int a, int b, int c) {
  register int number __asm__("a2") = call;
  register int first __asm__("a3") = a;
  register int second __asm__("a4") = b;
  register int third __asm__("a5") = c;
  __asm__ volatile("simcall"
                   : "+r"(number), "+r"(first)
                   : "r"(second), "r"(third)
                   : "memory");
  return number;
}

void _exit(int code) {
  for (;;) call_sim(SIM_EXIT, code, 0, 0);
}

int getpid(void) { return 1; }

int kill(int process, int signal) {
  (void)process;
  _exit(128 + signal);
}

ssize_t read(int file, void* bytes, size_t size) {
  return call_sim(SIM_READ, file, (int)bytes, (int)size);
}

ssize_t write(int file, const void* bytes, size_t size) {
  return call_sim(SIM_WRITE, file, (int)bytes, (int)size);
}

/* The flags of Linux. */
int open(const char* path, int flags, ...) {
  int linux_flags = flags & O_ACCMODE;
  if (flags & O_CREAT) linux_flags |= 0100;
  if (flags & O_TRUNC) linux_flags |= 01000;
  if (flags & O_APPEND) linux_flags |= 02000;
  return call_sim(SIM_OPEN, (int)path, linux_flags, 0666);
}

int close(int file) { return call_sim(SIM_CLOSE, file, 0, 0); }

off_t lseek(int file, off_t offset, int whence) {
  return call_sim(SIM_SEEK, file, (int)offset, whence);
}

int unlink(const char* path) {
  (void)path;
  return -1; /* there is no such call */
}

static int put_to(int file, char c) {
  return write(file, &c, 1) == 1 ? (unsigned char)c : EOF;
}

static int put_out(char c, FILE* stream) {
  (void)stream;
  return put_to(1, c);
}

static int put_error(char c, FILE* stream) {
  (void)stream;
  return put_to(2, c);
}

static int get_input(FILE* stream) {
  unsigned char c;
  (void)stream;
  return read(0, &c, 1) == 1 ? c : EOF;
}

static FILE input = FDEV_SETUP_STREAM(NULL, get_input, NULL, _FDEV_SETUP_READ);
static FILE output = FDEV_SETUP_STREAM(put_out, NULL, NULL, _FDEV_SETUP_WRITE);
static FILE errors =
    FDEV_SETUP_STREAM(put_error, NULL, NULL, _FDEV_SETUP_WRITE);
FILE* const stdin = &input;
FILE* const stdout = &output;
FILE* const stderr = &errors;

int main(int argc, char** argv);
void __libc_init_array(void);
void exit(int code);
extern char __bss_start[], __bss_end[];

__attribute__((used)) static void run_main(void) {
  /* A name, pointers, and the texts behind them. */
  static char* arguments[64] = {"program"};
  memset(__bss_start, 0, (size_t)(__bss_end - __bss_start));
  __libc_init_array();
  int count = call_sim(SIM_NUM_ARGUMENTS, 0, 0, 0);
  if (call_sim(SIM_ARGUMENT_BYTES, 0, 0, 0) > (int)sizeof(arguments) - 4)
    _exit(126);
  if (count > 0) call_sim(SIM_ARGUMENTS, (int)(arguments + 1), 0, 0);
  exit(main(count + 1, arguments));
}

/* The core begins in its ROM, and finds the stack, and vectors that end the
 * machine where a program faults. */
__asm__(
    ".section .reset, \"ax\"\n"
    ".global start_in_sim\n"
    "start_in_sim:\n"
    "  j begin\n"
    "  .balign 4\n"
    "address_of_vectors: .word vectors\n"
    "address_of_stack: .word __stack\n"
    "address_of_main: .word run_main\n"
    "begin:\n"
    "  l32r a2, address_of_vectors\n"
    "  wsr a2, vecbase\n"
    "  l32r a1, address_of_stack\n"
    "  l32r a2, address_of_main\n"
    "  jx a2\n"
    ".section .vectors, \"ax\"\n"
    ".balign 1024\n"
    "vectors:\n"
    ".rept 32\n"
    "  .balign 16\n"
    "  movi a2, 1\n"
    "  movi a3, 139\n"
    "  simcall\n"
    ".endr\n");
