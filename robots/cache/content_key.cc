#include "robots/cache/content_key.h"

// The EVP functions of OpenSSL 3.0 crash where memory ends as they are first called. These neither
// allocate nor fail.
#define OPENSSL_SUPPRESS_DEPRECATED
#include <openssl/sha.h>

#include <Eigen/Core>
#include <array>
#include <cfenv>
#include <cstdint>
#include <limits>

#include "robots/cache/fingerprint.h"

namespace leeway::robots {

namespace {

/// Whether numbers round to the nearest and small ones are kept. What is built in any other mode
/// differs, and bounds may rest on it: it is neither kept nor taken.
bool isUsualArithmetic() {
  volatile double least = std::numeric_limits<double>::min();
  volatile double half = least / 2, whole = half + half;
  return std::fegetround() == FE_TONEAREST && half > 0 && whole == least;
}

}  // namespace

struct ContentKey::Digest {
  SHA256_CTX context{};
  bool ok = isUsualArithmetic();

  Digest() { SHA256_Init(&context); }
  void add(const void* data, std::size_t size) { SHA256_Update(&context, data, size); }
};

ContentKey::ContentKey(std::string_view kind) : digest_(std::make_unique<Digest>()) {
  add(std::string_view(kFingerprint));
#if defined(__OPTIMIZE__) && defined(NDEBUG)
  constexpr std::uint32_t kBuild = 3;
#elif defined(__OPTIMIZE__)
  constexpr std::uint32_t kBuild = 1;
#else
  constexpr std::uint32_t kBuild = 0;
#endif
  const std::array<std::uint32_t, 6> platform = {
      EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
      EIGEN_MINOR_VERSION, kBuild,
      0x01020304,          static_cast<std::uint32_t>(sizeof(void*))};
  add(std::as_bytes(std::span(platform)));
  add(std::string_view(__VERSION__));
  add(kind);
}

ContentKey::~ContentKey() = default;

void ContentKey::add(std::span<const std::byte> bytes) {
  const auto size = static_cast<std::uint64_t>(bytes.size());
  digest_->add(&size, sizeof(size));
  digest_->add(bytes.data(), bytes.size());
}

std::string ContentKey::finish() {
  if (!digest_->ok) return {};
  digest_->ok = false;
  std::array<unsigned char, SHA256_DIGEST_LENGTH> result{};
  SHA256_Final(result.data(), &digest_->context);
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : result) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text;
}

}  // namespace leeway::robots
