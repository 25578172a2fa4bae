# Writes OUTPUT, a C++ file with the page's files as strings:
#   cmake -DOUTPUT=FILE -DSTYLE=FILE -DSCRIPT=FILE -DLIBRARY=FILE -DTRIAL=FILE
#     -DRUNTIME=FOLDER -P embed.cmake
function(append_string name text)
  file(APPEND ${OUTPUT} "const char ${name}[] = R\"RAYGRID(${text})RAYGRID\";\n")
endfunction()
function(append_text name file)
  file(READ ${file} text)
  append_string(${name} "${text}")
endfunction()

# The text of a module of the npm package, as an expression of a function that
# returns the names.
function(read_module file names variable)
  file(READ ${file} text)
  string(REGEX REPLACE "(^|\n)import [^\n]*" "" text "${text}")
  string(REGEX REPLACE "(^|\n)export " "\\1" text "${text}")
  set(${variable} "const {${names}} = (() => {\n${text}\nreturn {${names}};\n})();\n" PARENT_SCOPE)
endfunction()

file(WRITE ${OUTPUT} "#include \"report/page_files.h\"\n\nnamespace raygrid {\n")
append_text(kReportStyle ${STYLE})
append_text(kReportScript ${SCRIPT})
append_text(kChartLibrary ${LIBRARY})
read_module(${RUNTIME}/raygrid_wasm.js "WASM" module)
read_module(${RUNTIME}/view_table.js "addTable, directionOf" tables)
read_module(${RUNTIME}/raygrid.js "Camera, PROJECTIONS, load, makeView, viewDirection" runtime)
append_string(kRuntimeLibrary "${module}${tables}${runtime}")
append_text(kTrialScript ${TRIAL})
file(APPEND ${OUTPUT} "}  // namespace raygrid\n")
