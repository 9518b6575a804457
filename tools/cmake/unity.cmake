# Most of a file's time goes to the templates of others that it uses (CLI11, nlohmann-json, std::function). The files of a folder are compiled together,
# up to eight at once: a whole build takes half the time, a change of one file longer. The debug preset, for changes, compiles each file alone; so does
# the clang preset, which finds what a file forgets to include. A folder's files share one anonymous namespace, so its names are unique in the folder.
option(LEEWAY_UNITY "Compile the files of a folder together" ${PROJECT_IS_TOP_LEVEL})

# leeway_unite(TARGET FILES...): FILES are compiled alone, and so is each file with options of its own (set before).
function(leeway_unite target)
  if(NOT LEEWAY_UNITY)
    return()
  endif()
  list(TRANSFORM ARGN PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE alone)
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    get_filename_component(source ${source} ABSOLUTE)
    get_filename_component(folder ${source} DIRECTORY)
    get_source_file_property(options ${source} COMPILE_OPTIONS)
    get_source_file_property(definitions ${source} COMPILE_DEFINITIONS)
    if(options OR definitions OR source IN_LIST alone OR source MATCHES "_simd\\.cc$" OR source MATCHES "^${CMAKE_CURRENT_BINARY_DIR}/")
      continue()
    endif()
    string(MAKE_C_IDENTIFIER "${folder}" name)
    math(EXPR ${name}_count "${${name}_count} + 1")
    math(EXPR group "(${${name}_count} - 1) / 8")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${name}_${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
