#pragma once

#include <cstddef>

namespace leeway::python {

/// Indices of joints and bodies are int; containers need std::size_t.
constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace leeway::python
