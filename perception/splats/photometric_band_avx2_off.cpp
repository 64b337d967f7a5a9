#include "perception/splats/photometric_band.h"

namespace cousin::photometric {

BandKernel loss_band_avx2() { return nullptr; }

}  // namespace cousin::photometric
