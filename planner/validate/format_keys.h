#pragma once

#include <span>
#include <string_view>

#include "leeway/planner/settings.h"

namespace leeway::planner {

/// The keys of one kind of map in a problem file. The loader has no other list of them. Keys that
/// are settings come from the table of settings. A test compares this list with
/// problems/schema.json, which has each kind under this name (the file itself at its top).
struct MapFormat {
  std::string_view name;
  std::span<const std::string_view> keys;
};

/// All kinds, "problem" (the file itself) first.
std::span<const MapFormat> mapFormats();

/// The keys of one kind; `name` must be one of mapFormats().
std::span<const std::string_view> keysOf(std::string_view name);

/// The key of a setting as seen from the map at `place` (empty: the file itself): "time" for
/// "limits.time" in "limits". Empty: the setting is not in that map.
std::string_view keyIn(std::string_view place, const Setting& setting);

/// The words of shapes, each of which is a kind of map too.
std::span<const std::string_view> shapeWords();

}  // namespace leeway::planner
