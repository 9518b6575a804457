#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <sstream>
#include <utility>

#include "planner/yaml/document_builder.h"

namespace leeway::planner {

namespace {

/// `ros2 topic echo` ends each message with a line `---`, which begins another document. This is
/// the text without such a line at its end.
std::string withoutEndMark(const std::string& text) {
  const std::size_t last = text.find_last_not_of(" \t\r\n");
  const std::size_t line = last == std::string::npos ? last : text.rfind('\n', last);
  if (line == std::string::npos || text.compare(line + 1, last - line, "---") != 0) return text;
  return text.substr(0, line + 1);
}

}  // namespace

/// Handles the events of yaml-cpp. Its marks count lines from 0.
class YamlDocument::YamlEvents : public Builder, public YAML::EventHandler {
 public:
  using Builder::Builder;

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    addAnchored(YamlNode::Kind::kNull, mark, anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add(YamlNode::Kind::kAlias, mark.line + 1).first = anchors_[anchor];
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    YamlNode& scalar = addAnchored(YamlNode::Kind::kScalar, mark, anchor);
    scalar.is_quoted = tag == "!";
    scalar.is_tagged =
        !tag.empty() && tag != "?" && tag != "!" && !tag.starts_with("tag:yaml.org,2002:");
    scalar.text = static_cast<std::int64_t>(document_.texts_.size());
    scalar.text_size = static_cast<std::int64_t>(value.size());
    document_.texts_ += value;
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    addAnchored(YamlNode::Kind::kList, mark, anchor);
    open();
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    addAnchored(YamlNode::Kind::kMap, mark, anchor);
    open();
  }
  void OnMapEnd() override { close(); }

 private:
  YamlNode& addAnchored(YamlNode::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    YamlNode& node = add(kind, mark.line + 1);
    if (anchor != 0) {  // yaml-cpp numbers them from 1
      if (anchors_.size() <= anchor) anchors_.resize(anchor + 1, -1);
      anchors_[anchor] = last();
    }
    return node;
  }

  std::vector<YamlIndex> anchors_;
};

YamlDocument::YamlDocument(std::string file, std::string text, const robots::Stop& stop,
                           robots::InputErrors* errors)
    : file_(std::move(file)), stop_(stop), errors_(errors) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  const bool may_be_json = first != std::string::npos && (text[first] == '{' || text[first] == '[');
  int error_line = 0;
  if (may_be_json && parseJson(text, error_line)) {
    stop_ = {};
    return;
  }
  if (text.size() > kLongestYaml)
    throw robots::InputError(
        file_, error_line,
        may_be_json ? fmt::format("is no JSON from here on; beyond {} MiB only JSON is expected",
                                  kLongestYaml >> 20)
                    : fmt::format("holds {} MiB of YAML; at most {} is expected, or JSON",
                                  text.size() >> 20, kLongestYaml >> 20));
  parseYaml(text);
  stop_ = {};
  if (nodes_.empty()) nodes_.emplace_back();
}

void YamlDocument::parseYaml(const std::string& text) {
  std::istringstream stream(withoutEndMark(text));
  try {
    YAML::Parser parser(stream);
    YamlEvents events(*this);
    if (parser.HandleNextDocument(events)) {
      // Does not use YAML::LoadAll: after a stray comma behind a document, that of yaml-cpp 0.7
      // returns empty documents without end.
      YamlDocument other;
      YamlEvents other_events(other);
      if (parser.HandleNextDocument(other_events))
        throw robots::InputError(
            file_, 0,
            "holds 2 YAML documents or more, or text that belongs to none; exactly one is "
            "expected");
    }
  } catch (const YAML::Exception& error) {
    throw robots::InputError(
        file_, error.mark.is_null() ? 0 : error.mark.line + 1,
        fmt::format("YAML syntax error: {}; well-formed YAML is expected", error.msg));
  }
}

}  // namespace leeway::planner
