#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

namespace leeway::tools {

/// Warnings of a run that reads many files, to stderr. Of those that say the same of other files or
/// lines only the first is printed when it comes: a hundred scenes of one robot tend to share what
/// is odd about them. What followed is counted.
class WarningLog {
 public:
  /// Each warning once, in order, as "warning: file:line: text".
  void print(const std::vector<std::string>& warnings);
  /// One line for each text that came again, with how often and the file and line of the last.
  void printCounts() const;

 private:
  struct Followers {
    std::set<std::string> places;
    std::string last;
  };
  std::map<std::string, Followers> texts_;
};

}  // namespace leeway::tools
