# How everything here is compiled. Nothing of it reaches a program that links the libraries.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release)
endif()
# No fast-math and no -march: results must not depend on contraction or on the machine compiled on.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
# Not in the cache, where project() has put an empty entry for a build type that CMake does not know.
set(CMAKE_CXX_FLAGS_RELWITHASSERTS "-O2 -g1")

# g++ 12 finds copies past the end in <string> where there are none, once the header is precompiled: these stay warnings.
# g++ collects its garbage only above half a gigabyte a process: a file takes up to 18 % less time and 20 % more memory, and the objects are the same.
# Nobody reads errno after sqrt: without it there is no branch, and answers are the same.
add_library(leeway_options INTERFACE)
target_compile_options(leeway_options INTERFACE -ffp-contract=off -fno-math-errno -Wall -Wextra -Wpedantic -Wshadow
  -Wconversion -Wsign-conversion -Wdouble-promotion -Wold-style-cast -Wnon-virtual-dtor
  $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=524288>
  $<$<BOOL:${LEEWAY_WERROR}>:-Werror>
  $<$<AND:$<BOOL:${LEEWAY_WERROR}>,$<CXX_COMPILER_ID:GNU>>:-Wno-error=array-bounds>)

if(NOT LEEWAY_SSE4 AND NOT LEEWAY_SANITIZE)
  # A switch of Highway's, which leaves a set of instructions out: see collision/base/targets.h.
  add_compile_options(-DHWY_BROKEN_TARGETS=HWY_SSE4)
endif()
if(LEEWAY_SANITIZE)
  # -O0 takes the place of the build type's: with a sanitizer's checks in the code -O1 takes half as long again to compile tests, and eight times as
  # long code for every instruction set. (What tests ask of libraries is worth it.) Tests that are dear then ask fewer cases (tests/support/sanitized.h).
  # g++ takes variables for uninitialized that are not, once a sanitizer's checks stand between (its manual says so).
  add_compile_options(-O0 -fsanitize=${LEEWAY_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -Wno-maybe-uninitialized)
  add_link_options(-fsanitize=${LEEWAY_SANITIZE})
  if(NOT LEEWAY_SANITIZE_THOROUGHLY)
    add_compile_options(-fno-sanitize=null,alignment -DHWY_BROKEN_TARGETS=HWY_AVX2)
  endif()
  set(leeway_library_options -O1)
endif()

option(LEEWAY_USE_CCACHE "Compile through ccache where there is one" ${PROJECT_IS_TOP_LEVEL})
find_program(LEEWAY_CCACHE ccache)
if(LEEWAY_CCACHE AND LEEWAY_USE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # What ccache must overlook to store files that begin with precompiled headers.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${LEEWAY_CCACHE})
endif()
