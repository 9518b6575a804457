# Headers of others, parsed once instead of once a file: parsing Eigen takes longer than compiling most of our files. Our own headers stay out, so that
# a change of one compiles only what includes it. Every file still includes what it uses: the tidy preset has no precompiled headers
# (CMAKE_DISABLE_PRECOMPILE_HEADERS) and finds what is missing.
set(leeway_common_headers <algorithm> <array> <bit> <cmath> <cstddef> <cstdint> <functional> <limits> <memory> <numeric> <optional> <span>
  <string> <string_view> <utility> <vector> <Eigen/Core>)

# leeway_precompile(TARGET [HEADERS...] [LIBRARIES...]): TARGET's files begin with the common headers and HEADERS, which LIBRARIES provide. Without HEADERS
# all libraries share one set. (Programs cannot: they are compiled with -fPIE.)
function(leeway_precompile target)
  if(ARGN)
    target_precompile_headers(${target} PRIVATE ${leeway_common_headers} ${ARGN})
    return()
  endif()
  if(NOT TARGET leeway_common_headers)
    file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/common_headers.cc CONTENT "")
    add_library(leeway_common_headers OBJECT ${PROJECT_BINARY_DIR}/common_headers.cc)
    target_link_libraries(leeway_common_headers PRIVATE Eigen3::Eigen leeway_options)
    target_compile_features(leeway_common_headers PUBLIC cxx_std_20)
    target_compile_options(leeway_common_headers PRIVATE ${leeway_library_options})  # as libraries
    target_precompile_headers(leeway_common_headers PRIVATE ${leeway_common_headers})
  endif()
  target_precompile_headers(${target} REUSE_FROM leeway_common_headers)
endfunction()
