#include "planner/space/ompl_lock.h"

#include <ompl/util/Console.h>

namespace leeway::planner {
namespace {

struct Console {
  std::mutex mutex;
  int users = 0;
  ompl::msg::OutputHandler* previous = nullptr;
};

Console& console() {
  static Console instance;
  return instance;
}

}  // namespace

std::recursive_mutex& omplSeedLock() {
  static std::recursive_mutex instance;
  return instance;
}

QuietOmpl::QuietOmpl() {
  Console& c = console();
  const std::lock_guard<std::mutex> lock(c.mutex);
  if (c.users++ > 0) return;
  c.previous = ompl::msg::getOutputHandler();
  ompl::msg::noOutputHandler();
}

QuietOmpl::~QuietOmpl() {
  Console& c = console();
  const std::lock_guard<std::mutex> lock(c.mutex);
  if (--c.users == 0) ompl::msg::useOutputHandler(c.previous);
}

}  // namespace leeway::planner
