#pragma once

#include <string>
#include <vector>

namespace leeway::tools {

/// One problem of a batch. `problem` is its name in the output: the problem file's or the scene
/// file's path.
struct BatchItem {
  std::string problem;
  std::string request;  ///< empty for a problem file
  std::string error;    ///< not empty: it cannot even be started (a scene without request, ...)
};

/// Problem files and folders of them (every .yaml below with the key `leeway` and .cfg with
/// [problem], the others are named on stderr), sorted within each input. Throws robots::InputError
/// for an input that does not exist or a folder without problems.
std::vector<BatchItem> listProblems(const std::vector<std::string>& inputs);

/// MoveIt scene files and folders of scene and request files (sceneNNNN.yaml, requestNNNN.yaml),
/// paired by number within their folder, sorted by folder and number. A scene or request that has
/// no partner is an item with an error. Throws like listProblems().
std::vector<BatchItem> listMoveitProblems(const std::vector<std::string>& inputs);

/// Every N-th item from the i-th for "i/N". Throws robots::InputError when `shard` is not that. 0/N
/// and N/N are the same shard, so that counting from 0 or from 1 both give a partition.
std::vector<BatchItem> selectShard(const std::vector<BatchItem>& items, const std::string& shard);

}  // namespace leeway::tools
