#pragma once

// Private to robots/.

namespace leeway::robots {

/// A digest of the library's version and of the sources of collision/ and robots/, as they are
/// built: what another build kept on disk is not found. (A number that a programmer must remember
/// to raise would be forgotten.) tools/cmake/fingerprint.cmake writes its definition.
extern const char* const kFingerprint;

}  // namespace leeway::robots
