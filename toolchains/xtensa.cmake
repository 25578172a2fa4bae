# The core of the ESP8266, whose compiler Debian has. It multiplies 32 bits by 32 to 32,
# and does not divide. Its picolibc comes without a start; toolchains/xtensa/ has one.
include(${CMAKE_CURRENT_LIST_DIR}/bare_metal.cmake)
set(CMAKE_SYSTEM_PROCESSOR xtensa)
set(CMAKE_C_COMPILER xtensa-lx106-elf-gcc)
set(CMAKE_C_FLAGS_INIT
  "-DPICOLIBC_INTEGER_PRINTF_SCANF --specs=/usr/lib/xtensa-lx106-elf/picolibc.specs -ffunction-sections -fdata-sections")
set(CMAKE_EXE_LINKER_FLAGS_INIT
  "-nostartfiles -T${CMAKE_CURRENT_LIST_DIR}/xtensa/sim.ld -Wl,-u,start_in_sim,-u,__udivsi3,-u,kill -Wl,--gc-sections")
set(CMAKE_C_STANDARD_LIBRARIES_INIT "-Wl,--no-warn-rwx-segments -Wl,--start-group -lc -lgcc -Wl,--end-group")
set(RAYGRID_START_SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/xtensa/start.c ${CMAKE_CURRENT_LIST_DIR}/xtensa/arithmetic.c)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-system-xtensa;-M;sim;-cpu;lx106;${RAYGRID_SEMIHOSTING})
