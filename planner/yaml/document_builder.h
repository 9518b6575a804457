#pragma once

// Private to planner/yaml: appends the nodes of a document, parents first.

#include <fmt/format.h>

#include <vector>

#include "leeway/robots/input_error.h"
#include "planner/yaml/yaml_document.h"

namespace leeway::planner {

class YamlDocument::Builder {
 public:
  explicit Builder(YamlDocument& document) : document_(document) {}

 protected:
  /// A new entry of the open list or map, from `line`. The reference holds until the next one.
  YamlNode& add(YamlNode::Kind kind, int line) {
    std::vector<YamlNode>& nodes = document_.nodes_;
    if (nodes.size() % 4096 == 0) robots::throwIfStopped(document_.stop_, "files were read");
    const auto index = static_cast<YamlIndex>(nodes.size());
    YamlNode node;
    node.kind = kind;
    node.line = line;
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
    return nodes.back();
  }
  YamlIndex last() const { return static_cast<YamlIndex>(document_.nodes_.size()) - 1; }

  /// Later nodes are entries of the last one, until close().
  void open() {
    if (open_.size() >= kDeepestYaml)
      throw robots::InputError(
          document_.file_, document_.nodes_.back().line,
          fmt::format("lists and maps stand in each other {} deep; at most {} is expected",
                      open_.size() + 1, kDeepestYaml));
    open_.push_back({last(), -1});
  }
  void close() { open_.pop_back(); }

  YamlDocument& document_;

 private:
  struct Open {
    YamlIndex node, last;  // last: its last entry so far; -1: none
  };
  std::vector<Open> open_;
};

}  // namespace leeway::planner
