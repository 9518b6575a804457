#pragma once

#include <string>

namespace leeway::tools {

/// `leeway report cases FILE --raw OUT`: asks the engine for every case of `file` and writes one
/// line a case, `ID STATUS LOWER UPPER NS` (status as toString(); 17 digits; nanoseconds of the
/// query). Families seq-* keep a PairCache a track. OUT may be "-": stdout. Returns the exit status
/// 0; throws robots::InputError.
int runReportCases(const std::string& file, const std::string& raw_output);

/// `leeway report cases FILE --reference REFERENCE`: the same queries held against known truth.
/// Prints a table by family to stdout: cases, unsafe (the interval does not hold the truth),
/// failures (limits, invalid), wrong and open verdicts, widths. Returns 0 when nothing is unsafe or
/// wrong, else 1; throws robots::InputError.
int runReportCasesAgainst(const std::string& file, const std::string& reference);

}  // namespace leeway::tools
