#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// Entry point of every target, for libFuzzer and for driver.cc: runs one input, aborts on failure,
/// returns 0.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace leeway::fuzz {

/// Seeds for the driver to mutate; none: random bytes.
std::vector<std::string> seedInputs();
/// Words that the driver inserts into mutated inputs.
std::vector<std::string> dictionary();

}  // namespace leeway::fuzz
