// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The children of a node that a ray has yet to visit, nearest first, as one entry of the stack: as
// in Ylitie et al. (2017), "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
// BVHs", with the order of distances in place of that of octants.
#ifndef STILLRAY_RENDER_VULKAN_CHILD_GROUP_SHARED_H
#define STILLRAY_RENDER_VULKAN_CHILD_GROUP_SHARED_H

#ifdef __cplusplus
#include "render/vulkan/box_test_shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct ChildGroup {
  uint next;  // the next child, as EnterChildren gives it; kMissed: none is left
  // Index of the node, then in two bits each, from the lowest, the numbers of the two children
  // after the next one. Where no more follow, the last number is repeated.
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

// All children that the ray enters, but for the nearest.
// \param node     below 2^28
// \param entered  by EnterChildren
// \param nearest  [out] kMissed: none
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

// Without its next child; there must be one. Its distance counts for the others, which are not
// nearer.
SHARED_FN ChildGroup WithoutNext(ChildGroup group) {
  uint number = NumberOfChild(group.node);
  uint next = number == NumberOfChild(group.next) ? kMissed : (group.next & ~3u) | number;
  group.next = next;
  group.node = (group.node & ~3u) | NumberOfChild(group.node >> 2);
  return group;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_VULKAN_CHILD_GROUP_SHARED_H
