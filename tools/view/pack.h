#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace leeway::tools::view {

using Json = nlohmann::ordered_json;

/// Arrays of numbers that accompany a JSON document, compressed. The bytes of an array are first
/// sorted into planes (all lowest bytes, all second bytes, ...), because these compress better.
/// tools/view/unpack.js reads the result.
class Pack {
 public:
  /// Appends an array and returns the value that refers to it in the document.
  Json add(std::span<const float> values);
  Json add(std::span<const double> values);
  Json add(std::span<const std::uint8_t> values);
  /// Stores whole numbers as differences from those `stride` places before, for each of `strides`
  /// in turn. Moves the sign to the lowest bit, so that small differences are small numbers.
  Json add(std::span<const std::uint16_t> values, std::span<const std::size_t> strides = {});
  Json add(std::span<const std::uint32_t> values, std::span<const std::size_t> strides = {});

  /// The document and all arrays, written with letters, digits, +, / and = only. No text of the
  /// document can therefore act as markup or script.
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
