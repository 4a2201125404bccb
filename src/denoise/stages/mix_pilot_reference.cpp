// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/mix_pilot.h"

namespace stillray::reference {

void MixPilot(const MixPilotInput& in, float full, Image1* luminance, Image1* variance) {
  for (int y = 0; y < luminance->height(); ++y) {
    for (int x = 0; x < luminance->width(); ++x) {
      const float share = PilotShare((*in.length)(x, y), full);
      const float own = (*in.luminance)(x, y);
      (*luminance)(x, y) = own + share * ((*luminance)(x, y) - own);
      (*variance)(x, y) = PilotVariance((*in.variance)(x, y), (*variance)(x, y), share);
    }
  }
}

}  // namespace stillray::reference
