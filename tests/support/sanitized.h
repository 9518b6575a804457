#pragma once

#include <cstdlib>

namespace leeway {

/// True under AddressSanitizer or ThreadSanitizer. Sanitizers check memory accesses, which all
/// cases of a kind share, at ten times the cost or more. Tests of thousands of random answers
/// therefore run fewer cases of every kind. The release build runs all.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif
#else
inline constexpr bool kSanitized = false;
#endif

/// True if LEEWAY_TEST_BRIEF is set: the tests that take longest under sanitizers run fewer cases.
/// tools/test sets it for its sanitized tests; tools/test --full does not.
inline bool isBrief() {
  static const bool brief = std::getenv("LEEWAY_TEST_BRIEF") != nullptr;
  return brief;
}

/// `brief` if isBrief(); otherwise `sanitized` under sanitizers and `plain` in the release build.
template <class T>
T bySanitizer(const T& plain, const T& sanitized, const T& brief) {
  return isBrief() ? brief : kSanitized ? sanitized : plain;
}

/// Number of random cases to run out of `count`: all, or a tenth under sanitizers, but at least
/// one.
constexpr int casesToAsk(int count) {
  return !kSanitized || count <= 1 ? count : count / 10 + (count % 10 != 0 ? 1 : 0);
}

}  // namespace leeway
