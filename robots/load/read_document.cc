#include "robots/load/read_document.h"

#include "robots/mjcf/mjcf.h"
#include "robots/sdf/sdf.h"

namespace leeway::robots {

UrdfDocument readDocument(XmlFile& file, const LoadOptions& options, bool with_visuals) {
  return isMjcf(file)  ? readMjcf(file, options, with_visuals)
         : isSdf(file) ? readSdf(file, options, with_visuals)
                       : readUrdf(file, options, with_visuals);
}

}  // namespace leeway::robots
