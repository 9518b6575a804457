#include "robots/base/read_on.h"

namespace leeway::robots {

void throwOrKeep(const InputError& error, InputErrors* errors) {
  if (errors == nullptr || !errors->keep(error)) throw InputError(error);
}

}  // namespace leeway::robots
