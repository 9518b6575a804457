#pragma once

// Private to robots/: proven gaps as bytes, so that they need not be proven again.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "leeway/robots/model.h"

namespace leeway::robots {

/// O(size of the gaps).
std::vector<std::byte> bytesOf(std::span<const LinkGap> gaps);

/// The gaps that bytesOf() wrote. Nothing where the bytes are none, or name a link or joint that
/// the model does not have.
std::optional<std::vector<LinkGap>> gapsFromBytes(std::span<const std::byte> bytes,
                                                  const Model& model);

}  // namespace leeway::robots
