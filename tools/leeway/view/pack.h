#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace leeway::tools::view {

using Json = nlohmann::ordered_json;

/// Arrays of numbers beside a JSON document, packed so that little is left of them: the bytes of an
/// array stand in planes (all lowest bytes, all second ones, ...) and the whole is compressed.
/// tools/view/unpack.js reads it.
class Pack {
 public:
  /// Appends an array and returns what the document says in its place.
  Json add(std::span<const float> values);
  Json add(std::span<const double> values);
  Json add(std::span<const std::uint8_t> values);
  /// Whole numbers as differences, from those `stride` places before, for each of `strides` in
  /// turn; the sign is moved to the lowest bit, so that small differences are small numbers.
  Json add(std::span<const std::uint16_t> values, std::span<const std::size_t> strides = {});
  Json add(std::span<const std::uint32_t> values, std::span<const std::size_t> strides = {});

  /// The document and all arrays, in letters, digits, + / and = alone: whatever the document's
  /// texts hold, nothing in it can be markup or script.
  std::string text(const Json& document) const;

 private:
  template <class Number>
  Json addPlanes(const char* type, std::span<const Number> values);
  template <class Number>
  Json addDifferences(const char* type, std::span<const Number> values,
                      std::span<const std::size_t> strides);

  std::string bytes_;
};

}  // namespace leeway::tools::view
