#include "perception/cloud/clusters.h"
#include "sim/types/not_built.h"

namespace cousin {

Clusters cluster_as_paper(const Cloud&, const PaperClusterConfig&, Rng, const Eigen::Vector3d&) {
  throw NotBuilt("the paper's clusters are not built in; build them with: scripts/build pcl");
}

}  // namespace cousin
