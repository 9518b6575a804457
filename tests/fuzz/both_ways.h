#pragma once

#include <string>

#include "leeway/robots/input_error.h"
#include "tests/fuzz/shapes.h"

namespace leeway::fuzz {

/// Returns load(null), or throws its error. Fails unless load(&errors), which goes on after errors,
/// finds the same error first. Entries that are left out are in the list of `errors` only, and may
/// fill it.
template <class Load>
auto loadBothWays(const Load& load) {
  robots::InputErrors errors;
  try {
    load(&errors);
    if (errors.count() > 0) fail("read in spite of: %s", errors.kept(0).what());
  } catch (const robots::InputError& error) {
    errors.keep(error);
  }
  const bool is_full = errors.list().size() >= robots::InputErrors::kMost;
  try {
    auto loaded = load(static_cast<robots::InputErrors*>(nullptr));
    if (errors.count() > 0 && !is_full) fail("only going on finds: %s", errors.kept(0).what());
    return loaded;
  } catch (const robots::InputError& error) {
    if (!is_full && (errors.count() == 0 || std::string(errors.kept(0).what()) != error.what()))
      fail("going on does not begin with: %s", error.what());
    throw;
  }
}

}  // namespace leeway::fuzz
