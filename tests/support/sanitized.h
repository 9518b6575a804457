#pragma once

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

/// Number of random cases to run out of `count`: all, or a tenth under sanitizers, but at least
/// one.
constexpr int casesToAsk(int count) {
  return !kSanitized || count <= 1 ? count : count / 10 + (count % 10 != 0 ? 1 : 0);
}

}  // namespace leeway
