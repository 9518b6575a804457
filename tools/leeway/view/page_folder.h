#pragma once

#include <string>

#include "tools/leeway/view/page.h"

namespace leeway::tools::view {

/// One page of a folder, and what the index says of it. Empty: none.
struct FolderPage {
  std::string html, entry;
  bool good = false;  ///< as Subject's
};
/// May be called by several threads.
FolderPage folderPage(const Subject& subject);

/// A page of each of many problems, and an index with their pictures.
class PageFolder {
 public:
  /// Makes the folder, unless `folder` is empty: then nothing is written. Throws robots::InputError
  /// where it cannot be made, and as expectPage().
  explicit PageFolder(const std::string& folder);
  /// Writes the next page, named by its number, so that names of problems name no files.
  void add(const FolderPage& page);
  /// Writes index.html.
  void finish() const;

 private:
  std::string folder_, entries_;
  int count_ = 0, good_ = 0;
};

}  // namespace leeway::tools::view
