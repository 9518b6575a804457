# cmake -DROOT=... -DVERSION=... -DOUTPUT=... -P fingerprint.cmake: defines kFingerprint of robots/cache/fingerprint.h.
file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/collision/*.h ${ROOT}/collision/*.cc ${ROOT}/robots/*.h ${ROOT}/robots/*.cc
  ${ROOT}/tools/cmake/compile_options.cmake)
list(SORT sources)
set(digests ${VERSION})
foreach(source ${sources})
  file(SHA256 ${ROOT}/${source} digest)
  string(APPEND digests " ${source} ${digest}")
endforeach()
string(SHA256 fingerprint "${digests}")
file(WRITE ${OUTPUT} "#include \"robots/cache/fingerprint.h\"

namespace leeway::robots {

const char* const kFingerprint = \"${fingerprint}\";

}  // namespace leeway::robots
")
