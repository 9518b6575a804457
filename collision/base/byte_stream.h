#pragma once

// Private to the library: flat arrays as bytes, in the machine's own layout. The files are read
// only by the build that wrote them.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace leeway::collision {

/// Whether a copy of T's bytes is a copy of T. (Eigen's vectors copy their numbers one by one, but
/// they contain nothing else.)
template <class T>
inline constexpr bool kIsFlat = std::is_trivially_destructible_v<T> && !std::is_pointer_v<T>;

/// Arrays begin at multiples of this [B].
inline constexpr std::size_t kArrayAlignment = 8;

/// Appends values and arrays to a vector of bytes.
class ByteWriter {
 public:
  template <class T>
  void value(const T& value) {
    static_assert(kIsFlat<T>);
    append(&value, sizeof(T));
  }
  /// Writes the number of elements, then the elements, aligned to kArrayAlignment.
  template <class T>
  void array(std::span<const T> values) {
    static_assert(kIsFlat<T>);
    value(static_cast<std::uint64_t>(values.size()));
    bytes_.resize((bytes_.size() + kArrayAlignment - 1) / kArrayAlignment * kArrayAlignment);
    if (!values.empty()) append(values.data(), values.size_bytes());
  }
  template <class T>
  void array(const std::vector<T>& values) {
    array(std::span<const T>(values));
  }
  void reserve(std::size_t bytes) { bytes_.reserve(bytes_.size() + bytes); }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void append(const void* data, std::size_t size) {
    const auto* const begin = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }
  std::vector<std::byte> bytes_;
};

/// Reads what a ByteWriter wrote. A value or array that exceeds the remaining bytes makes the
/// reader fail permanently: it then yields zeros and empty arrays. The caller decides which values
/// are plausible.
class ByteReader {
 public:
  /// The bytes must outlive the reader and all spans that view() returned.
  explicit ByteReader(std::span<const std::byte> bytes)
      : begin_(bytes.data()),
        rest_(bytes),
        failed_(reinterpret_cast<std::uintptr_t>(bytes.data()) % kArrayAlignment != 0) {}

  template <class T>
  T value() {
    static_assert(kIsFlat<T>);
    T result{};
    copy(&result, sizeof(T));
    return result;
  }
  template <class T>
  std::vector<T> array() {
    const std::span<const T> values = view<T>();
    return {values.begin(), values.end()};
  }
  /// Returns an array in place, without a copy.
  template <class T>
  std::span<const T> view() {
    static_assert(kIsFlat<T> && alignof(T) <= kArrayAlignment);
    const auto count = value<std::uint64_t>();
    const auto used = static_cast<std::size_t>(rest_.data() - begin_);
    skip((kArrayAlignment - used % kArrayAlignment) % kArrayAlignment);
    if (count > rest_.size() / sizeof(T)) failed_ = true;
    if (failed_ || count == 0) return {};
    const auto* const first = reinterpret_cast<const T*>(rest_.data());
    skip(static_cast<std::size_t>(count) * sizeof(T));
    return {first, static_cast<std::size_t>(count)};
  }
  bool failed() const { return failed_; }
  bool atEnd() const { return !failed_ && rest_.empty(); }

 private:
  void copy(void* to, std::size_t size) {
    if (size <= rest_.size() && !failed_) std::memcpy(to, rest_.data(), size);
    skip(size);
  }
  void skip(std::size_t size) {
    if (size > rest_.size()) failed_ = true;
    if (!failed_) rest_ = rest_.subspan(size);
  }
  const std::byte* begin_;
  std::span<const std::byte> rest_;
  bool failed_;
};

}  // namespace leeway::collision
