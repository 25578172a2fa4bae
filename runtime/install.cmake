# find_package(raygrid) with the target raygrid::runtime, pkg-config raygrid, the
# shared library and the Python module. Component runtime.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/raygrid)

install(TARGETS raygrid_runtime raygrid_formats EXPORT raygrid COMPONENT runtime)
install(TARGETS raygrid_shared COMPONENT runtime)
install(FILES raygrid.h ${PROJECT_SOURCE_DIR}/formats/rg_projection.h
  ${PROJECT_SOURCE_DIR}/formats/rg_status.h
  DESTINATION include/raygrid COMPONENT runtime)
install(FILES python/raygrid.py DESTINATION share/raygrid/python COMPONENT runtime)
install(EXPORT raygrid NAMESPACE raygrid:: FILE raygrid-config.cmake
  DESTINATION ${package_dir} COMPONENT runtime)
write_basic_package_version_file(
  ${CMAKE_CURRENT_BINARY_DIR}/raygrid-config-version.cmake COMPATIBILITY SameMinorVersion)
file(RELATIVE_PATH from_pc_to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(raygrid.pc.in raygrid.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/raygrid-config-version.cmake
  DESTINATION ${package_dir} COMPONENT runtime)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/raygrid.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT runtime)
install(DIRECTORY examples/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples/runtime COMPONENT examples)
