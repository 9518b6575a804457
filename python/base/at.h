#pragma once

#include <cstddef>

namespace leeway::python {

/// Numbers of joints and bodies are int; containers want std::size_t.
constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace leeway::python
