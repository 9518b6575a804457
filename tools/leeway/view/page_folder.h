#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/view/subject.h"

namespace leeway::tools::view {

/// A page of a folder, its picture, and its least clearance. Empty: none.
struct FolderPage {
  std::string html, svg;
  std::string name;        ///< the problem's
  std::string clearance;   ///< "10.57 mm"; empty without a path, or where nothing is near
  double clearance_m = 0;  ///< to sort by
  std::string nearest;     ///< the pair that has it; empty as `clearance`
  double time = 0;         ///< when the motion has it [s]
  std::string verdict;
  std::string moment;  ///< for which it holds: "the obstacles stand as at 0 s"; else empty
  bool good = false;   ///< as Subject's
};
/// `visual`: the page also draws the robot's visual shapes; those that are left out are added to
/// `warnings`. May be called by several threads.
FolderPage folderPage(const Subject& subject, bool visual, std::vector<std::string>& warnings);

/// Writes a page for each of many problems, and an index of all of them that can be sorted.
class PageFolder {
 public:
  /// Makes the folder. Writes nothing if `folder` is empty. Throws robots::InputError if the folder
  /// cannot be made, and as expectPage() does.
  explicit PageFolder(const std::string& folder);
  /// Writes the next page, named by its number, so that names of problems name no files, and adds
  /// its row to the index. `problem`: its file, whose folder and name are the title. `line`: what
  /// `batch` says of it. Without a page the row has no link.
  void add(const std::string& problem, const nlohmann::ordered_json& line, const FolderPage& page);
  /// Writes index.html.
  void finish() const;

 private:
  std::string folder_, rows_;
  int count_ = 0, rows_count_ = 0, good_ = 0;
  double plan_s_ = 0, total_s_ = 0;
};

}  // namespace leeway::tools::view
