#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// What every target defines, for libFuzzer and for the driver here: runs one input, aborts when
/// something is wrong, returns 0.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace leeway::fuzz {

/// Inputs for the driver to alter; none: the driver makes random bytes.
std::vector<std::string> seedInputs();
/// Words for the driver to sprinkle over the altered inputs.
std::vector<std::string> dictionary();

}  // namespace leeway::fuzz
