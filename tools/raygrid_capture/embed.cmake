# Writes OUTPUT, a C++ file with the files of PAGE as strings:
#   cmake -DOUTPUT=FILE -DPAGE=FOLDER -P embed.cmake
file(WRITE ${OUTPUT} "#include \"page_files.h\"\n\nnamespace raygrid {\n")
foreach(entry kCaptureHtml:html kCaptureStyle:css kCaptureScript:js)
  string(REPLACE ":" ";" entry "${entry}")
  list(GET entry 0 name)
  list(GET entry 1 type)
  file(READ ${PAGE}/capture.${type} text)
  file(APPEND ${OUTPUT} "const char ${name}[] = R\"RAYGRID(${text})RAYGRID\";\n")
endforeach()
file(APPEND ${OUTPUT} "}  // namespace raygrid\n")
