# QEMU's only Cortex-M0 board has 16 KiB of RAM, so the Armv6-M code runs on a
# Cortex-M3, whose instruction set contains it.
include(${CMAKE_CURRENT_LIST_DIR}/bare_metal.cmake)
set(CMAKE_SYSTEM_PROCESSOR cortex-m0plus)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
raygrid_bare_metal("-mcpu=cortex-m0plus" 0x0 0x400000 0x20000000 0x400000)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-system-arm;-M;mps2-an385;${RAYGRID_SEMIHOSTING})
