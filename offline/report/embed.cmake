# Writes OUTPUT, a C++ file with the page's files as strings:
#   cmake -DOUTPUT=FILE -DSTYLE=FILE -DSCRIPT=FILE -DLIBRARY=FILE -P embed.cmake
function(append_text name file)
  file(READ ${file} text)
  file(APPEND ${OUTPUT} "const char ${name}[] = R\"RAYGRID(${text})RAYGRID\";\n")
endfunction()

file(WRITE ${OUTPUT} "#include \"report/page_files.h\"\n\nnamespace raygrid {\n")
append_text(kReportStyle ${STYLE})
append_text(kReportScript ${SCRIPT})
append_text(kChartLibrary ${LIBRARY})
file(APPEND ${OUTPUT} "}  // namespace raygrid\n")
