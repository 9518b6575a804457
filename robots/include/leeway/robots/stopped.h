#pragma once

#include <functional>
#include <stdexcept>
#include <string>

namespace leeway::robots {

/// Asked now and then by what takes long, from the thread that called it: true ends it.
using Stop = std::function<bool()>;

/// Reading or compiling ended because its caller's Stop said so. Nothing is wrong with the input,
/// and nothing of it is half-loaded.
class Stopped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws Stopped where `stop` is set and says so. `what` was under way.
inline void throwIfStopped(const Stop& stop, const char* what) {
  if (stop && stop()) throw Stopped(std::string("stopped while ") + what);
}

}  // namespace leeway::robots
