#pragma once

namespace leeway {

/// True in a build with AddressSanitizer or ThreadSanitizer. Sanitizers look for what code does to
/// memory, which is alike in all cases of a kind, and make each ten times as dear or more: tests
/// that compare thousands of random answers ask fewer of each kind there, but none of no kind. The
/// release build asks all.
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

/// How many of `count` random cases of a kind are asked: all, or a tenth in a sanitized build, but
/// one at least.
constexpr int casesToAsk(int count) {
  return !kSanitized || count <= 1 ? count : count / 10 + (count % 10 != 0 ? 1 : 0);
}

}  // namespace leeway
