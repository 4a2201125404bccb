// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Sampling from a discrete distribution in constant time: Vose (1991), "A linear algorithm for
// generating random numbers with a given distribution". A number in [0, 1) selects a column of the
// table, then one of the column's two items.
#ifndef STILLRAY_RENDER_ALIAS_SHARED_H
#define STILLRAY_RENDER_ALIAS_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct AliasEntry {
  float keep;         // probability of the entry itself, given its column
  uint other;         // the column's other item
  float probability;  // probability of this entry
  uint item;          // index whose meaning the table's owner defines
};

struct AliasColumn {
  uint index;
  float within;  // u remapped to [0, 1) within the column
};

struct AliasChoice {
  uint index;
  float rest;  // u remapped to [0, 1) within the item
};

SHARED_FN AliasColumn FindAliasColumn(uint count, float u) {
  float scaled = u * float(count);
  AliasColumn column;
  column.index = min(uint(scaled), count - 1u);
  column.within = min(scaled - float(column.index), kBelowOne);
  return column;
}

// \param entry  entry of the column
SHARED_FN AliasChoice ChooseInColumn(SHARED_IN(AliasColumn) column, SHARED_IN(AliasEntry) entry) {
  AliasChoice choice;
  if (column.within < entry.keep) {
    choice.index = column.index;
    choice.rest = min(column.within / entry.keep, kBelowOne);
  } else {
    choice.index = entry.other;
    choice.rest = min((column.within - entry.keep) / (1.0f - entry.keep), kBelowOne);
  }
  return choice;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_ALIAS_SHARED_H
