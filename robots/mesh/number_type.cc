#include "robots/mesh/number_type.h"

#include <cstdint>
#include <utility>

#include "robots/mesh/scan.h"

namespace leeway::robots {

std::optional<NumberType> plyType(std::string_view word) {
  using Kind = NumberType::Kind;
  static constexpr std::pair<std::string_view, NumberType> kTypes[] = {
      {"char", {Kind::kSigned, 1}},     {"int8", {Kind::kSigned, 1}},
      {"uchar", {Kind::kUnsigned, 1}},  {"uint8", {Kind::kUnsigned, 1}},
      {"short", {Kind::kSigned, 2}},    {"int16", {Kind::kSigned, 2}},
      {"ushort", {Kind::kUnsigned, 2}}, {"uint16", {Kind::kUnsigned, 2}},
      {"int", {Kind::kSigned, 4}},      {"int32", {Kind::kSigned, 4}},
      {"uint", {Kind::kUnsigned, 4}},   {"uint32", {Kind::kUnsigned, 4}},
      {"float", {Kind::kFloat, 4}},     {"float32", {Kind::kFloat, 4}},
      {"double", {Kind::kFloat, 8}},    {"float64", {Kind::kFloat, 8}}};
  for (const auto& [name, type] : kTypes)
    if (word == name) return type;
  return std::nullopt;
}

double loadNumber(const std::byte* from, NumberType type, std::endian order) {
  const auto whole = [&]<class Signed, class Unsigned>(Signed, Unsigned) {
    return type.kind == NumberType::Kind::kSigned
               ? static_cast<double>(loadNumber<Signed>(from, order))
               : static_cast<double>(loadNumber<Unsigned>(from, order));
  };
  if (type.kind == NumberType::Kind::kFloat)
    return type.size == 4 ? static_cast<double>(loadNumber<float>(from, order))
                          : loadNumber<double>(from, order);
  switch (type.size) {
    case 1:
      return whole(std::int8_t{}, std::uint8_t{});
    case 2:
      return whole(std::int16_t{}, std::uint16_t{});
    case 4:
      return whole(std::int32_t{}, std::uint32_t{});
    default:
      return whole(std::int64_t{}, std::uint64_t{});
  }
}

}  // namespace leeway::robots
