# A module of USER_C_MODULES, for ports that are built by CMake.
add_library(usermod_raygrid INTERFACE)
target_sources(usermod_raygrid INTERFACE
  ${CMAKE_CURRENT_LIST_DIR}/modraygrid.c
  ${CMAKE_CURRENT_LIST_DIR}/raygrid.c)
target_include_directories(usermod_raygrid INTERFACE ${CMAKE_CURRENT_LIST_DIR})
target_link_libraries(usermod INTERFACE usermod_raygrid)
