#include "tools/view/pack.h"

#include <zlib.h>

#include <bit>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <type_traits>

#include "tools/view/base/json_text.h"

namespace leeway::tools::view {
namespace {

constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string base64(const std::string& bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      word = word << 8U | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? kDigits[word >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

std::string compressed(const std::string& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string result(size, '\0');
  const int status = compress2(std::bit_cast<Bytef*>(result.data()), &size,
                               std::bit_cast<const Bytef*>(bytes.data()),
                               static_cast<uLong>(bytes.size()), Z_DEFAULT_COMPRESSION);
  if (status == Z_MEM_ERROR) throw std::bad_alloc();
  if (status != Z_OK) throw std::logic_error("zlib does not compress");
  result.resize(size);
  return result;
}

}  // namespace

template <class Number>
Json Pack::addPlanes(const char* type, std::span<const Number> values) {
  static_assert(std::endian::native == std::endian::little);
  Json reference = {{"type", type}, {"at", bytes_.size()}, {"count", values.size()}};
  const std::size_t first = bytes_.size();
  bytes_.resize(first + sizeof(Number) * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    char number[sizeof(Number)];
    std::memcpy(number, &values[i], sizeof(Number));
    for (std::size_t plane = 0; plane < sizeof(Number); ++plane) {
      bytes_[first + plane * values.size() + i] = number[plane];
    }
  }
  return reference;
}

template <class Number>
Json Pack::addDifferences(const char* type, std::span<const Number> values,
                          std::span<const std::size_t> strides) {
  std::vector<Number> packed(values.begin(), values.end());
  for (const std::size_t stride : strides) {
    for (std::size_t i = packed.size(); i-- > stride;) {
      packed[i] = static_cast<Number>(packed[i] - packed[i - stride]);
    }
  }
  if (!strides.empty()) {
    constexpr int kSign = std::numeric_limits<Number>::digits - 1;
    for (Number& x : packed) {
      x = static_cast<Number>((static_cast<std::uint32_t>(x) << 1U) ^
                              (x >> kSign != 0 ? std::numeric_limits<Number>::max() : 0U));
    }
  }
  Json reference = addPlanes<Number>(type, packed);
  if (!strides.empty()) {
    reference["strides"] = std::vector<std::size_t>(strides.begin(), strides.end());
  }
  return reference;
}

Json Pack::add(std::span<const float> values) { return addPlanes("f32", values); }
Json Pack::add(std::span<const double> values) { return addPlanes("f64", values); }
Json Pack::add(std::span<const std::uint8_t> values) { return addPlanes("u8", values); }
Json Pack::add(std::span<const std::uint16_t> values, std::span<const std::size_t> strides) {
  return addDifferences("u16", values, strides);
}
Json Pack::add(std::span<const std::uint32_t> values, std::span<const std::size_t> strides) {
  return addDifferences("u32", values, strides);
}

std::string Pack::text(const Json& document) const {
  const std::string header = jsonText(document);
  const auto size = static_cast<std::uint32_t>(header.size());
  std::string all(sizeof size, '\0');
  std::memcpy(all.data(), &size, sizeof size);
  return base64(compressed(all + header + bytes_));
}

}  // namespace leeway::tools::view
