#pragma once

#include <string>
#include <vector>

namespace leeway::tools {

/// One problem of a batch. `problem` is its name in the output: the path of the problem file or of
/// the scene file.
struct BatchItem {
  std::string problem;
  std::string request;  ///< empty for a problem file
  std::string error;    ///< why it cannot be started (a scene without request, ...); else empty
};

/// Lists problem files and the problem files in folders, sorted within each input. A folder's
/// problems are all .yaml files below it with the key `leeway` and all .cfg files with [problem];
/// its other such files are named on stderr. Throws robots::InputError for an input that does not
/// exist or a folder without problems.
std::vector<BatchItem> listProblems(const std::vector<std::string>& inputs);

/// Lists MoveIt scene files and folders of scene and request files (sceneNNNN.yaml,
/// requestNNNN.yaml), paired by number within their folder, sorted by folder and number. A scene or
/// request without a partner is an item with an error. Throws as listProblems() does.
std::vector<BatchItem> listMoveitProblems(const std::vector<std::string>& inputs);

/// Returns every N-th item from the i-th for "i/N". Throws robots::InputError for any other text.
/// 0/N and N/N are the same shard, so that counting from 0 and counting from 1 both give a
/// partition.
std::vector<BatchItem> selectShard(const std::vector<BatchItem>& items, const std::string& shard);

}  // namespace leeway::tools
