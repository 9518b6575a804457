# Most of a file's time goes to the templates of others that it uses (CLI11, nlohmann-json, std::function). The files of a folder are compiled together:
# a third of their time (planner/search: 12 s for 34), but a change of one file takes longer. The debug preset, for changes, compiles each file alone; so
# does the tidy preset, which finds what a file forgets to include. The files of a folder share one anonymous namespace, so a name
# stands for one thing in it. Where a file cannot be changed so, it is compiled alone.
option(LEEWAY_UNITY "Compile the files of a folder together" ${PROJECT_IS_TOP_LEVEL})

# leeway_unite(TARGET FILES...), in the folder that makes TARGET: FILES are compiled alone; so are files with options of their own (set before), those for
# every instruction set (_simd.cc), and those that the build writes.
function(leeway_unite target)
  if(NOT LEEWAY_UNITY)
    return()
  endif()
  set(folders)
  list(TRANSFORM ARGN PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE alone)
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    get_filename_component(source ${source} ABSOLUTE)
    cmake_path(IS_PREFIX CMAKE_CURRENT_BINARY_DIR "${source}" is_built)
    get_source_file_property(options ${source} COMPILE_OPTIONS)
    get_source_file_property(definitions ${source} COMPILE_DEFINITIONS)
    if(options OR definitions OR is_built OR source IN_LIST alone OR source MATCHES "_simd\\.cc$")
      continue()
    endif()
    get_filename_component(folder ${source} DIRECTORY)
    cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    string(MAKE_C_IDENTIFIER "${folder}" folder)
    list(APPEND folders ${folder})
    list(APPEND files_of_${folder} ${source})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder ${folders})
    list(LENGTH files_of_${folder} count)
    if(count EQUAL 1)
      continue()
    endif()
    set_source_files_properties(${files_of_${folder}} PROPERTIES UNITY_GROUP ${folder})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()
