include(${CMAKE_CURRENT_LIST_DIR}/riscv64.cmake)
set(CMAKE_C_FLAGS_INIT "-march=rv64gcv")
set(CMAKE_CROSSCOMPILING_EMULATOR
  qemu-riscv64;-cpu;rv64,v=true,vlen=128,vext_spec=v1.0;-L;/usr/riscv64-linux-gnu)
