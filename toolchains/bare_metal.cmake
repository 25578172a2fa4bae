# What the bare-metal targets share: picolibc's start-up code and linker script,
# semihosting for output and files, the memories of QEMU's boards.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
function(raygrid_bare_metal cpu_flags flash flash_size ram ram_size)
  set(CMAKE_C_FLAGS_INIT
    "${cpu_flags} --specs=picolibc.specs -ffunction-sections -fdata-sections" PARENT_SCOPE)
  set(link "--oslib=semihost --crt0=semihost -Wl,--gc-sections")
  foreach(symbol flash=${flash} flash_size=${flash_size} ram=${ram} ram_size=${ram_size} stack_size=8192)
    string(APPEND link " -Wl,--defsym=__${symbol}")
  endforeach()
  set(CMAKE_EXE_LINKER_FLAGS_INIT "${link}" PARENT_SCOPE)
endfunction()
set(RAYGRID_SEMIHOSTING -nographic;-monitor;none;-serial;none;-semihosting-config;enable=on,target=native;-kernel)
