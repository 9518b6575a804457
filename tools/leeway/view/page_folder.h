#pragma once

#include <string>

#include "tools/leeway/view/page.h"

namespace leeway::tools::view {

/// One page of a folder, and its entry in the index. Both are empty without a page.
struct FolderPage {
  std::string html, entry;
  bool good = false;  ///< as Subject's
};
/// May be called by several threads.
FolderPage folderPage(const Subject& subject);

/// Writes a page for each of many problems, and an index with their pictures.
class PageFolder {
 public:
  /// Makes the folder. Writes nothing if `folder` is empty. Throws robots::InputError if the folder
  /// cannot be made, and as expectPage() does.
  explicit PageFolder(const std::string& folder);
  /// Writes the next page. Its file has its number as name, because a problem's name may not suit a
  /// file.
  void add(const FolderPage& page);
  /// Writes index.html.
  void finish() const;

 private:
  std::string folder_, entries_;
  int count_ = 0, good_ = 0;
};

}  // namespace leeway::tools::view
