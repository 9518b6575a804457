#pragma once

// Private to robots/: what is found out about pairs of links, in parallel, and kept on disk.

#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "leeway/collision/shape.h"
#include "leeway/robots/model.h"
#include "robots/cache/content_key.h"

namespace leeway::robots {

/// Adds what answers about links depend on: joints and their limits, and the shapes of all links.
/// `addSurface` adds that of a mesh or hull. False where it is, or where a shape deforms.
bool addModel(const Model& model, const std::function<bool(const collision::Shape&)>& addSurface,
              ContentKey& key);

/// A question about pairs of links. Its answer is a number below kMost that depends on the model
/// alone.
struct DecidePair {
  static constexpr unsigned char kMost = 8;
  const char* kind;  ///< names the question in the cache
  const char* what;  ///< "links were proven apart", of a Stopped
  /// Called from several threads, for each pair once.
  std::function<unsigned char(const std::pair<int, int>&)> decide;
};

/// Returns the number of each pair, from the model's cache folder where it is kept. The numbers do
/// not depend on threads or on the cache. Throws Stopped. One call a pair, and one pass over the
/// links' vertices for the key.
std::vector<unsigned char> decidePairs(const Model& model,
                                       std::span<const std::pair<int, int>> pairs,
                                       const DecidePair& question, const Stop& stop);

}  // namespace leeway::robots
