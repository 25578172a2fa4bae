# Installs a command, and the pages that are made of its help, as one component.
function(raygrid_install_command target component)
  if(NOT RAYGRID_INSTALLS)
    return()
  endif()
  install(TARGETS ${target} COMPONENT ${component})
  if(NOT RAYGRID_HAS_PAGES)
    return()
  endif()
  set(script ${PROJECT_SOURCE_DIR}/tools/command_pages)
  set(pages ${PROJECT_BINARY_DIR}/pages/${target})
  add_custom_command(OUTPUT ${pages}/complete
    COMMAND ${Python3_EXECUTABLE} -B ${script} --version ${PROJECT_VERSION} -o ${pages}
      ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:${target}>
    DEPENDS ${target} ${script}
    VERBATIM)
  add_custom_target(${target}-pages ALL DEPENDS ${pages}/complete)
  # A build of the program's target alone has no pages.
  install(DIRECTORY ${pages}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT ${component} OPTIONAL)
  install(DIRECTORY ${pages}/bash/ DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
    COMPONENT ${component} OPTIONAL)
  install(DIRECTORY ${pages}/zsh/ DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions
    COMPONENT ${component} OPTIONAL)
endfunction()
