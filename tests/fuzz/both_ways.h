#pragma once

#include <string>

#include "leeway/robots/input_error.h"
#include "tests/fuzz/shapes.h"

namespace leeway::fuzz {

/// load(null), which throws what it throws. Fails unless load(&errors), which goes on after errors,
/// begins with the same one.
template <class Load>
auto loadBothWays(const Load& load) {
  robots::InputErrors errors;
  try {
    load(&errors);
    if (!errors.list().empty()) fail("read in spite of: %s", errors.list().front().what());
  } catch (const robots::InputError& error) {
    errors.keep(error);
  }
  try {
    auto loaded = load(static_cast<robots::InputErrors*>(nullptr));
    if (!errors.list().empty()) fail("only going on finds: %s", errors.list().front().what());
    return loaded;
  } catch (const robots::InputError& error) {
    if (errors.list().empty() || std::string(errors.list().front().what()) != error.what())
      fail("going on does not begin with: %s", error.what());
    throw;
  }
}

}  // namespace leeway::fuzz
