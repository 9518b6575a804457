#include "tools/lab/base/rivals.h"

#include <dlfcn.h>

#include <array>
#include <system_error>

namespace leeway::tools::report {
namespace {

struct Known {
  const char* library;
  const char* file;
  const char* packages;  ///< Debian's packages
  /// Its library's own symbols take precedence, because Debian's KDL and OMPL were built with
  /// versions of Eigen whose JacobiSVD differs but has the same name.
  bool own_symbols_first = false;
};

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kCanPreferOwnSymbols = false;  // the sanitizer rejects such modules
#else
constexpr bool kCanPreferOwnSymbols = true;
#endif

constexpr std::array<Known, 6> kModules = {
    {{"FCL", "leeway_rival_fcl.so", "libfcl-dev libccd-dev"},
     {"Bullet", "leeway_rival_bullet.so", "libbullet-dev"},
     {"Embree", "leeway_rival_embree.so", "libembree-dev"},
     {"KDL", "leeway_rival_kdl.so", "liborocos-kdl-dev", true},
     {"NLopt", "leeway_rival_nlopt.so", "libnlopt-cxx-dev"},
     {"nanoflann", "leeway_rival_nanoflann.so", "libnanoflann-dev"}}};

RivalModule load(const Known& known, const std::filesystem::path& folder) {
  RivalModule module{known.library, "", nullptr};
  const std::filesystem::path file = folder / known.file;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    module.problem = "no " + file.string() + "; built with the target `reports` where " +
                     known.packages + " is installed (tools/setup)";
    return module;
  }
  if (known.own_symbols_first && !kCanPreferOwnSymbols) {
    module.problem = "left out under AddressSanitizer";
    return module;
  }
  void* const handle =
      dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | (known.own_symbols_first ? RTLD_DEEPBIND : 0));
  if (handle == nullptr) {
    const char* const reason = dlerror();
    module.problem = reason != nullptr ? reason : "cannot be loaded";
    return module;
  }
  void* const symbol = dlsym(handle, kMakeRivals);
  if (symbol == nullptr) {
    module.problem = file.string() + " is of another version";
    return module;
  }
  module.rivals.reset(reinterpret_cast<MakeRivals>(symbol)());
  return module;
}

}  // namespace

std::filesystem::path moduleFolder() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  return program.parent_path().parent_path() / LEEWAY_MODULE_FOLDER;
}

std::vector<RivalModule> loadRivals() {
  std::vector<RivalModule> modules;
  modules.reserve(std::size(kModules));
  for (const Known& known : kModules) modules.push_back(load(known, moduleFolder()));
  return modules;
}

}  // namespace leeway::tools::report
