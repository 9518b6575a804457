#pragma once

#include <cstdint>
#include <cstdlib>

namespace leeway {

/// The number in an environment variable, for long runs: LEEWAY_TEST_SEED selects other random
/// cases; LEEWAY_TEST_PATHS, LEEWAY_TEST_CONTACTS, LEEWAY_TEST_UNIONS, LEEWAY_TEST_POLYGONS and
/// LEEWAY_TEST_QUERIES set their number.
inline std::uint64_t fromEnvironment(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

}  // namespace leeway
