#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

namespace leeway::tools {

/// Warnings on stderr of a run that reads many files. Many scenes of one robot often have the same
/// warnings. So if warnings differ only in file or line, only the first is printed, and the others
/// are counted.
class WarningLog {
 public:
  /// Prints each warning once, in order, as "warning: file:line: text".
  void print(const std::vector<std::string>& warnings);
  /// Prints one line for each repeated text, with the count and the file and line of the last
  /// warning.
  void printCounts() const;

 private:
  struct Followers {
    std::set<std::string> places;
    std::string last;
  };
  std::map<std::string, Followers> texts_;
};

}  // namespace leeway::tools
