#include "robots/mesh/mesh_source.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <utility>

#include "leeway/robots/input_error.h"
#include "robots/base/read_file.h"

namespace leeway::robots {
namespace {

constexpr std::string_view kAccepted = "an intact STL, OBJ, PLY, DAE or glTF file";

char lowered(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

bool beginsWith(std::string_view text, std::string_view lower_case) {
  return text.size() >= lower_case.size() &&
         std::equal(lower_case.begin(), lower_case.end(), text.begin(),
                    [](char a, char b) { return a == lowered(b); });
}

}  // namespace

std::string FilePlace::text() const {
  if (code_ == 0) return "";
  return code_ > 0 ? ":" + std::to_string(code_) : ", byte " + std::to_string(-1 - code_);
}

MeshSource::MeshSource(std::string path, std::string referrer, int referrer_line, const Stop& stop)
    : path_(std::move(path)),
      referrer_(std::move(referrer)),
      referrer_line_(referrer_line),
      stop_(stop) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path_, error))
    fail(std::string(std::filesystem::exists(path_, error) ? "is a folder or a device"
                                                           : "is not there") +
         "; the path of a mesh file (STL, OBJ, PLY, DAE, glTF) would be accepted");
  std::ifstream stream(path_, std::ios::binary);
  const std::uintmax_t size = std::filesystem::file_size(path_, error);
  if (!error) contents_ = collision::LargeBuffer(static_cast<std::size_t>(size));
  if (error ||
      !stream.read(reinterpret_cast<char*>(contents_.data()), static_cast<std::streamsize>(size)))
    fail("cannot be read; " + std::string(kAccepted) + " would be accepted");
  std::string_view begin = text();
  begin.remove_prefix(std::min(begin.find_first_not_of(" \t\r\n"), begin.size()));
  if (begin.empty()) fail("is empty; " + std::string(kAccepted) + " would be accepted");
  if (beginsWith(begin, "version https://git-lfs.github.com/"))
    fail("is a Git LFS pointer, not the mesh; `git lfs pull` in its repository fetches the mesh");
  // XHTML begins as any XML does.
  for (const auto& [first, last] : {std::pair<std::string_view, std::string_view>("<?", "?>"),
                                    std::pair<std::string_view, std::string_view>("<!--", "-->")})
    if (begin.starts_with(first)) {
      begin.remove_prefix(std::min(begin.find(last), begin.size() - last.size()) + last.size());
      begin.remove_prefix(std::min(begin.find_first_not_of(" \t\r\n"), begin.size()));
    }
  if (beginsWith(begin, "<!doctype html") || beginsWith(begin, "<html"))
    fail("is a web page (HTML), not the mesh; " + std::string(kAccepted) + " would be accepted");
}

std::string_view MeshSource::text() const {
  std::string_view text(reinterpret_cast<const char*>(contents_.data()), contents_.size());
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

std::string MeshSource::ending() const { return endingOf(path_); }

std::string MeshSource::where(FilePlace place) const {
  return "mesh " + path_ + place.text() + (place.code() == 0 ? " " : ": ");
}

void MeshSource::fail(const std::string& message) const { failAt({}, message); }

void MeshSource::failAt(FilePlace place, const std::string& message) const {
  throw InputError(referrer_, referrer_line_, where(place) + message);
}

std::string MeshSource::warning(const MeshNote& note) const {
  return InputError(referrer_, referrer_line_, where(note.place) + note.text).what();
}

void MeshSource::pause() const {
  if (stop_ && stop_()) throw Stopped("stopped while mesh " + path_ + " was read");
}

std::string shown(std::string_view word) {
  constexpr std::size_t kMost = 40;
  std::string text = "'";
  for (const char c : word.substr(0, kMost)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > kMost ? "...'" : "'");
}

}  // namespace leeway::robots
