#include "planner/yaml/yaml_document.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <sstream>
#include <utility>

#include "leeway/robots/input_error.h"

namespace leeway::planner {

/// Appends nodes as yaml-cpp meets them, parents first.
class YamlDocument::Builder : public YAML::EventHandler {
 public:
  explicit Builder(YamlDocument& document) : document_(document) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add(YamlNode::Kind::kNull, mark, anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const YamlIndex target = anchors_[anchor];
    document_.nodes_[add(YamlNode::Kind::kAlias, mark, 0)].first = target;
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    YamlNode& scalar = document_.nodes_[add(YamlNode::Kind::kScalar, mark, anchor)];
    scalar.is_quoted = tag == "!";
    scalar.text = static_cast<std::int64_t>(document_.texts_.size());
    scalar.text_size = static_cast<std::int64_t>(value.size());
    document_.texts_ += value;
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(add(YamlNode::Kind::kList, mark, anchor));
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(add(YamlNode::Kind::kMap, mark, anchor));
  }
  void OnMapEnd() override { open_.pop_back(); }

 private:
  struct Open {
    YamlIndex node, last;  // last: its last entry so far; -1: none
  };

  std::size_t add(YamlNode::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    std::vector<YamlNode>& nodes = document_.nodes_;
    const auto index = static_cast<YamlIndex>(nodes.size());
    YamlNode node;
    node.kind = kind;
    node.line = mark.line + 1;  // yaml-cpp counts from 0
    if (!open_.empty()) {
      Open& parent = open_.back();
      YamlNode& of = nodes[static_cast<std::size_t>(parent.node)];
      node.parent = parent.node;
      node.place = of.count++;
      if (parent.last < 0)
        of.first = index;
      else
        nodes[static_cast<std::size_t>(parent.last)].next = index;
      parent.last = index;
    }
    nodes.push_back(node);
    if (anchor != 0) {  // yaml-cpp numbers them from 1
      if (anchors_.size() <= anchor) anchors_.resize(anchor + 1, -1);
      anchors_[anchor] = index;
    }
    return nodes.size() - 1;
  }
  void open(std::size_t node) { open_.push_back({static_cast<YamlIndex>(node), -1}); }

  YamlDocument& document_;
  std::vector<Open> open_;
  std::vector<YamlIndex> anchors_;
};

YamlDocument::YamlDocument(std::string file, const std::string& text) : file_(std::move(file)) {
  std::istringstream stream(text);
  try {
    YAML::Parser parser(stream);
    Builder builder(*this);
    if (parser.HandleNextDocument(builder)) {
      // Not by YAML::LoadAll: after a stray comma behind a document, that of yaml-cpp 0.7 returns
      // empty documents without end.
      YamlDocument other;
      Builder other_builder(other);
      if (parser.HandleNextDocument(other_builder))
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
  if (nodes_.empty()) nodes_.emplace_back();
}

std::string YamlDocument::where(YamlIndex i) const {
  const YamlNode& value = node(i);
  if (value.parent < 0) return "the file";
  const YamlNode& parent = node(value.parent);
  std::string above = where(value.parent);
  if (parent.kind == YamlNode::Kind::kList) return fmt::format("{}[{}]", above, value.place);
  YamlIndex key = parent.first;
  while (node(key).place + 1 < value.place) key = node(key).next;
  const std::string_view name = text(node(resolved(key)));
  return parent.parent < 0 ? std::string(name) : fmt::format("{}.{}", above, name);
}

}  // namespace leeway::planner
