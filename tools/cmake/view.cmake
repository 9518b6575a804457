# leeway_bundle_page(SOURCE): makes the page of `leeway view` (tools/view/page/) and has SOURCE include it. Needs node 18 and npm, which fetches the
# packages of tools/view/page/package-lock.json once, at configuration. Without them, and where that fails, everything else is built, and the library
# says what is missing. LEEWAY_VIEW=OFF leaves the page out; builds with sanitizers have no page.
option(LEEWAY_VIEW "Build the page of leeway view where node and npm are there" ON)

function(leeway_bundle_page source)
  if(NOT LEEWAY_VIEW OR LEEWAY_SANITIZE)
    return()
  endif()
  set(missing "tools/setup --view installs node and npm: the page of leeway view is not built")
  find_program(LEEWAY_NODE NAMES node nodejs)
  find_program(LEEWAY_NPM npm)
  mark_as_advanced(LEEWAY_NODE LEEWAY_NPM)
  if(NOT LEEWAY_NODE OR NOT LEEWAY_NPM)
    message(STATUS "${missing}")
    return()
  endif()
  execute_process(COMMAND ${LEEWAY_NODE} -p process.versions.node OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT version VERSION_GREATER_EQUAL 18)
    message(STATUS "node ${version} is too old; 18 is needed. ${missing}")
    return()
  endif()

  set(sources ${PROJECT_SOURCE_DIR}/tools/view/page)
  set(folder ${PROJECT_BINARY_DIR}/view)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${sources}/package.json ${sources}/package-lock.json)
  file(SHA256 ${sources}/package-lock.json wanted)
  set(installed "")
  if(EXISTS ${folder}/installed)
    file(READ ${folder}/installed installed)
  endif()
  if(NOT installed STREQUAL wanted)
    file(REMOVE_RECURSE ${folder})
    file(COPY ${sources}/package.json ${sources}/package-lock.json DESTINATION ${folder})
    # Scripts of packages are not run: none is needed.
    execute_process(COMMAND ${LEEWAY_NPM} ci --ignore-scripts --no-audit --no-fund WORKING_DIRECTORY ${folder} TIMEOUT 300
      RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE error)
    if(failed)
      message(WARNING "npm ci failed, so the page of leeway view is not built; the next configuration tries again:\n${error}")
      return()
    endif()
    file(WRITE ${folder}/installed ${wanted})
  endif()

  file(GLOB inputs CONFIGURE_DEPENDS ${sources}/*.js ${sources}/*.css ${sources}/*.html)
  add_custom_command(OUTPUT ${folder}/page.html COMMAND ${LEEWAY_NODE} ${sources}/bundle.js ${folder} ${folder}/page.html
    DEPENDS ${inputs} ${folder}/installed COMMENT "Bundling the page of leeway view" VERBATIM)
  set_source_files_properties(${source} PROPERTIES COMPILE_DEFINITIONS LEEWAY_PAGE="${folder}/page.html"
    OBJECT_DEPENDS ${folder}/page.html)
endfunction()
