#include "robots/mjcf/mjcf_file.h"

#include <utility>

namespace leeway::robots {

namespace {

using std::filesystem::path;

/// Files that include others many times over make models without end.
constexpr std::size_t kMostFiles = 1000;

path folderOf(const XmlFile& file) { return path(file.path()).parent_path(); }

bool isThere(const path& file) {
  std::error_code error;
  return std::filesystem::exists(file, error);
}

path wholePath(const path& file) {
  std::error_code error;
  const path whole = std::filesystem::weakly_canonical(file, error);
  return error ? file : whole;
}

}  // namespace

MjcfFile::MjcfFile(XmlFile& main, const LoadOptions& options)
    : main_(main), options_(options), errors_(options.errors) {
  files_.emplace(main.root().GetDocument(), &main);
  in_order_.push_back(&main);
  open_.insert(wholePath(main.path()));
  include(main, main.root());
}

void MjcfFile::failUnknown(const tinyxml2::XMLElement& at, const std::string& what,
                           const std::string& name, const std::vector<std::string>& known) const {
  const std::string nearest = suggestion(name, known);
  fail(at, "<" + std::string(at.Name()) + "> names the " + what + ' ' + inQuotes(name) +
               ", which is not defined; " +
               (nearest.empty() ? "the name of a " + what + " would be accepted" : nearest));
}

void MjcfFile::expectNoBodyIn(const tinyxml2::XMLElement& part) const {
  const std::string around = part.Name();
  eachChild(part, [&](const tinyxml2::XMLElement& e) {
    const std::string tag = e.Name();
    // Those of a class are values for others, those of a tendon name others.
    if (tag == "body" || (tag == "geom" && around != "default" && around != "spatial"))
      fail(e,
           "<" + tag + "> in <" + around + "> is not read; one in <worldbody> would be accepted");
    expectNoBodyIn(e);
  });
}

std::vector<std::string> MjcfFile::takeWarnings() {
  std::vector<std::string> all;
  for (XmlFile* file : in_order_)
    for (std::string& warning : file->takeWarnings()) all.push_back(std::move(warning));
  return all;
}

std::string MjcfFile::place(const tinyxml2::XMLElement& element, const std::string& file) const {
  if (path(file).is_absolute() || isThere(folderOf(main_) / file)) return file;
  const path beside = folderOf(of(element)) / file;
  return isThere(beside) ? std::filesystem::absolute(beside).string() : file;
}

void MjcfFile::include(XmlFile& file, const tinyxml2::XMLElement& element) {
  for (const tinyxml2::XMLElement* child = element.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    if (std::string_view(child->Name()) != "include") {
      include(file, *child);
      continue;
    }
    file.allowAttributes(*child, {"file"});
    if (child->FirstChildElement() != nullptr)
      file.fail(*child, "<include> has children; it would be accepted without");
    const std::string name = file.attribute(*child, "file");
    const path found = folderOf(main_) / place(*child, name);
    if (!isThere(found))
      file.fail(*child, "<include> names " + inQuotes(name) + ", and there is no " +
                            inQuotes(found.string()) + "; the path of a file would be accepted");
    if (!open_.insert(wholePath(found)).second)
      file.fail(*child, "<include> names " + inQuotes(name) +
                            ", which includes this file; files that do not contain themselves "
                            "would be accepted");
    if (in_order_.size() >= kMostFiles)
      file.fail(*child, "more than 1000 files are included; fewer would be accepted");
    auto read = std::make_unique<XmlFile>(found.string(), "MuJoCo", options_);
    XmlFile& included = *read;
    in_order_.push_back(&included);
    files_.emplace(included.root().GetDocument(), &included);
    included_.emplace(child, std::move(read));
    include(included, included.root());
    open_.erase(wholePath(found));
  }
}

}  // namespace leeway::robots
