// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/motion_cache.h"

namespace stillray {

bool MotionCache::Restore(Frame* frame, MotionOrigin* origin) const {
  const auto at = entries_.find(frame->index);
  if (at == entries_.end()) {
    return false;
  }
  frame->guides.motion = at->second.motion;
  frame->confidence = at->second.confidence;
  *origin = at->second.origin;
  return true;
}

void MotionCache::Keep(const Frame& frame, const MotionOrigin& origin) {
  if (origin.kind != MotionKind::kEstimate) {
    return;
  }
  entries_.insert_or_assign(frame.index, Entry{frame.guides.motion, frame.confidence, origin});
  if (entries_.size() > most_) {
    entries_.erase(entries_.begin());
  }
}

}  // namespace stillray
