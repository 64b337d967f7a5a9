#include <stdexcept>

#include "perception/cloud/clusters.h"

namespace cousin {

Clusters cluster_as_paper(const Cloud&, const PaperClusterConfig&, Rng, const Eigen::Vector3d&) {
  throw std::runtime_error(
      "the paper's clusters are not built in: configure with -DWITH_PCL=ON (libpcl-dev)");
}

}  // namespace cousin
