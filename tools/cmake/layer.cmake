# leeway_add_layer(NAME PUBLIC libraries... PRIVATE libraries...): the library leeway::NAME from this folder, its public headers in
# include/leeway/NAME, its private ones beside their sources.
function(leeway_add_layer name)
  cmake_parse_arguments(arg "" "" "PUBLIC;PRIVATE;PRECOMPILE" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS *.cc)
  file(GLOB headers CONFIGURE_DEPENDS include/leeway/${name}/*.h)
  add_library(leeway_${name} ${sources})
  add_library(leeway::${name} ALIAS leeway_${name})
  target_sources(leeway_${name} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${headers})
  target_include_directories(leeway_${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_features(leeway_${name} PUBLIC cxx_std_20)
  target_link_libraries(leeway_${name} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE} $<BUILD_INTERFACE:leeway_options>)
  target_compile_options(leeway_${name} PRIVATE ${leeway_library_options})
  # collision/ reads no files, and code for every instruction set takes long to compile with coverage.
  if(LEEWAY_FUZZ AND NOT name STREQUAL collision)
    target_compile_options(leeway_${name} PRIVATE -O1 -fsanitize=fuzzer-no-link,address)
    target_link_options(leeway_${name} INTERFACE -fsanitize=address)
  endif()
  leeway_precompile(leeway_${name} ${arg_PRECOMPILE})
  if(BUILD_SHARED_LIBS)
    # Objects are those of static libraries; what leaves the library is the linker's to choose.
    set(exports ${PROJECT_SOURCE_DIR}/tools/cmake/exports.map)
    target_link_options(leeway_${name} PRIVATE -Wl,--version-script=${exports} -Wl,--no-undefined)
    set_target_properties(leeway_${name} PROPERTIES DEFINE_SYMBOL "" LINK_DEPENDS ${exports})
  endif()
  set_target_properties(leeway_${name} PROPERTIES EXPORT_NAME ${name} VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
endfunction()
