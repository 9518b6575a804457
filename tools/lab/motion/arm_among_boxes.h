#pragma once

#include <memory>
#include <vector>

#include "leeway/robots/model.h"
#include "tools/lab/motion/family_maker.h"

namespace leeway::tools::report::motion_families {

/// Seven links among five boxes.
class ArmAmongBoxes {
 public:
  ArmAmongBoxes();
  void add(FamilyMaker& make);

 private:
  std::shared_ptr<const robots::Model> model_;
  Body link_;
};

}  // namespace leeway::tools::report::motion_families
