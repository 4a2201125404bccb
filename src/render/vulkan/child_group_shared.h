// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The unvisited children of a node, nearest first, as one entry of the traversal stack: as in
// Ylitie et al. (2017), "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs",
// but ordered by distance instead of octant.
#ifndef STILLRAY_RENDER_VULKAN_CHILD_GROUP_SHARED_H
#define STILLRAY_RENDER_VULKAN_CHILD_GROUP_SHARED_H

#ifdef __cplusplus
#include "render/vulkan/box_test_shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct ChildGroup {
  uint next;  // the next child in the format of EnterChildren; kMissed: none is left
  // Upper bits: index of the node. The four lowest bits: indices of the two children after the next
  // one, in two bits each; the last index is repeated if fewer follow.
  uint node;
};
const int kGroupNodeShift = 4;

SHARED_FN uint NumberOfChild(uint entered) {
  return entered & 3u;
}
SHARED_FN float DistanceOfChild(uint entered) {
  return uintBitsToFloat(entered & ~3u);
}
SHARED_FN uint NodeOfGroup(ChildGroup group) {
  return group.node >> kGroupNodeShift;
}

// All intersected children except for the nearest.
// \param node     index of the node, below 2^28
// \param entered  result of EnterChildren
// \param nearest  [out] the nearest child; kMissed: none
SHARED_FN ChildGroup GroupChildren(uint node, SHARED_IN(uvec4) entered,
                                   SHARED_INOUT(uint) nearest) {
  uint a = min(entered.x, entered.y);
  uint b = max(entered.x, entered.y);
  uint c = min(entered.z, entered.w);
  uint d = max(entered.z, entered.w);
  nearest = min(a, c);
  uint second = min(max(a, c), min(b, d));
  uint third = max(max(a, c), min(b, d));
  uint last = max(b, d);
  third = third == kMissed ? second : third;
  last = last == kMissed ? third : last;
  ChildGroup group;
  group.next = second;
  group.node = node << kGroupNodeShift | NumberOfChild(third) | NumberOfChild(last) << 2;
  return group;
}

// Removes the next child, which must exist. Its distance remains the lower bound for the others.
SHARED_FN ChildGroup WithoutNext(ChildGroup group) {
  uint number = NumberOfChild(group.node);
  uint next = number == NumberOfChild(group.next) ? kMissed : (group.next & ~3u) | number;
  group.next = next;
  group.node = (group.node & ~3u) | NumberOfChild(group.node >> 2);
  return group;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_VULKAN_CHILD_GROUP_SHARED_H
