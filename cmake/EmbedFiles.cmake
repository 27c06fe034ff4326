# Text files as constants of the program. As a script (cmake -P) it writes the .cpp file: OUTPUT, HEADER, NAMESPACE and
# ENTRIES, a list of name=path.
if(CMAKE_SCRIPT_MODE_FILE)
  file(WRITE "${OUTPUT}" "// Made by the build from files.\n#include \"${HEADER}\"\n\nnamespace ${NAMESPACE} {\n\n")
  foreach(entry IN LISTS ENTRIES)
    string(REGEX MATCH "^([a-z0-9_]+)=(.*)$" matched "${entry}")
    set(name "${CMAKE_MATCH_1}")
    file(READ "${CMAKE_MATCH_2}" text)
    string(FIND "${text}" "</script" ends_script)
    string(FIND "${text}" ")rigcal_file\"" ends_literal)
    if(NOT ends_script EQUAL -1 OR NOT ends_literal EQUAL -1)
      message(FATAL_ERROR "${CMAKE_MATCH_2} holds what would end the element or the constant that it is put into")
    endif()
    file(APPEND "${OUTPUT}" "const std::string_view ${name} = R\"rigcal_file(")
    file(APPEND "${OUTPUT}" "${text}")
    file(APPEND "${OUTPUT}" ")rigcal_file\";\n\n")
  endforeach()
  file(APPEND "${OUTPUT}" "}  // namespace ${NAMESPACE}\n")
  return()
endif()

# rigcal_embed_files(page_files.cpp HEADER core/x/resources.h NAMESPACE rigcal::x ENTRIES name=path ...)
# The header declares `extern const std::string_view name;` for each. `output` is a file of the build folder.
function(rigcal_embed_files output)
  cmake_parse_arguments(ARG "" "HEADER;NAMESPACE" "ENTRIES" ${ARGN})
  set(files)
  foreach(entry IN LISTS ARG_ENTRIES)
    string(REGEX REPLACE "^[a-z0-9_]+=" "" file "${entry}")
    list(APPEND files "${file}")
  endforeach()
  set(script "${CMAKE_SOURCE_DIR}/cmake/EmbedFiles.cmake")
  add_custom_command(OUTPUT "${output}"
    COMMAND "${CMAKE_COMMAND}" "-DOUTPUT=${output}" "-DHEADER=${ARG_HEADER}" "-DNAMESPACE=${ARG_NAMESPACE}"
            "-DENTRIES=${ARG_ENTRIES}" -P "${script}"
    DEPENDS ${files} "${script}" COMMENT "Embedding files" VERBATIM)
endfunction()
